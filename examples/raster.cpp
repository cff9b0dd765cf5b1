// SPDX-License-Identifier: MIT
#include "raster.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace {

using phymul::Colour;
using phymul::Vec3;

constexpr int samples_a_side = 3;  // of a pixel
constexpr double ambient = 0.5;    // share of the light that comes from everywhere
constexpr double glossiness = 40.0;

Vec3 rgb(const Colour& colour) {
  return {colour[0], colour[1], colour[2]};
}

}  // namespace

Raster::Raster(const phymul::Camera& camera, int width, int height)
    : camera_(camera),
      width_(samples_a_side * width),
      height_(samples_a_side * height),
      samples_(static_cast<std::size_t>(width_) * height_,
               Sample{std::numeric_limits<float>::infinity(), {255, 255, 255}}) {
  const phymul::CameraAxes axes = axes_of(camera);
  light_ = (axes.towards_eye + 0.7 * axes.up - 0.5 * axes.right).normalized();
  half_way_ = (light_ + axes.towards_eye).normalized();
}

Vec3 Raster::seen(const Vec3& place) const {
  return to_pixel(camera_, place, width_, height_);
}

/// Calls shade(weights) for each sample in the triangle that is nearer than what is there.
template <class Shade>
void Raster::fill(const std::array<Point, 3>& points, double opacity, Shade shade) {
  const Vec3 &a = points[0].seen, &b = points[1].seen, &c = points[2].seen;
  const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  if (area == 0.0) return;
  const auto clamped = [](double value, int most) { return static_cast<int>(std::clamp(value, 0.0, most - 1.0)); };
  const int left = clamped(std::min({a.x(), b.x(), c.x()}), width_),
            right = clamped(std::max({a.x(), b.x(), c.x()}), width_);
  const int top = clamped(std::min({a.y(), b.y(), c.y()}), height_),
            bottom = clamped(std::max({a.y(), b.y(), c.y()}), height_);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      Vec3 weight;
      weight[0] = ((b.x() - px) * (c.y() - py) - (b.y() - py) * (c.x() - px)) / area;
      weight[1] = ((c.x() - px) * (a.y() - py) - (c.y() - py) * (a.x() - px)) / area;
      weight[2] = 1.0 - weight[0] - weight[1];
      if (weight.minCoeff() < 0.0) continue;
      const auto depth = static_cast<float>(weight[0] * a.z() + weight[1] * b.z() + weight[2] * c.z());
      Sample& sample = samples_[static_cast<std::size_t>(y) * width_ + x];
      if (depth >= sample.depth) continue;
      sample.depth = depth;
      const Vec3 colour = shade(weight);
      for (int k = 0; k < 3; ++k) {
        const double mixed = opacity * 255.0 * std::clamp(colour[k], 0.0, 1.0) + (1.0 - opacity) * sample.colour[k];
        sample.colour[k] = static_cast<std::uint8_t>(mixed + 0.5);
      }
    }
  }
}

void Raster::triangle(const std::array<Corner, 3>& corners, double shine, double opacity) {
  std::array<Point, 3> points;
  for (int k = 0; k < 3; ++k) points[k] = {seen(corners[k].place), corners[k].normal, rgb(corners[k].colour)};
  fill(points, opacity, [&](const Vec3& weight) {
    Vec3 normal = Vec3::Zero(), colour = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      normal += weight[k] * points[k].normal;
      colour += weight[k] * points[k].colour;
    }
    normal.normalize();
    const double direct = std::abs(normal.dot(light_)), mirrored = std::abs(normal.dot(half_way_));
    const double glint = shine * std::pow(mirrored, glossiness);
    return Vec3((ambient + (1.0 - ambient) * direct) * colour + Vec3::Constant(glint));
  });
}

void Raster::line(const Vec3& from, const Vec3& to, const Colour& colour, double width, double nearer) {
  Vec3 a = seen(from), b = seen(to);
  const double length = std::hypot(b.x() - a.x(), b.y() - a.y());
  if (length == 0.0) return;
  a.z() -= nearer;
  b.z() -= nearer;
  const Vec3 along = Vec3(b.x() - a.x(), b.y() - a.y(), 0.0) / length;
  const double half = 0.5 * samples_a_side * width;
  const Vec3 across = half * Vec3(-along.y(), along.x(), 0.0);
  const auto point = [](const Vec3& at) { return Point{at, Vec3::Zero()}; };
  const auto flat = [&](const Vec3&) { return rgb(colour); };
  fill({point(a - across), point(b - across), point(b + across)}, colour[3], flat);
  fill({point(a - across), point(b + across), point(a + across)}, colour[3], flat);
}

void Raster::dashed_line(const Vec3& from, const Vec3& to, const Colour& colour, double width, double nearer,
                         double dash) {
  const Vec3 way = seen(to) - seen(from);
  const double length = std::hypot(way.x(), way.y()), pitch = 2.0 * samples_a_side * dash;
  const int count = std::max(1, static_cast<int>(std::lround(length / pitch)));
  for (int k = 0; k < count; ++k) {
    const double begin = (k + 0.25) / count, end = (k + 0.75) / count;
    line(from + begin * (to - from), from + end * (to - from), colour, width, nearer);
  }
}

phymul::Image Raster::image() const {
  phymul::Image image;
  image.width = width_ / samples_a_side;
  image.height = height_ / samples_a_side;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      std::array<int, 3> sum{};
      for (int j = 0; j < samples_a_side; ++j) {
        for (int i = 0; i < samples_a_side; ++i) {
          const std::size_t row = static_cast<std::size_t>(samples_a_side * y + j) * width_ + samples_a_side * x + i;
          for (int k = 0; k < 3; ++k) sum[k] += samples_[row].colour[k];
        }
      }
      for (const int s : sum) image.rgba.push_back(static_cast<std::uint8_t>(s / (samples_a_side * samples_a_side)));
      image.rgba.push_back(255);
    }
  }
  return image;
}

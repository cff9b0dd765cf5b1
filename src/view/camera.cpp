// SPDX-License-Identifier: MIT
#include <phymul/camera.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/decimal.h"

namespace phymul {
namespace {

constexpr double margin = 1.04;  // of the picture over the points' extent

/// Half of the picture's height in m, at this distance in front of the eye.
double half_height(const Camera& camera, double distance) {
  return camera.view_angle > 0.0 ? distance * std::tan(0.5 * camera.view_angle) : 0.5 * camera.view_height;
}

}  // namespace

CameraAxes axes_of(const Camera& camera) {
  const Vec3 back = camera.eye - camera.target;
  const Vec3 right = camera.up.cross(back);
  // Relative to what was given: a body may be micrometres or kilometres large.
  if (!(right.norm() > 1e-9 * camera.up.norm() * back.norm())) {
    throw Error(
        "Camera: expected an eye off the target, and an up vector across the view; got none of the one or other");
  }
  CameraAxes axes;
  axes.towards_eye = back.normalized();
  axes.right = right.normalized();
  axes.up = axes.towards_eye.cross(axes.right);
  return axes;
}

Camera framing(std::span<const Vec3> points, const Vec3& towards_eye, double aspect, double view_angle) {
  if (points.empty()) throw Error("framing: expected at least one point to look at");
  if (!(towards_eye.norm() > 0.0) || !(aspect > 0.0)) {
    throw Error("framing: expected a direction towards the eye that is not 0, and an aspect above 0");
  }
  if (!(view_angle >= 0.0 && view_angle < std::numbers::pi)) {
    throw Error("framing: expected a view_angle from 0 to below pi, got " + to_decimal(view_angle));
  }
  Camera camera;
  const Vec3 back = towards_eye.normalized();
  camera.up = std::abs(back.z()) > 0.99 ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ());
  camera.eye = back;  // axes_of looks at the direction alone
  const CameraAxes axes = axes_of(camera);
  Eigen::AlignedBox3d box;
  for (const Vec3& x : points) {
    if (!x.allFinite()) throw Error("framing: expected points of finite numbers, got " + place_text(x));
    box.extend(Vec3(axes.right.dot(x), axes.up.dot(x), back.dot(x)));
  }
  const Vec3 middle = box.center();
  const Vec3 size = box.sizes().cwiseMax(0.0);
  camera.target = middle.x() * axes.right + middle.y() * axes.up + middle.z() * back;
  camera.view_angle = view_angle;
  camera.view_height = margin * std::max(size.y(), size.x() / aspect);
  if (!(camera.view_height > 0.0)) camera.view_height = size.z() > 0.0 ? size.z() : 1.0;  // a point, or a line end on
  const double depth = std::max(size.z(), camera.view_height);
  // The front of the box must fit: it is seen largest.
  const double distance =
      view_angle > 0.0 ? 0.5 * camera.view_height / std::tan(0.5 * view_angle) + 0.5 * size.z() : 2.0 * depth;
  camera.eye = camera.target + distance * back;
  return camera;
}

Vec3 to_pixel(const Camera& camera, const Vec3& point, int width, int height) {
  const CameraAxes axes = axes_of(camera);
  const Vec3 from_eye = point - camera.eye;
  const double distance = -axes.towards_eye.dot(from_eye);
  const double scale = 0.5 * height / half_height(camera, distance);
  return {0.5 * width + scale * axes.right.dot(from_eye), 0.5 * height - scale * axes.up.dot(from_eye), distance};
}

Vec3 from_pixel(const Camera& camera, const Vec3& pixel, int width, int height) {
  const CameraAxes axes = axes_of(camera);
  const double scale = half_height(camera, pixel.z()) / (0.5 * height);
  return camera.eye + scale * (pixel.x() - 0.5 * width) * axes.right + scale * (0.5 * height - pixel.y()) * axes.up -
         pixel.z() * axes.towards_eye;
}

double pixels_per_metre(const Camera& camera, const Vec3& point, int height) {
  return 0.5 * height / half_height(camera, axes_of(camera).towards_eye.dot(camera.eye - point));
}

}  // namespace phymul

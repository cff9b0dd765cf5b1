// SPDX-License-Identifier: MIT
#include "body_frames.h"

#include <cmath>

#include "base/union_find.h"

namespace phymul {
namespace {

/// Two second moments that differ by less than this share of their sum count as equal.
constexpr double alike = 0.05;
/// Pairs agree on a direction if this share of their weight does.
constexpr double agreement = 0.02;
constexpr int sweeps = 30;

/// By number: 0 for the part of particle 0, and so on.
std::vector<Index> parts_of(Index particles, const std::vector<std::array<Index, 2>>& pairs) {
  UnionFind sets(static_cast<std::size_t>(particles));
  for (const auto& [i, j] : pairs) sets.join(i, j);
  std::vector<Index> part(static_cast<std::size_t>(particles));
  Index count = 0;
  for (Index i = 0; i < particles; ++i) part[i] = sets.root(i) == i ? count++ : part[sets.root(i)];
  return part;
}

/// Of a plane a, b: how far the principal axes of `moment` are turned from these, at most a right angle's half.
double principal_angle(const Mat3& moment, int a, int b) {
  const double angle = 0.5 * std::atan2(2.0 * moment(a, b), moment(a, a) - moment(b, b));
  if (angle > M_PI / 4) return angle - M_PI / 2;
  return angle < -M_PI / 4 ? angle + M_PI / 2 : angle;
}

/// The same for four directions at right angles that lie best along the pairs, near ones first: sum of
/// (r / length^2)^4 cos 4 (phi - angle), r e^(i phi) the projection of a pair, is largest.
double lattice_angle(const VecList& apart, const Mat3& axes, int a, int b) {
  double cosine = 0.0, sine = 0.0, whole = 0.0;
  for (const Vec3& e : apart) {
    const double length4 = std::pow(e.squaredNorm(), 2);
    const double p = axes.col(a).dot(e), q = axes.col(b).dot(e);
    // Real and imaginary part of (p + i q)^4.
    const double weight = 1.0 / (length4 * length4);
    cosine += weight * (p * p * p * p - 6.0 * p * p * q * q + q * q * q * q);
    sine += weight * 4.0 * (p * p * p * q - p * q * q * q);
    whole += weight * std::pow(p * p + q * q, 2);
  }
  if (std::hypot(cosine, sine) < agreement * whole) return 0.0;
  return 0.25 * std::atan2(sine, cosine);
}

Mat3 axes_of(const Mat3& moment, const VecList& apart, int dimension) {
  constexpr std::array<std::array<int, 2>, 3> planes{{{0, 1}, {0, 2}, {1, 2}}};
  Mat3 axes = Mat3::Identity();
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double most = 0.0;
    for (const auto& [a, b] : planes) {
      if (dimension == 2 && b == 2) continue;
      const Mat3 turned = axes.transpose() * moment * axes;
      const double unlike = std::hypot(turned(a, a) - turned(b, b), 2.0 * turned(a, b));
      const bool distinct = unlike > alike * (turned(a, a) + turned(b, b));
      const double angle = distinct ? principal_angle(turned, a, b) : lattice_angle(apart, axes, a, b);
      const double c = std::cos(angle), s = std::sin(angle);
      const Vec3 first = axes.col(a), second = axes.col(b);
      axes.col(a) = c * first + s * second;
      axes.col(b) = c * second - s * first;
      most = std::max(most, std::abs(angle));
    }
    if (most < 1e-12) break;
  }
  return axes;
}

}  // namespace

BodyFrames::BodyFrames(const Model& model, const std::vector<double>& volume,
                       const std::vector<std::array<Index, 2>>& pairs)
    : model_(model), part_(parts_of(model.particle_count(), pairs)) {
  Index count = 0;
  for (const Index part : part_) count = std::max(count, part + 1);
  frames_.resize(static_cast<std::size_t>(count));
  std::vector<double> whole(frames_.size(), 0.0);
  for (std::size_t i = 0; i < part_.size(); ++i) {
    frames_[part_[i]].centre += volume[i] * model.rest[i];
    whole[part_[i]] += volume[i];
  }
  for (std::size_t part = 0; part < frames_.size(); ++part) {
    if (whole[part] > 0.0) frames_[part].centre /= whole[part];
  }
  std::vector<Mat3> moment(frames_.size(), Mat3::Zero());
  for (std::size_t i = 0; i < part_.size(); ++i) {
    const Vec3 r = model.rest[i] - frames_[part_[i]].centre;
    moment[part_[i]] += volume[i] * r * r.transpose();
  }
  std::vector<VecList> apart(frames_.size());
  for (const auto& [i, j] : pairs) apart[part_[i]].push_back(model.rest[j] - model.rest[i]);
  for (std::size_t part = 0; part < frames_.size(); ++part) {
    frames_[part].axes = axes_of(moment[part], apart[part], model.dimension);
  }
}

}  // namespace phymul

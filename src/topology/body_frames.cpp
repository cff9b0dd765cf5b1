// SPDX-License-Identifier: MIT
#include "body_frames.h"

#include <algorithm>
#include <array>
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
std::vector<Index> parts_of(Index particles, const ParticlePairs& pairs) {
  UnionFind sets(static_cast<std::size_t>(particles));
  pairs([&](Index i, Index j) { sets.join(i, j); });
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

/// Sum of m m^T / length^8 over the pairs, m the products of the vector e from one particle to the other.
using FourthMoments = Eigen::Matrix<double, 6, 6>;

/// The same for four directions at right angles that lie best along the pairs, near ones first: sum of
/// (r / length^2)^4 cos 4 (phi - angle), r e^(i phi) the projection of a pair, is largest.
double lattice_angle(const FourthMoments& moments, const Mat3& axes, int a, int b) {
  // With p and q along the axes, the real and the imaginary part of (p + i q)^4, and (p^2 + q^2)^2.
  const Products pp = product_weights(axes.col(a), axes.col(a)), pq = product_weights(axes.col(a), axes.col(b)),
                 qq = product_weights(axes.col(b), axes.col(b));
  const double p4 = pp.dot(moments * pp), p2q2 = pq.dot(moments * pq), q4 = qq.dot(moments * qq);
  const double cosine = p4 - 6.0 * p2q2 + q4, sine = 4.0 * (pp - qq).dot(moments * pq);
  const double whole = p4 + 2.0 * p2q2 + q4;
  if (std::hypot(cosine, sine) < agreement * whole) return 0.0;
  return 0.25 * std::atan2(sine, cosine);
}

Mat3 axes_of(const Mat3& moment, const FourthMoments& fourth, int dimension) {
  constexpr std::array<std::array<int, 2>, 3> planes{{{0, 1}, {0, 2}, {1, 2}}};
  Mat3 axes = Mat3::Identity();
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double most = 0.0;
    for (const auto& [a, b] : planes) {
      if (dimension == 2 && b == 2) continue;
      const Mat3 turned = axes.transpose() * moment * axes;
      const double unlike = std::hypot(turned(a, a) - turned(b, b), 2.0 * turned(a, b));
      const bool distinct = unlike > alike * (turned(a, a) + turned(b, b));
      const double angle = distinct ? principal_angle(turned, a, b) : lattice_angle(fourth, axes, a, b);
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

BodyFrames::BodyFrames(const Model& model, const std::vector<double>& volume, const ParticlePairs& pairs)
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
  std::vector<FourthMoments> fourth(frames_.size(), FourthMoments::Zero());
  pairs([&](Index i, Index j) {
    const Vec3 e = model.rest[j] - model.rest[i];
    const Products scaled = products(e) / std::pow(e.squaredNorm(), 2);
    fourth[part_[i]] += scaled * scaled.transpose();
  });
  for (std::size_t part = 0; part < frames_.size(); ++part) {
    frames_[part].axes = axes_of(moment[part], fourth[part], model.dimension);
  }
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include "isotropic_edges.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace phymul {
namespace {

/// A fit that changes the prior weight of an edge to a neighbour by a larger factor is no good one: it would put nearly
/// all weight on few neighbours.
constexpr double most_lopsided = 1e3;
/// Prior weight of an edge between neighbours, over that of one from the particle.
constexpr double prior_between = 0.1;

/// What an edge e adds to the sums that are fitted: e e^T by entries, those off the diagonal times root 2, so that the
/// product of two is that of their entries; then e.
using Moments = Eigen::Matrix<double, 9, 1>;
using Curvature = Eigen::Matrix<double, 9, 9>;

Moments moments(const Vec3& e) {
  const double root = std::sqrt(2.0);
  Moments m;
  m << e.x() * e.x(), e.y() * e.y(), e.z() * e.z(), root * e.x() * e.y(), root * e.y() * e.z(), root * e.z() * e.x(), e;
  return m;
}

/// Weights whose sum of w e e^T is the unit tensor and, if they are to be balanced, whose sum of w e is zero: of all
/// such the ones of greatest entropy relative to the prior ones (Jaynes 1957; for shape functions Arroyo and Ortiz
/// 2006), w = prior exp(L . moments of e). L is where the sum of w less L . target is least, a convex function:
/// Newton's method finds it if there is such a place.
class IsotropicFit {
 public:
  explicit IsotropicFit(int dimension) : dimension_(dimension) { target_.head(dimension).setOnes(); }

  void add(const Vec3& e, double prior) {
    moments_.push_back(moments(e));
    prior_.push_back(prior);
  }

  /// Weights, in order of the edges. Empty where there are none, or where one is more than `most` times its prior one
  /// or less than 1/most of it.
  std::vector<double> weights(bool balanced, double most) {
    scale_priors();
    std::vector<int> idle;  // sums that are not fitted
    if (!balanced) idle = {6, 7, 8};
    if (dimension_ == 2) idle.insert(idle.end(), {2, 4, 5, 8});
    Moments L = Moments::Zero();
    for (int step = 0; step < 60; ++step) {
      Moments slope;
      Curvature curvature;
      const double value = derivatives(L, slope, curvature);
      for (const int k : idle) {
        slope[k] = 0.0;
        curvature.row(k).setZero();
        curvature.col(k).setZero();
        curvature(k, k) = curvature(0, 0);
      }
      const double error = slope.norm();
      const Eigen::LDLT<Curvature> factor(curvature);
      const auto pivots = factor.vectorD().cwiseAbs();
      if (!std::isfinite(error) || !(pivots.minCoeff() > 1e-13 * pivots.maxCoeff())) return {};
      const Moments move = -factor.solve(slope);
      double part = 1.0;
      const auto descends = [&] { return sum(L + part * move) <= value + 0.25 * part * slope.dot(move); };
      while (error > near_ && part > 1e-6 && !descends()) part *= 0.5;
      L += part * move;
      if (error <= near_) return accepted(L, most);  // after that step the error is its square
    }
    return {};
  }

 private:
  void scale_priors() {
    double trace = 0.0;
    for (std::size_t p = 0; p < prior_.size(); ++p) trace += prior_[p] * moments_[p].head<3>().sum();
    for (double& w : prior_) w *= dimension_ / trace;
  }

  double weight(std::size_t p, const Moments& L) const { return prior_[p] * std::exp(L.dot(moments_[p])); }

  double sum(const Moments& L) const {
    double total = -L.dot(target_);
    for (std::size_t p = 0; p < prior_.size(); ++p) total += weight(p, L);
    return total;
  }

  double derivatives(const Moments& L, Moments& slope, Curvature& curvature) const {
    slope = -target_;
    curvature.setZero();
    double total = -L.dot(target_);
    for (std::size_t p = 0; p < prior_.size(); ++p) {
      const double w = weight(p, L);
      total += w;
      slope += w * moments_[p];
      curvature += w * moments_[p] * moments_[p].transpose();
    }
    return total;
  }

  std::vector<double> accepted(const Moments& L, double most) const {
    std::vector<double> result;
    for (std::size_t p = 0; p < prior_.size(); ++p) {
      if (!(std::abs(L.dot(moments_[p])) <= std::log(most))) return {};
      result.push_back(weight(p, L));
    }
    return result;
  }

  static constexpr double near_ = 1e-8;
  int dimension_;
  Moments target_ = Moments::Zero();
  std::vector<Moments> moments_;
  std::vector<double> prior_;
};

}  // namespace

std::vector<WeightedEdge> isotropic_edges(const VecList& r, int dimension, double volume) {
  double reach = 0.0;
  for (const Vec3& p : r) reach = std::max(reach, p.norm());
  if (!(reach > 0.0)) return {};
  // Lengths over the reach. The weight of far neighbours goes to zero smoothly, a little beyond the last one.
  const auto kernel = [&](Index k) {
    const double q = r[k].norm() / (1.1 * reach);
    return (1.0 - q) * (1.0 - q) * (1.0 + 2.0 * q);
  };
  IsotropicFit fit(dimension);
  std::vector<WeightedEdge> edges;
  const auto count = static_cast<Index>(r.size());
  for (Index k = 0; k < count; ++k) {
    edges.push_back({0, k + 1, 0.0});
    fit.add(r[k] / reach, kernel(k));
  }
  // Balanced inside the body, where that makes the divergence of a uniform stress almost zero; not on its surface.
  std::vector<double> weight = fit.weights(true, most_lopsided);
  if (weight.empty()) weight = fit.weights(false, most_lopsided);
  if (weight.empty()) {
    // Edges between the nearest neighbours, as few as will do: each may make a pair of particles that was none.
    std::vector<Index> near(r.size());
    std::iota(near.begin(), near.end(), 0);
    std::ranges::stable_sort(near, {}, [&](Index k) { return r[k].squaredNorm(); });
    Index joined = 1;
    for (const Index most : {8, 14, 20, count}) {
      if (!weight.empty()) break;
      for (; joined < std::min(most, count); ++joined) {
        for (Index b = 0; b < joined; ++b) {
          edges.push_back({near[b] + 1, near[joined] + 1, 0.0});
          fit.add((r[near[joined]] - r[near[b]]) / reach, prior_between * kernel(near[b]) * kernel(near[joined]));
        }
      }
      weight = fit.weights(false, std::numeric_limits<double>::max());
    }
  }
  if (weight.empty()) return {};
  for (std::size_t p = 0; p < edges.size(); ++p) edges[p].weight = volume / (reach * reach) * weight[p];
  return edges;
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include "local_steps.h"

#include <cmath>
#include <optional>

#include "base/symmetric_modes.h"
#include "scaled_stiffness.h"
#include "substep_loop.h"

namespace phymul {
namespace {

using Vector = Eigen::VectorXd;

constexpr int steps_at_most = 120;

/// Q, applied to z = K u: minus the mean acceleration of a step, over the masses.
class Filter {
 public:
  explicit Filter(const LocalSteps& steps)
      : steps_(steps),
        dt_(2.0 / std::sqrt(steps.rate())),
        still_(Vector::Zero(static_cast<Eigen::Index>(3 * steps.stiff.particle.size()))),
        a_(steps.fine.particle.size()),
        change_(a_.size()),
        nodes_(steps.fine.nodes()) {
    if (steps.substeps.empty()) return;
    stiffness_.emplace(steps.stiff.tables, steps.stiff.tables.rest, std::span<const std::uint8_t>{});
    loop_.emplace(steps.substeps, Vector::Ones(still_.size()),
                  [this](const Vector& w, Vector& result) { stiffness_->apply(w, result); });
  }

  void apply(const Vector& z, Vector& result) {
    result = z;
    if (loop_) {
      for_each(steps_.stiff.particle, [&](auto own, auto whole) { still_.segment<3>(3 * own) = -z.segment<3>(whole); });
      const Vector& sum = loop_->run(still_, dt_, 1.0);
      for_each(steps_.stiff.particle,
               [&](auto own, auto whole) { result.segment<3>(whole) -= sum.segment<3>(3 * own); });
    }
    if (steps_.fine.empty()) return;
    const auto root = [&](auto own) { return std::sqrt(steps_.fine.mass[own]); };
    for_each(steps_.fine.particle, [&](auto own, auto whole) { a_[own] = z.segment<3>(whole) * root(own); });
    steps_.fine.changes<Vec3>(a_, change_, nodes_);
    for_each(steps_.fine.particle, [&](auto own, auto whole) { result.segment<3>(whole) += change_[own] / root(own); });
  }

 private:
  template <class Each>
  static void for_each(const std::vector<Index>& particle, const Each& each) {
    for (std::size_t r = 0; r < particle.size(); ++r) {
      each(static_cast<Eigen::Index>(r), Eigen::Index{3} * particle[r]);
    }
  }

  const LocalSteps& steps_;
  std::optional<ScaledStiffness> stiffness_;
  const double dt_;
  Vector still_;
  std::optional<SubstepLoop<Vector>> loop_;
  VecList a_, change_, nodes_;
};

}  // namespace

double largest_rate(const TopologyTextures& topology, const LocalSteps& steps) {
  ScaledStiffness K(topology, topology.rest, {});
  Filter filter(steps);
  // v: vectors of unit energy; z = K v. Vectors without energy, rigid motions, drop out by themselves.
  Vector v = K.start_vector(), z, last_v = Vector::Zero(v.size()), w, image;
  K.apply(v, z);
  const double energy = std::sqrt(v.dot(z));
  if (!(energy > 0.0)) return 0.0;
  v /= energy;
  z /= energy;
  std::vector<double> diagonal, off;
  double largest = 0.0;
  for (int step = 0; step < steps_at_most; ++step) {
    filter.apply(z, w);
    diagonal.push_back(z.dot(w));
    w -= diagonal.back() * v;
    if (step > 0) w -= off.back() * last_v;
    K.apply(w, image);
    const double beta = std::sqrt(std::max(w.dot(image), 0.0));
    if (step % 10 == 9 || step + 1 == steps_at_most || beta == 0.0) {
      const SymmetricModes ritz = tridiagonal_modes(diagonal, off);
      const Eigen::Index last = ritz.values.size() - 1;
      largest = ritz.values[last];
      const double residual = beta * std::abs(ritz.vectors(last, last));
      if (residual <= ritz_accuracy * largest || beta == 0.0) break;
    }
    off.push_back(beta);
    last_v.swap(v);
    v = w / beta;
    z = image / beta;
  }
  return largest;
}

}  // namespace phymul

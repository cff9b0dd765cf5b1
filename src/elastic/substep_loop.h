// SPDX-License-Identifier: MIT
//
// The recursion of local time steps (local_steps.h) in the coordinates of rest: vectors of the stiff part in any
// precision and layout.
#pragma once

#include <functional>
#include <span>
#include <utility>

#include "local_steps.h"

namespace phymul {

/// `Numbers`: a column of Eigen.
template <class Numbers>
class SubstepLoop {
 public:
  using Scalar = typename Numbers::Scalar;
  /// result = K w.
  using Stiffness = std::function<void(const Numbers& w, Numbers& result)>;

  /// Keeps the span. `inverse_mass`: of each number.
  SubstepLoop(std::span<const Substep> substeps, Numbers inverse_mass, Stiffness stiffness)
      : substeps_(substeps), inverse_mass_(std::move(inverse_mass)), stiffness_(std::move(stiffness)) {
    for (Numbers* v : {&w_, &before_, &next_, &pull_, &sum_, &a_}) v->setZero(inverse_mass_.size());
  }

  /// The sum of -share_k factor K w_k; `still`: f / m at w = 0. Valid until the next call. What the recursion carries
  /// is w / dt^2: of the size of `still` in the units of any body, as single precision needs it.
  const Numbers& run(const Numbers& still, double dt, double factor, std::span<const LocalForces::Held> held = {},
                     Eigen::Index numbers = 3) {
    for (Numbers* v : {&w_, &before_, &pull_, &sum_}) v->setZero();
    for (std::size_t k = 0; k < substeps_.size(); ++k) {
      const auto keep = static_cast<Scalar>(substeps_[k].keep), kick = static_cast<Scalar>(substeps_[k].kick);
      if (k > 0) {
        stiffness_(w_, pull_);
        pull_ *= static_cast<Scalar>(factor * dt * dt);
        sum_ -= static_cast<Scalar>(substeps_[k].share) * pull_;
      }
      a_ = still - inverse_mass_.cwiseProduct(pull_);
      for (const auto& [row, free] : held) {
        auto own = a_.template segment<3>(numbers * static_cast<Eigen::Index>(row));
        own = (free.template cast<Scalar>() * own).eval();
      }
      next_ = w_ + keep * (w_ - before_) + kick * a_;
      before_.swap(w_);
      w_.swap(next_);
    }
    return sum_;
  }

 private:
  const std::span<const Substep> substeps_;
  const Numbers inverse_mass_;
  const Stiffness stiffness_;
  Numbers w_, before_, next_, pull_, sum_, a_;
};

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Local time steps (elastic/local_steps.h) beside the vector kernels.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "elastic/substep_loop.h"
#include "packed_body.h"
#include "statics/tangent.h"

namespace phymul::cpu {

class PackedLocalSteps {
 public:
  /// Keeps a reference to `steps`. `body`: all of it.
  PackedLocalSteps(const LocalSteps& steps, const PackedBody& body);

  /// Adds to `force`, [places][4] N by quad, what the substeps of the step of `move` change. Its loads and gravity act
  /// in them too.
  void add_changes(const simd::Move& move, std::span<const double> factors, char* force);

  /// `loads`, [places][4] N by quad: those of `move` and what tools add, null if they add nothing.
  void keep_pushes(const simd::Move& move, const char* loads);
  LocalForces& forces() { return forces_; }
  const LocalForces& forces() const { return forces_; }

 private:
  void run_loop(std::span<const Vec3> still, double dt, double factor, std::span<Vec3> sum);

  const LocalSteps& steps_;
  const std::unique_ptr<Tangent> stiffness_;
  Eigen::VectorXf still_;  // [4 n]
  SubstepLoop<Eigen::VectorXf> loop_;
  LocalForces forces_;
  std::vector<std::size_t> place_, quad_;  // [n] of LocalSteps::stiff, in the body
  VecList x_, acceleration_;
};

}  // namespace phymul::cpu

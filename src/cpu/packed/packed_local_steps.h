// SPDX-License-Identifier: MIT
//
// Local time steps (elastic/local_steps.h) beside the vector kernels.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "elastic/substep_loop.h"
#include "interaction/tool_set.h"
#include "packed_body.h"
#include "statics/rest_term.h"

namespace phymul::cpu {

class PackedLocalSteps {
 public:
  /// Keeps a reference to `steps`. `body`: all of it.
  PackedLocalSteps(const LocalSteps& steps, const PackedBody& body);

  /// Adds to `force`, [places][4] N by quad, what the substeps of the step of `move` change. Its loads and gravity act
  /// in them too.
  void add_changes(const simd::Move& move, const ToolSet& tools, std::span<const double> factors, char* force);

  /// `loads`, [places][4] N by quad: those of `move` and what tools add, null if they add nothing.
  void keep_pushes(const simd::Move& move, const char* loads);
  LocalForces& forces() { return forces_; }
  const LocalForces& forces() const { return forces_; }

 private:
  struct Place {
    std::size_t quad, place;  // in the body
  };
  void add_substeps(const simd::Move& move, std::span<const double> factors, float* elastic);
  void add_fine_parts(const simd::Move& move, float* elastic);
  void run_loop(std::span<const Vec3> still, std::span<const LocalForces::Held> held, double dt, double factor,
                std::span<Vec3> sum);

  const LocalSteps& steps_;
  const std::unique_ptr<Tangent> stiffness_;  // null without substeps
  Eigen::VectorXf still_;                     // [4 n]
  SubstepLoop<Eigen::VectorXf> loop_;
  LocalForces forces_;
  std::vector<Place> at_;     // by LocalSteps::particle
  VecList x_, acceleration_;  // of LocalSteps::stiff
  std::vector<float> fine_mass_;
  std::vector<Eigen::Vector4f> fine_f_, fine_change_, fine_nodes_;
};

}  // namespace phymul::cpu

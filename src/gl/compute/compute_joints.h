// SPDX-License-Identifier: MIT
//
// The springs of a scene's joints among the rows of its loads, and their states with each pair of ComputeState.
#pragma once

#include "compute_state.h"
#include "compute_tables.h"
#include "device/float_joints.h"

namespace phymul::gl {

class ComputeJoints {
 public:
  /// The scene must outlive it.
  ComputeJoints(FloatJoints joints, const ComputeTables& tables, StorageRows& rows);

  int count() const { return joints_.count(); }
  bool any_tool() const { return joints_.any_tool(); }
  /// Takes over changed constants of the scene.
  void follow(StorageBuffer& buffer);
  int state_row(int pair) const { return static_cast<int>(state_row_ + pair * state_rows()); }
  std::int64_t state_rows() const { return static_cast<std::int64_t>(FloatJoints::state_rows) * joints_.count(); }

 private:
  FloatJoints joints_;
  std::int64_t laws_row_ = 0, state_row_ = 0;
};

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#include "compute_joints.h"

#include <utility>

namespace phymul::gl {

ComputeJoints::ComputeJoints(FloatJoints joints, const ComputeTables& tables, StorageRows& rows)
    : joints_(std::move(joints)) {
  rows.add("joint_springs_place", joints_.springs());
  rows.add("joint_anchors_place", tables.placed(joints_.anchors(), 1));
  rows.add("joint_places_place", joints_.places());
  laws_row_ = rows.add("joint_laws_place", joints_.laws());
  rows.add("joint_ranges_place", tables.by_place(joints_.ranges()));
  rows.add("joint_ends_place", joints_.ends());
  state_row_ = rows.take({}, ComputeState::pairs * state_rows());
  rows.note("joint_count", joints_.count());
}

void ComputeJoints::follow(StorageBuffer& buffer) {
  if (joints_.follow()) buffer.write_rows(laws_row_, joints_.laws());
}

}  // namespace phymul::gl

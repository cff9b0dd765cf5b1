// SPDX-License-Identifier: MIT
//
// A snapshot in bytes: count of particles (u64), time, last_dt (f64), steps_at_rest (u32), positions, velocities (f64
// each), whether there are displacements (u8) and they, the count of tools (u64) and their states, the count of joints
// with broken springs (u64) and each as name and their rows, the count of parts (u64) and each as name and bytes (u64).
// Parts of these bytes alone: "motion", growth and max_speed (f64), and "scene", Snapshot::scene, tools and joints.
#pragma once

#include <phymul/state.h>

#include "base/checked_file.h"

namespace phymul {

void put_snapshot(ByteWriter& out, const Snapshot& snapshot, bool with_scene = true);

/// Rows of Model::cells, which must be ascending.
std::vector<Index> take_removed_cells(ByteReader& in);

/// Throws Error where a number is not finite, too.
Snapshot take_snapshot(ByteReader& in);

}  // namespace phymul

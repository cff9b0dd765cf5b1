// SPDX-License-Identifier: MIT
#pragma once

#include "device/slice_tables.h"

namespace phymul::gl {

/// Bytes that the two passes of a step, and those for volumes and cells, read and write: see Solver::bytes_a_step. Each
/// pass reads a texel once, as where a cache holds what neighbouring fragments share. Loads of a scene are not counted.
double bytes_a_step(const FloatTables& tables);

/// The same of compute shaders that store terms: their rows with the padding, and the ranges in place of lists. The few
/// displacements that several kinds of terms in one dispatch share are counted for each.
double bytes_a_step(const SliceTables& slices);

}  // namespace phymul::gl

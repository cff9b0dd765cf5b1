// SPDX-License-Identifier: MIT
#pragma once

#include "../float_tables.h"

namespace phymul::gl {

/// Bytes that the two passes of a step, and those for volumes and cells, read and write: see Solver::bytes_a_step. Each
/// pass reads a texel once, as where a cache holds what neighbouring fragments share. Loads of a scene are not counted.
double bytes_a_step(const FloatTables& tables);

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/solver.h>

#include "device/float_tables.h"

namespace phymul::cpu {

/// The float backend as plain loops on one core: the mirror that shaders are compared with bit by bit, and the pace
/// that faster float backends are compared with. Not among backend_names().
std::unique_ptr<Solver> make_mirror_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                           const SolverOptions& options = {}, FloatLayout layout = FloatLayout::table);

}  // namespace phymul::cpu

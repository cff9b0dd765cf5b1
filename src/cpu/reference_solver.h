// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/solver.h>

namespace phymul::cpu {

/// The double-precision backend: one thread, plain loops, every term in the order of elasticity.h.
std::unique_ptr<Solver> make_reference_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                              const SolverOptions& options);

}  // namespace phymul::cpu

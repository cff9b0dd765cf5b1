// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/solver.h>

namespace phymul::cpu {

/// The double-precision backend: one thread, plain loops, every term in the order of elasticity.h.
std::unique_ptr<Solver> make_reference_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                              const SolverOptions& options);

/// The fast backend: single precision, SIMD instructions, threads. Displacements and velocities as the mirror's; the
/// same bits whatever the number of threads.
std::unique_ptr<Solver> make_simd_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                         const SolverOptions& options);

}  // namespace phymul::cpu

// SPDX-License-Identifier: MIT
//
// What a solver refuses of its options and of the arguments of a call.
#pragma once

namespace phymul {

/// Throws Error.
void require_options(const SolverOptions& options);

/// Why a call for n steps of dt can do nothing, or null. Static text.
const char* why_no_steps(int n, double dt, bool to_rest, const Damping& damping);

}  // namespace phymul

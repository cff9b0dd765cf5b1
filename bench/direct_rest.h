// SPDX-License-Identifier: MIT
//
// Takes a body to rest by Simulation::solve_static, and times it.
#pragma once

#include "methods.h"
#include "relaxation.h"

namespace phymul::bench {

/// `start` [N] m: where the body begins. The times are of the call alone, with its set-up, as those of relax() are of
/// the steps alone: the median of `repeats`, or of as many as fit into the plan's wall_cap. What solve_static() does
/// not take is a status, not an exception. Relaxation::steps counts evaluations. Of the plan `backend`, `wall_cap` and
/// `rest_accuracy` are used, the last as StaticOptions::tolerance.
Relaxation solve_directly(const Problem& problem, const MethodBody& body, const VecList& start,
                          const RelaxationPlan& plan, int repeats = 5);

}  // namespace phymul::bench

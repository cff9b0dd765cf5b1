// SPDX-License-Identifier: MIT
#pragma once

#include "local_steps.h"

namespace phymul {

/// How much larger the largest eigenvalue of the whole scheme is than its parts promise, at the step that they promise
/// (LocalSteps::rate): 1 or more. The scheme's operator is B = Q(K_stiff) K over the masses, with the polynomial Q of
/// the substeps. It is symmetric in the inner product of the energy, x . K y, in which Lanczos iteration finds its
/// largest eigenvalue.
double local_step_margin(const TopologyTextures& topology, const LocalSteps& steps);

}  // namespace phymul

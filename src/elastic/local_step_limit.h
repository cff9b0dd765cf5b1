// SPDX-License-Identifier: MIT
#pragma once

#include "local_steps.h"

namespace phymul {

/// 1/s^2: the largest eigenvalue of the whole scheme at the step that its parts promise (LocalSteps::rate). The
/// scheme's operator is B = Q K over the masses, with the Q of fine parts and the polynomial Q(K_stiff) of the
/// substeps. It is symmetric in the inner product of the energy, x . K y, in which Lanczos iteration finds its largest
/// eigenvalue.
double largest_rate(const TopologyTextures& topology, const LocalSteps& steps);

}  // namespace phymul

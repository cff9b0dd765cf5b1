// SPDX-License-Identifier: MIT
//
// Stiffness by a stretching test on the very body: for models that no closed form gives a modulus.
#pragma once

#include "methods.h"
#include "relaxation.h"

namespace phymul::bench {

/// The uniform stiffness, N/m, with which the body, stretched by 1 % along its longest side between ends that may
/// narrow, pulls with E times strain times (volume over length). Throws Error with the reason where the body, at 1 N/m,
/// does not come to rest within the plan.
double stretched_stiffness(const MethodBody& body, const Material& material, const RelaxationPlan& plan);

}  // namespace phymul::bench

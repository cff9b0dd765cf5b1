// SPDX-License-Identifier: MIT
//
// How a needle's shaft bends: a beam clamped in the hub under forces across it (Euler and Bernoulli; the closed form of
// a cantilever under one force, and the sum over the forces). So there is nothing to discretise, and no stiffness that
// a step would have to resolve.
#pragma once

#include <phymul/needle.h>

namespace phymul {

/// m/N: how far a force across the shaft `from` m from the tip moves its place `at` m from the tip. Places beyond the
/// hub do not move, those ahead of the tip move as it does. 0 where the needle is stiff.
double shaft_compliance(const Needle& needle, double at, double from);

/// m, in the tool's frame.
Vec3 shaft_deflection(const Needle& needle, std::span<const ShaftLoad> loads, double along);

/// Whether what is `along` m from the tip toward the hub is ahead of it by more than what forces leave open: where the
/// tip does not cut, they bring the last node to 0 but for some 1e-3 of a step's motion, either side, so that a bound
/// of 0 would be decided by rounding. A tenth of the radius is far more than that, and a part of the tip itself.
bool is_ahead_of_tip(const Needle& needle, double along);

}  // namespace phymul

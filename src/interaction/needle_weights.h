// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/needle.h>

#include <span>

#include "predicted_step.h"

namespace phymul {

/// Weights of the particles within `support_radius` of a point, whose sum is 1 and whose weighted mean place is the
/// point itself: moving least squares with a linear basis, (1 - (r / support_radius)^2)^2 as weight function. So a
/// force given to a point has the sum and the torque it has there. Empty where the particles around do not span space.
NeedleNode spread_weights(const PredictedStep& step, std::span<const Index> around, const Vec3& x,
                          double support_radius);

}  // namespace phymul

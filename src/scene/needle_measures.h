// SPDX-License-Identifier: MIT
//
// What every backend derives of a needle from the body it goes into, and from its poses. In double precision.
#pragma once

#include <phymul/model.h>
#include <phymul/tool.h>

#include <span>
#include <vector>

namespace phymul {

/// m: between particles; of cells alone, which have no neighbours to take it from, from the size of the body.
double needle_spacing(const Model& model);
/// m: Needle::spread, or 34 radii, but at least two spacings of the body.
double needle_spread(const Needle& needle, const Model& model);
/// m: of the weights at which a force spreads as far on every mesh.
double needle_support_radius(double spread, const Model& model);
/// Pa, [N]: the push of a tip per squared spread at which the tissue around each particle has reached its limit of
/// stretch; infinite where a particle has no material. `factors`: Scene::stiffness_factors().
void needle_bearing(const Model& model, std::span<const double> factors, std::vector<double>& bearing);
/// rad, about the needle's axis: by how much it turns between two poses. Orientations on the way between two equal ones
/// differ by rounding, which is no turning.
double needle_turn(const ToolPose& start, const ToolPose& end);

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// The terms of the energy beside the bases: springs, volumes, cells.
#pragma once

#include <phymul/topology_textures.h>

#include <vector>

namespace phymul {

/// Each neighbouring pair once, with the mean of the two stiffnesses; ordered by particle numbers.
std::vector<SpringTexel> neighbour_springs(const Model& model);

/// Springs from each of `particles` to each of its neighbours, with the particle's own stiffness.
std::vector<SpringTexel> springs_around(const Model& model, const std::vector<Index>& particles);

/// One row per corner simplex; stiffness kappa * share. Throws Error when no cell fills space.
std::vector<VolumeTexel> volume_terms(const Model& model, double kappa);

}  // namespace phymul

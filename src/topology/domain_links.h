// SPDX-License-Identifier: MIT
#pragma once

#include "averaged_body.h"

namespace phymul {

/// What rounding leaves of an area that is zero by symmetry, over the largest one of its domain.
inline constexpr double rounding_of_area = 1e-11;

/// Fills TopologyTextures::links and surface_links, and the rows that the domains have there. Domains that lie alike
/// and whose links are equal share their rows.
void add_links(const Domains& domains, const PairStiffness& stiffness, TopologyTextures& topology);

}  // namespace phymul

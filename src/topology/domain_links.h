// SPDX-License-Identifier: MIT
#pragma once

#include "averaged_body.h"

namespace phymul {

/// Fills TopologyTextures::links and surface_links, and the rows that the domains have there. Domains that lie alike
/// and whose links are equal share their rows.
void add_links(const Domains& domains, const PairStiffness& stiffness, TopologyTextures& topology);

}  // namespace phymul

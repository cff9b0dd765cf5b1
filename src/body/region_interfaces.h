// SPDX-License-Identifier: MIT
//
// Boundaries between the regions inside a body: particles near them move onto them, and edges that still cross them
// are cut there.
#pragma once

#include "label_field.h"
#include "stuffing.h"

namespace phymul {

/// Where an edge of a cell joins two regions, the end that is nearer to their boundary moves onto it, the nearest ones
/// first. Particles on the body's surface move along its edges. Edges of which no end moved are cut at the boundary, by
/// a new particle. What would spoil the angles of a cell, or make it lower than a share of the lattice's edge there, is
/// left out: such edges still cross the boundary. `edge`: m, of the lattice, where it is coarsest.
void meet_interfaces(Stuffing& body, const LabelField& field, double edge);

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Boundaries between the regions inside a body: particles that are nearest to them move onto them.
#pragma once

#include "label_field.h"
#include "stuffing.h"

namespace phymul {

/// Where an edge of a cell joins two regions, the end that is nearer to their boundary moves onto it, the nearest ones
/// first, unless that spoils the angles of a cell. Particles on the body's surface move along it alone.
void meet_interfaces(Stuffing& body, const LabelField& field);

}  // namespace phymul

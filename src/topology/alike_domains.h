// SPDX-License-Identifier: MIT
//
// Domains of Law::particle_averaged that lie alike have the same constants, as most do in a lattice: these are computed
// and stored once.
#pragma once

#include "averaged_body.h"

namespace phymul {

/// Most vertices of a solid cell.
inline constexpr Index most_vertices = 8;

/// Fills Domains::kind and first_of_kind. Two domains are of one kind if they are of one material, in cells of the same
/// types, whose domains differ from them by the same numbers and whose particles lie the same from theirs, up to the
/// rounding of coordinates. Parts of a body that no cell joins have kinds of their own, so that each is as it is alone.
/// `cells`: per domain the entries (row of a cell) * most_vertices + vertex that it is there.
void find_kinds(const Model& model, const RaggedList& cells, Domains& domains);

}  // namespace phymul

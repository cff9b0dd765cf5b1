// SPDX-License-Identifier: MIT
//
// The rest shape of walls alone: Newton's method with a factored tangent, each triangle's by differences of its forces.
// A wall that bends far also stretches on the straight way of a step and takes that back in the next ones, so several
// steps together are to lower the energy (the watchdog of Chamberlain et al., Math. Prog. Study 16 (1982) 1); where
// they do not, a line search does. Not the search of rest_search.h: its grids know neither bending nor thin bodies.
#pragma once

#include "rest_search.h"

namespace phymul {

/// As search_rest(), without terms; no body may be loose. An evaluation is a tangent or forces.
RestSearchEnd search_wall_rest(const TopologyTextures& topology, const LoadFrame& loads, double tolerance,
                               int most_evaluations, VecList& position);

}  // namespace phymul

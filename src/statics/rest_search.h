// SPDX-License-Identifier: MIT
//
// The rest shape of a body of Law::particle_averaged: Newton's method on its energy with a line search along curved
// paths (TurningPath). The linear systems are solved by conjugate gradients, as far as the next step deserves it, with
// a V-cycle of multigrid (multigrid.h). Source: J. Nocedal and S. Wright, Numerical Optimization, ch. 3, 5 and 7.
//
// The rest shape of walls alone: Newton's method with a factored tangent, each triangle's by differences of its forces.
// A wall that bends far also stretches on the straight way of a step and takes that back in the next ones, so several
// steps together are to lower the energy (the watchdog of Chamberlain et al., Math. Prog. Study 16 (1982) 1); where
// they do not, a line search does. Not the search above: its grids know neither bending nor thin bodies.
#pragma once

#include <phymul/bodies.h>
#include <phymul/load_frame.h>
#include <phymul/statics.h>

#include <span>

#include "rest_body.h"
#include "rest_term.h"

namespace phymul {

struct RestSearchEnd {
  bool at_rest = false;
  bool stuck = false;  ///< no step along the last direction lowers the energy
  int evaluations = 0;
  double residual = 0.0, largest_force = 0.0;  ///< as of StaticResult
};

/// Takes `position`, [N] m, towards rest under `loads`, as Scene::evaluate() fills them, and terms; until the residual
/// is at most `tolerance` and terms miss their laws by no more, or after `most_evaluations` (a few more, because a line
/// search is not broken off). `loose`: the bodies that have free_motions(); along these they stay where the search
/// begins, unless something drives them. `body`: with what `loads` impose. The same search has the same bits, whatever
/// was searched for before, unless it shall `predict` (StaticOptions).
RestSearchEnd search_rest(RestBody& body, const LoadFrame& loads, RestTerms terms, std::span<const ConnectedBody> loose,
                          const StaticOptions& options, VecList& position);

/// As search_rest(), without terms; no body may be loose. An evaluation is a tangent or forces.
RestSearchEnd search_wall_rest(const TopologyTextures& topology, const LoadFrame& loads, double tolerance,
                               int most_evaluations, VecList& position);

}  // namespace phymul

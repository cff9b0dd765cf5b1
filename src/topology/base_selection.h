// SPDX-License-Identifier: MIT
//
// Which bases a particle takes, before stiffness and packing.
#pragma once

#include "base_geometry.h"

#include <phymul/model.h>
#include <phymul/topology.h>

#include <vector>

namespace phymul {

/// Bases of all particles in rows: those of particle i are offset[i] ... offset[i + 1] - 1.
struct BaseTable {
  std::vector<std::size_t> offset{0};  ///< [N + 1]
  std::vector<RestBase> base;          ///< [rows]
  std::vector<double> weight;          ///< [rows] w_t, sum 1 over a particle's bases
  std::vector<double> stiffness;       ///< [N] k_i, N/m

  std::size_t size(Index particle) const { return offset[particle + 1] - offset[particle]; }
};

/// Triples (pairs in 2-D) of the neighbours of `owner` that have a plane, and pass the thresholds unless the options
/// ask for all; in lexicographic order of their places in the neighbour row.
std::vector<RestBase> neighbour_bases(const Model& model, Index owner, const TopologyOptions& options);

/// The bases of a model whose stiffness is in N/m: k_i as the model has it, weights 1 / Bc_i. Throws Error as soon as
/// there are more than 32-bit numbers count three entries each of.
BaseTable select_bases(const Model& model, const TopologyOptions& options);

}  // namespace phymul

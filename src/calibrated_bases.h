// SPDX-License-Identifier: MIT
//
// Bases and cell terms whose stiffness follows from a material.
//
// Seen as a continuum, base t of particle i samples the deformation gradient F of the tetrahedron (i, a, b, c):
// P*_t - x_i = beta_t (n(F) - F n_t). With k_t = k_i w_t = c V u_t / beta_t^2, u_t weights of sum 1 over a volume V,
// the bases of V store c V/2 sum_t u_t |F n_t - n(F)|^2.
#pragma once

#include "base_selection.h"

#include <phymul/topology_textures.h>

#include <vector>

namespace phymul {

/// The calibration of each material. Throws Error when the model is not three-dimensional, a volume cell has no
/// material, or the area exponents of the materials differ.
std::vector<Calibration> calibrate_model(const Model& model, PoissonRoute route);

/// k_i and w_t from the materials, all multiplied by `share`: bases are the views of the cells' corner tetrahedra, or
/// for BaseSelection::fitted the isotropic subset of the neighbours' triples.
BaseTable calibrated_bases(const Model& model, const TopologyOptions& options,
                           const std::vector<Calibration>& calibration, double share, std::int64_t most_rows);

/// Volume terms of the corner tetrahedra: kappa of the cell's material times `share`.
std::vector<VolumeTexel> calibrated_volumes(const Model& model, const std::vector<Calibration>& calibration,
                                            double share);

/// Mean-gradient terms of all volume cells, stiffness c V and kappa V times `share`.
std::vector<CellTexel> cell_terms(const Model& model, const std::vector<Calibration>& calibration, double share);

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Bases, volume and cell terms whose stiffness follows from a material.
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

struct CalibratedBody {
  BaseTable bases;
  std::vector<VolumeTexel> volumes;
  std::vector<CellTexel> cells;
};

/// k_i, w_t, volume and cell terms from the materials. Bases are the views of the cells' corner tetrahedra, or for
/// BaseSelection::fitted the isotropic subset of the neighbours' triples.
///
/// The views of a cube are isotropic together, those of other cells are not: a tetrahedron has four directions where
/// six are the least. Uniform strain then strains the body unevenly and it gives way (16 % of Young's modulus on
/// jittered tetrahedra). So a cell's views carry no more than lets its anisotropy stay below 3 %, but a tenth at
/// least; the rest, and options.cell_average where that is more, goes to the cell's mean deformation, whose
/// directions are isotropic. Not with the area exponent, which only bases have.
CalibratedBody calibrated_body(const Model& model, const TopologyOptions& options,
                               const std::vector<Calibration>& calibration, std::int64_t most_rows);

}  // namespace phymul

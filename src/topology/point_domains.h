// SPDX-License-Identifier: MIT
//
// Constants of Law::particle_averaged for a body of points: particles with neighbours and one material, but no cells.
#pragma once

#include "averaged_body.h"

namespace phymul {

/// One domain for each particle, of the volume that its mass and the material's density give it.
struct PointDomains {
  Domains domains;          ///< pairs in both directions; the area of a pair is not antisymmetric; each is a kind
  PairStiffness stiffness;  ///< at s mu = 1, m
  double stabiliser = 0.0;  ///< by pure bending of the body, as in stabiliser.h; may be below 0
};

/// Throws Error unless the model has one material and each particle neighbours that span its dimension.
PointDomains point_domains(const Model& model);

}  // namespace phymul

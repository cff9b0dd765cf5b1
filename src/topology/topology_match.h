// SPDX-License-Identifier: MIT
//
// Whether tables are still those of their model.
#pragma once

#include <phymul/model.h>
#include <phymul/topology_textures.h>

namespace phymul {

/// Of what build_topology() reads, but for rest places and masses, which the tables have themselves. Of materials that
/// is Young's modulus and Poisson's ratio; of cells those that stand for matter.
ModelFingerprint model_fingerprint(const Model& model);

/// Throws Error that says what is another one: tables of a model that has changed since, or of another one as large,
/// would move what nobody sees.
void require_same_body(const TopologyTextures& topology, const Model& model);

}  // namespace phymul

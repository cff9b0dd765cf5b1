// SPDX-License-Identifier: MIT
//
// Elastic forces of a body in float, gathered particle by particle: what the shaders of a GPU do, term by term and in
// the same order, as plain loops. Order of a particle's sum: its own force (conservative: its base rows), its
// reactions, volumes, domains, springs, walls. An attractor's: neighbour rows, then bases. What a row of a table holds,
// as a shader reads it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vector3.h"
#include "device/float_domains.h"
#include "device/float_tables.h"
#include "device/table_rows.h"
#include "kernels.h"

namespace phymul::cpu {

using Float3 = Vector3<float>;

inline Float3 xyz(const Float4& row) {
  return {row[0], row[1], row[2]};
}

inline float as_float(std::int32_t bits) {
  return std::bit_cast<float>(bits);
}

/// Materials that dissipate, as glsl/step/dissipation.glsl computes their stresses and the strains that domains keep.
class MirrorDissipation {
 public:
  using Of = GreenStrain<float>;

  MirrorDissipation(const TopologyTextures& topology, const std::vector<Index>& source);

  bool empty() const { return kept_.count() == 0; }
  /// From now on the strains of a domain are its own, until a step is accepted.
  void reset() { fresh_ = true; }

  /// Of `dt`, s, after one of `last_dt`, 0: there was none.
  void begin_step(double dt, double last_dt);
  /// First Piola stress of a domain. Keeps its strains for the step after this one.
  Columns<float> stress(Index d, const Columns<float>& H);
  void accept();

 private:
  using Kept = std::array<Of::Symmetric, 2>;  // of the rate, of the branch

  FloatDissipation rows_;
  const KeptStrains kept_;
  std::vector<Float4> constants_;
  double packed_dt_ = 0.0;
  float inverse_last_dt_ = 0.0f;
  bool fresh_ = true;
  std::vector<Kept> strains_, next_;
};

class MirrorForces {
 public:
  explicit MirrorForces(FloatTables tables);

  const FloatTables& tables() const { return tables_; }

  /// Scene::stiffness_factors().
  void scale(std::span<const double> of_materials);

  /// Elastic forces, N, at displacements u, m; both [particles]. Overwrites `force`; does not allocate.
  /// `dissipation`: null, or that of the material at the step that begins.
  void evaluate(std::span<const Float3> u, std::span<Float3> force, MirrorDissipation* dissipation = nullptr) const;

 private:
  Kernels<float>::DeltaBase base_at(Index t, std::span<const Float3> u, Float3& d1, Float3& d2) const;
  Float3 pull_of_base(Index t, std::span<const Float3> u) const;
  Float3 attractor_pull(Index i, std::span<const Float3> u) const;
  void add_enumerated_heights(Index i, std::span<const Float3> u, Float3& sum) const;
  void shape_rows(std::span<const Float3> u) const;
  template <bool bounded>
  void volume_rows(std::span<const Float3> u) const;
  void wall_rows(std::span<const Float3> u) const;
  Index owner_of(Index domain) const { return tables_.domains.owner.empty() ? domain : tables_.domains.owner[domain]; }
  Columns<float> domain_gradient(Index d, std::span<const Float3> u) const;
  const Float4& law_of(Index domain) const { return tables_.domains.law[tables_.domains.law_texels * domain]; }
  std::array<float, most_energy_constants> energy_constants(Index d) const;
  void domain_rows(std::span<const Float3> u, MirrorDissipation* dissipation) const;
  Float3 domain_force(Index d) const;
  Float3 gathered(Index i, std::span<const Float3> u) const;

  FloatTables tables_;
  // What one pass hands to the next, as a shader's textures would.
  mutable std::vector<Float3> own_;           // [particles] F_i; empty where bases act one by one
  mutable std::vector<Float3> base_force_;    // [4 bases] on a, b, c and the owner; empty for the thesis' reactions
  mutable std::vector<Float3> volume_force_;  // [4 volumes]
  mutable std::vector<Float3> wall_force_;    // [8 walls] on the vertices of the patch
  mutable std::vector<Columns<float>> domain_stress_;
  mutable std::vector<Float3> spread_force_;  // [domains]
  std::vector<float> factor_;                 // [domains] of the stiffness; empty: 1
};

}  // namespace phymul::cpu

// SPDX-License-Identifier: MIT
//
// FloatDomains: the tables of Law::particle_averaged in single precision.
//
// Domain i is the first domain of particle i; it has no links if the particle is in no cell. Further domains, of
// particles where materials meet, follow in order of their particles. So where a body has one material, the number of a
// domain is that of its particle, and no table of owners is needed.
#pragma once

#include <phymul/topology_textures.h>

#include <span>
#include <vector>

#include "elastic/dissipation.h"
#include "table_rows.h"

namespace phymul {

/// Vectors are empty where the body has another law.
struct FloatDomains {
  /// Per domain: first row of its links, first row of its surface links (which follow them), end row; the next domain
  /// of the same particle, or `none`.
  std::vector<Int4> range;
  int law_texels = 1;                   ///< per domain
  std::vector<Float4> law;              ///< per domain: 1/V_d (1/m^3), s mu (Pa), EnergyConstants; 0 without links
  std::vector<std::int32_t> owner;      ///< per domain: its particle; empty if no particle has several domains
  std::vector<std::int32_t> neighbour;  ///< per row: e
  std::vector<Float4> link;             ///< per row: area (m^2), stiffness (N/m; of a surface link 0)
  std::vector<Index> source;            ///< per domain: its row of TopologyTextures::domains; `none` without links
  std::vector<Index> material;          ///< per domain: DomainTexel::material; `none` without links
  KeptStrains kept;

  Index count() const { return static_cast<Index>(range.size()); }
};

/// Throws Error if a constant is beyond single precision.
FloatDomains pack_domains(const TopologyTextures& topology);

/// Scene::stiffness_factors() domain by domain: 1 where a domain has no material or its material no factor. Both
/// [domains].
void spread_factors(std::span<const Index> material, std::span<const double> of_materials, std::span<float> factor);

/// Materials that dissipate, in single precision: the constants of a step and the strains that domains keep, in the
/// rows of a device's domains.
class FloatDissipation {
 public:
  /// Texels of a row of strains. Those behind the strains that the body keeps are 0.
  static constexpr std::size_t strain_texels = 4;

  /// `source`: FloatDomains::source. Keeps a reference to `topology`. Throws Error if a constant is beyond single
  /// precision.
  FloatDissipation(const TopologyTextures& topology, std::vector<Index> source);

  /// Two texels per domain, of steps of `dt`, s: 2 mu T, lambda T, 2 mu b, lambda b, with T the retardation time and b
  /// the relaxation strength over the middle of the step; 1 - exp(-dt / tau), 0, 0, 0. Valid until the next call.
  const std::vector<Float4>& constants(double dt);

  /// [domains * strain_texels]: xx, yy, zz, 0, yz, zx, xy, 0 of the rate's strain, then of the branch's.
  std::vector<Float4> rows(const StrainMemory& memory) const;
  StrainMemory memory(std::span<const Float4> rows) const;

 private:
  const TopologyTextures& topology_;
  const std::vector<Index> source_;
  const std::size_t kinds_;
  std::vector<Float4> constants_;
};

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include <phymul/topology_textures.h>

#include "base/fnv.h"
#include "energies.h"

namespace phymul {
namespace {

// Files hold fingerprints: the numbers of enumerators never change, whatever their order.
constexpr std::int32_t number_of(Law law) {
  return law == Law::springs ? 0 : law == Law::shape_memory ? 1 : law == Law::particle_averaged ? 2 : 3;
}

constexpr std::int32_t number_of(VolumeLaw law) {
  return law == VolumeLaw::quadratic ? 0 : 1;
}

constexpr std::int32_t number_of(Reaction reaction) {
  return reaction == Reaction::full          ? 0
         : reaction == Reaction::shared      ? 1
         : reaction == Reaction::barycentric ? 2
         : reaction == Reaction::averaged    ? 3
                                             : 4;
}

void add_options(Fnv& sum, const TopologyOptions& options) {
  sum.add(number_of(options.law.value_or(Law::shape_memory)), number_of(options.reaction),
          number_of(options.volume_law), kind_of(options.strain_energy).number);
}

void add_terms(Fnv& sum, const TopologyTextures& t) {
  sum.add(std::uint64_t{t.springs.size()});  // as wide on every system
  for (const SpringTexel& spring : t.springs) sum.add(spring.end, spring.rest_length, spring.stiffness);
  sum.add(std::uint64_t{t.volumes.size()});
  for (const VolumeTexel& volume : t.volumes) sum.add(volume.vertex, volume.inverse_rest_volume, volume.stiffness);
  for (const WallTexel& wall : t.walls) {
    sum.add(wall.vertex, wall.shear, wall.compliance, wall.bending);
    for (std::size_t k = 0; k < 6; ++k) sum.add(wall.gradient[k], wall.hessian[k]);
  }
}

void add_averaged(Fnv& sum, const TopologyTextures& t) {
  if (t.domains.empty()) return;
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    const DomainTexel& domain = t.domains[d];
    sum.add(domain.particle, domain.inverse_volume, domain.spread_stiffness, t.energy_of(d));
    sum.add(domain.link_count, domain.surface_link_count);
    for (const LinkTexel& link : t.links_of(d)) sum.add(link.offset, link.area, link.stiffness);
    for (const SurfaceLinkTexel& link : t.surface_links_of(d)) sum.add(link.offset, link.area);
  }
  for (const DissipationTexel& texel : t.dissipation) {
    sum.add(texel.retardation_time, texel.relaxation_strength, texel.relaxation_time);
  }
}

void add_part(Fnv& sum, Index row, const BodyCut::Part& part) {
  sum.add(row, part.particles, part.share, std::uint64_t{part.cuts.size()});
  for (const CellCut& cut : part.cuts) sum.add(cut);
}

}  // namespace

std::uint64_t fingerprint(const TopologyTextures& t) {
  Fnv sum;
  if (t.built) return fingerprint(t, t.removed, t.cuts);
  add_options(sum, t.options);
  sum.add(t.dimension, t.particle_count, t.rest, t.mass, t.stiffness);
  // Padding depends on the widest texture allowed, which moves nothing.
  for (Index i = 0; i < t.particle_count; ++i) sum.add(t.index[i].neighbour_count, t.index[i].base_count);
  for (Index row = 0; row < t.neighbour_count; ++row) sum.add(t.neighbours[row], t.alpha[row]);
  for (Index row = 0; row < t.base_count; ++row) sum.add(t.bases[row].vertex, t.bases[row].beta);
  sum.add(t.lambda, t.weight);
  add_terms(sum, t);
  add_averaged(sum, t);
  return sum.value();
}

std::uint64_t fingerprint(const TopologyTextures& t, std::span<const Index> removed, const BodyCuts& cuts) {
  const std::uint64_t built = t.built ? *t.built : fingerprint(t);
  if (removed.empty() && cuts.empty()) return built;
  Fnv sum;
  sum.add(built, std::vector<Index>(removed.begin(), removed.end()));
  for (const auto& cut : cuts) {
    for (const BodyCut::Change& change : cut->changed) {
      add_part(sum, change.row, change.before);
      add_part(sum, change.row, change.after);
    }
    for (const BodyCut::Added& added : cut->added) add_part(sum, added.of, added.part);
    for (const BodyCut::Copy& copy : cut->copies) sum.add(copy.particle, copy.of, copy.shared);
    for (const BodyCut::Mass& mass : cut->masses) sum.add(mass.particle, mass.before, mass.after);
  }
  return sum.value();
}

}  // namespace phymul

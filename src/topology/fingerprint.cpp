// SPDX-License-Identifier: MIT
#include <phymul/topology_textures.h>

#include "base/fnv.h"
#include "energies.h"

namespace phymul {
namespace {

// Files hold fingerprints: the numbers of enumerators never change, whatever their order.
std::int32_t number_of(Law law) {
  return law == Law::springs ? 0 : law == Law::shape_memory ? 1 : 2;
}

std::int32_t number_of(VolumeLaw law) {
  return law == VolumeLaw::quadratic ? 0 : 1;
}

std::int32_t number_of(Reaction reaction) {
  switch (reaction) {
    case Reaction::full:
      return 0;
    case Reaction::shared:
      return 1;
    case Reaction::barycentric:
      return 2;
    case Reaction::averaged:
      return 3;
    case Reaction::conservative:
      break;
  }
  return 4;
}

void add_options(Fnv& sum, const TopologyOptions& options) {
  sum.add(number_of(options.law.value_or(Law::shape_memory)));
  sum.add(number_of(options.reaction));
  sum.add(number_of(options.volume_law));
  sum.add(kind_of(options.strain_energy).number);
}

void add_terms(Fnv& sum, const TopologyTextures& t) {
  sum.add(std::uint64_t{t.springs.size()});  // as wide on every system
  for (const SpringTexel& spring : t.springs) {
    sum.add(spring.end);
    sum.add(spring.rest_length);
    sum.add(spring.stiffness);
  }
  sum.add(std::uint64_t{t.volumes.size()});
  for (const VolumeTexel& volume : t.volumes) {
    sum.add(volume.vertex);
    sum.add(volume.inverse_rest_volume);
    sum.add(volume.stiffness);
  }
}

void add_averaged(Fnv& sum, const TopologyTextures& t) {
  if (t.domains.empty()) return;
  for (const DomainTexel& domain : t.domains) {
    sum.add(domain.particle);
    sum.add(domain.inverse_volume);
    sum.add(domain.spread_stiffness);
    for (const double constant : domain.energy) sum.add(constant);
  }
  sum.add(t.first_link);
  for (const LinkTexel& link : t.links) {
    sum.add(link.domain);
    sum.add(link.area);
    sum.add(link.stiffness);
  }
  sum.add(t.first_surface_link);
  for (const SurfaceLinkTexel& link : t.surface_links) {
    sum.add(link.domain);
    sum.add(link.area);
  }
  for (const DissipationTexel& texel : t.dissipation) {
    sum.add(texel.retardation_time);
    sum.add(texel.relaxation_strength);
    sum.add(texel.relaxation_time);
  }
}

}  // namespace

std::uint64_t fingerprint(const TopologyTextures& t) {
  Fnv sum;
  add_options(sum, t.options);
  sum.add(t.dimension);
  sum.add(t.particle_count);
  sum.add(t.rest);
  sum.add(t.mass);
  sum.add(t.stiffness);
  // Padding depends on the widest texture allowed, which moves nothing.
  for (Index i = 0; i < t.particle_count; ++i) {
    sum.add(t.index[i].neighbour_count);
    sum.add(t.index[i].base_count);
  }
  for (Index row = 0; row < t.neighbour_count; ++row) {
    sum.add(t.neighbours[row]);
    sum.add(t.alpha[row]);
  }
  for (Index row = 0; row < t.base_count; ++row) {
    sum.add(t.bases[row].vertex);
    sum.add(t.bases[row].beta);
  }
  sum.add(t.lambda);
  sum.add(t.weight);
  add_terms(sum, t);
  add_averaged(sum, t);
  return sum.value();
}

}  // namespace phymul

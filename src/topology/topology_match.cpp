// SPDX-License-Identifier: MIT
#include "topology_match.h"

#include <phymul/error.h>
#include <phymul/topology_textures.h>

#include <string>
#include <vector>

#include "base/fnv.h"
#include "energies.h"
#include "model/cell_geometry.h"

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

std::uint64_t of_cells(const Model& model) {
  Fnv sum;
  for (const Cell& cell : model.cells) {
    const bool clamped = cell.type == CellType::line && cell.material >= 0;
    if (!(clamped || is_wall(model, cell) || is_solid(model.dimension, cell))) continue;
    sum.add(cell.type, std::uint64_t{cell.particles.size()}, cell.particles);  // sizes as wide on every system
    if (cell.share != 1.0) sum.add(cell.share);
  }
  return sum.value();
}

void add_elasticity(Fnv& sum, const Material& material) {
  sum.add(material.young, material.poisson, material.retardation_time, material.relaxation_strength,
          material.relaxation_time);
  if (material.thickness > 0.0) sum.add(material.thickness);
  const Stiffening& of = material.stiffening;
  if (of != Stiffening{}) sum.add(of.exponential, of.exponent, of.second, of.second_fades);
}

/// Cell by cell: a row of Model::materials that no cell has moves nothing. Rows count, because
/// Scene::stiffness_factors() are by row.
std::uint64_t of_materials(const Model& model) {
  Fnv sum;
  sum.add(model.materials.empty());
  if (model.materials.empty()) return sum.value();
  if (is_body_of_points(model)) {
    for (const Material& material : model.materials) {
      add_elasticity(sum, material);
      sum.add(material.density);  // by which masses are volumes
    }
    return sum.value();
  }
  std::vector<std::uint64_t> hashes;  // of each material and its row
  for (const Material& material : model.materials) {
    Fnv one;
    one.add(std::uint64_t{hashes.size()});
    add_elasticity(one, material);
    one.add(material.fibre_ratio);
    hashes.push_back(one.value());
  }
  for (const Cell& cell : model.cells) {
    if (!(is_wall(model, cell) || is_solid(model.dimension, cell))) continue;
    const bool known = cell.material >= 0 && static_cast<std::size_t>(cell.material) < hashes.size();
    sum.add(known ? hashes[cell.material] : std::uint64_t{0});
    if (known && model.materials[cell.material].fibre_ratio > 1.0) sum.add(cell.fibre);
  }
  return sum.value();
}

std::uint64_t of_neighbours(const Model& model) {
  Fnv sum;
  sum.add(model.neighbours.offset, model.neighbours.entry);
  return sum.value();
}

std::uint64_t of_stiffness(const Model& model) {
  Fnv sum;
  if (model.materials.empty()) sum.add(model.stiffness);
  return sum.value();
}

[[noreturn]] void refuse(const std::string& difference) {
  throw Error("the tables were built for another model, or before this one was changed: " + difference +
              "; build them anew with build_topology, or undo the change");
}

void require_same(std::uint64_t built, std::uint64_t own, const char* difference) {
  if (built != own) refuse(difference);
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

ModelFingerprint model_fingerprint(const Model& model) {
  return {.neighbours = of_neighbours(model),
          .cells = of_cells(model),
          .materials = of_materials(model),
          .stiffness = of_stiffness(model)};
}

void require_same_body(const TopologyTextures& topology, const Model& model) {
  if (topology.particle_count != model.particle_count()) {
    throw Error("the tables were built for " + std::to_string(topology.particle_count) +
                " particles, the scene's model has " + std::to_string(model.particle_count()) +
                "; build them anew with build_topology");
  }
  if (topology.dimension != model.dimension) {
    refuse("it had " + std::to_string(topology.dimension) + " dimensions, the scene's has " +
           std::to_string(model.dimension));
  }
  for (Index i = 0; i < topology.particle_count; ++i) {
    const bool same_place = topology.rest[i] == model.rest[i];
    if (same_place && topology.mass[i] == model.mass[i]) continue;
    refuse("particle " + std::to_string(i) + " has another " + (same_place ? "mass" : "rest place") + " there");
  }
  if (!topology.model) return;  // not from build_topology
  const ModelFingerprint own = model_fingerprint(model);
  require_same(topology.model->cells, own.cells, "its cells were others, or in another order");
  require_same(topology.model->materials, own.materials,
               "cells had another Young's modulus, Poisson's ratio, dissipation, stiffening or row of "
               "Model::materials, or none");
  require_same(topology.model->stiffness, own.stiffness, "particles had another stiffness");
  require_same(topology.model->neighbours, own.neighbours, "particles had other neighbours, or in another order");
}

}  // namespace phymul

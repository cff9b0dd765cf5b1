// SPDX-License-Identifier: MIT
#include "methods.h"

#include <phymul/elasticity.h>
#include <phymul/error.h>
#include <phymul/topology_textures.h>

#include <algorithm>

namespace phymul::bench {
namespace {

std::vector<Method> make_methods() {
  std::vector<Method> all;
  const auto springs = [&](std::string name, std::string label, int neighbours, bool volume) {
    Method& it = all.emplace_back();
    it.name = std::move(name), it.label = std::move(label);
    it.rule = StiffnessRule::lattice;
    it.neighbours = neighbours;
    it.volume_energy = volume;
    it.options.law = Law::springs;
    it.options.volume_law = VolumeLaw::quadratic;
  };
  springs("springs_6", "springs, 6 neighbours", 6, false);
  springs("springs_18", "springs, 18 neighbours", 18, false);
  springs("springs_26", "springs, 26 neighbours", 26, false);
  springs("springs_18_volume", "springs, 18, and volume", 18, true);
  const auto reaction = [&](std::string name, std::string label, Reaction kind) {
    Method& it = all.emplace_back();
    it.name = std::move(name), it.label = std::move(label);
    it.rule = StiffnessRule::stretched;
    it.options.reaction = kind;
    it.options.on_sparse = SparseParticle::springs;
  };
  reaction("full", "shape memory, full reaction", Reaction::full);
  reaction("shared", "shape memory, shared reaction", Reaction::shared);
  reaction("barycentric", "shape memory, barycentric reaction", Reaction::barycentric);
  reaction("averaged", "shape memory, averaged", Reaction::averaged);
  Method& material = all.emplace_back();
  material.name = "particle_averaged", material.label = "material";
  return all;
}

/// Whether places a and b of a hexahedron (wedge) are joined by an edge, or by a face diagonal.
int steps_apart(CellType type, int a, int b) {
  if (type == CellType::hexahedron) {
    const auto bits = [](int v) { return (v & 4) | ((v & 3) ^ ((v & 2) >> 1)); };  // ring 0-1-2-3 to x, y bits
    const int apart = bits(a) ^ bits(b);
    return (apart & 1) + (apart >> 1 & 1) + (apart >> 2 & 1);
  }
  if (type == CellType::wedge) return (a % 3 != b % 3) + (a / 3 != b / 3);
  return 1;
}

RaggedList neighbours_within_cells(const Model& model, int neighbours) {
  const int most = neighbours == 6 ? 1 : neighbours == 18 ? 2 : 3;
  std::vector<std::vector<Index>> rows(model.rest.size());
  for (const Cell& cell : model.cells) {
    if (!is_volume(cell.type)) continue;
    const int count = static_cast<int>(cell.particles.size());
    for (int a = 0; a < count; ++a) {
      for (int b = 0; b < count; ++b) {
        if (a != b && steps_apart(cell.type, a, b) <= most) rows[cell.particles[a]].push_back(cell.particles[b]);
      }
    }
  }
  RaggedList list;
  for (std::vector<Index>& row : rows) {
    std::ranges::sort(row);
    row.erase(std::ranges::unique(row).begin(), row.end());
    list.push_row(row.begin(), row.end());
  }
  return list;
}

}  // namespace

const std::vector<Method>& all_methods() {
  static const std::vector<Method> methods = make_methods();
  return methods;
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& method : all_methods()) names.push_back(method.name);
  return names;
}

MethodBody body_for(const Method& method, const Problem& problem) {
  MethodBody body{problem.model, method.options};
  if (method.rule == StiffnessRule::material) return body;
  const Material material = body.model.materials.front();
  body.model.materials.clear();
  for (Cell& cell : body.model.cells) cell.material = -1;
  if (method.rule == StiffnessRule::lattice) {
    body.model.neighbours = neighbours_within_cells(body.model, method.neighbours);
  }
  if (method.volume_energy) {
    // A lattice of equal springs along edges and face diagonals has lambda = mu; the volume energy adds the rest.
    const double mu = material.young / (2 * (1 + material.poisson));
    const double lambda = 2 * mu * material.poisson / (1 - 2 * material.poisson);
    if (lambda <= mu) throw Error("springs have Poisson's ratio 1/4 by themselves; a volume energy cannot lower it");
    body.options.volume_stiffness = lambda - mu;
  }
  set_stiffness(body, 1.0);
  return body;
}

void set_stiffness(MethodBody& body, double stiffness) {
  body.model.stiffness.assign(body.model.rest.size(), stiffness);
}

double spring_stiffness(const MethodBody& body, const Material& material) {
  const double strain = 1e-5;
  const auto mean_energy = [&](const TopologyOptions& options) {
    const TopologyTextures topology = build_topology(body.model, options);
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 scale = Vec3::Constant(1 - material.poisson * strain);
      scale[axis] = 1 + strain;
      VecList x = body.model.rest;
      for (Vec3& p : x) p = p.cwiseProduct(scale);
      sum += elastic_energy(topology, x) / 3;
    }
    return sum;
  };
  TopologyOptions springs_alone = body.options;
  springs_alone.volume_stiffness = 0.0;
  const double springs = mean_energy(springs_alone);
  const double volume_part = body.options.volume_stiffness > 0.0 ? mean_energy(body.options) - springs : 0.0;
  const double wanted = 0.5 * material.young * strain * strain * volume(body.model, body.model.rest);
  return (wanted - volume_part) / springs;
}

}  // namespace phymul::bench

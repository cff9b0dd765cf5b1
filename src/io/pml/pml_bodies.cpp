// SPDX-License-Identifier: MIT
#include "pml_bodies.h"

#include <phymul/error.h>
#include <phymul/pml.h>
#include <phymul/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "base/decimal.h"
#include "model/body_type.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

using Ends = std::array<Index, 2>;

[[noreturn]] void fail(const Component& component, const std::string& what) {
  throw Error(ErrorCode::invalid_model, "component \"" + component.name + "\": " + what);
}

/// An attribute of 0 or more; `missing` where the file has none.
double number_of(const Component& component, const char* name, const char* unit, double missing) {
  const std::string_view text = attribute_of(component, name);
  if (text.data() == nullptr) return missing;
  const std::optional<double> value = parse_decimal(text);
  if (value && *value >= 0.0) return *value;
  fail(component, std::string("expected a ") + name + " of 0 " + unit + " or more, got \"" + std::string(text) + '"');
}

/// Edges of the cells without a material, and the long diagonals of hexahedra, each once.
std::vector<Ends> net_of(const Model& model, const Component& component) {
  constexpr std::array<CellEdge, 4> diagonals{{{0, 6}, {1, 7}, {2, 4}, {3, 5}}};
  std::vector<Ends> net;
  const auto add = [&net](const Cell& cell, std::span<const CellEdge> edges) {
    for (const auto [a, b] : edges) {
      const auto [first, last] = std::minmax(cell.particles[a], cell.particles[b]);
      net.push_back({first, last});
    }
  };
  for (const Index row : component.cells) {
    const Cell& cell = model.cells[row];
    if (cell.material >= 0) continue;
    add(cell, cell_edges(cell.type));
    if (cell.type == CellType::hexahedron) add(cell, diagonals);
  }
  std::ranges::sort(net);
  const auto again = std::ranges::unique(net);
  net.erase(again.begin(), again.end());
  return net;
}

/// Particles of the body that an attribute names; empty where the file has no such attribute.
std::vector<Index> body_of(const Model& model, const Component& component, const char* name) {
  const std::string_view body = attribute_of(component, name);
  if (body.data() == nullptr) return {};
  const auto found = std::ranges::find(model.components, body, &Component::name);
  if (found == model.components.end()) {
    fail(component, std::string("expected the name of a component in ") + name + ", got \"" + std::string(body) + '"');
  }
  return own_particles(model, *found);
}

/// The lines of an interaction, from the first body to the second.
std::vector<Ends> lines_of(const Model& model, const Component& component) {
  const std::array<std::vector<Index>, 2> bodies{body_of(model, component, "body1"),
                                                 body_of(model, component, "body2")};
  std::vector<Ends> lines;
  for (const Index row : component.cells) {
    const Cell& cell = model.cells[row];
    if (cell.type != CellType::line) {
      fail(component, "expected lines in an interaction, got a " + std::string(cell_name(cell.type)));
    }
    const Ends ends{cell.particles[0], cell.particles[1]};
    for (std::size_t k = 0; k < 2; ++k) {
      if (bodies[k].empty() || std::ranges::binary_search(bodies[k], ends[k])) continue;
      fail(component, "expected each line to go from a particle of body1 to one of body2, but particle " +
                          std::to_string(model.file_index(ends[k])) + " is not in \"" +
                          std::string(attribute_of(component, k == 0 ? "body1" : "body2")) + '"');
    }
    lines.push_back(ends);
  }
  return lines;
}

Joint joint_of(const Component& component, const std::vector<Ends>& springs) {
  Joint joint;
  joint.stiffness = number_of(component, "stiffness", "N/m", -1.0);
  if (joint.stiffness < 0.0) fail(component, "expected a stiffness in N/m for its springs, got none");
  joint.damping = number_of(component, "damping", "N s/m", 0.0);
  for (const auto [a, b] : springs) joint.springs.push_back({.a = at_particle(a), .b = at_particle(b)});
  return joint;
}

}  // namespace

std::vector<char> interaction_cells(const Model& model) {
  std::vector<char> chosen(model.cells.size(), 0);
  for (const Component& component : model.components) {
    if (body_type(component) != "interaction") continue;
    for (const Index row : component.cells) chosen[row] = 1;
  }
  return chosen;
}

std::vector<Index> densities_from_masses(Model& model) {
  if (std::ranges::none_of(model.materials, [](const Material& it) { return it.density == 0.0; })) return {};
  const auto measure = [&model](const Cell& cell) {
    return is_solid(model.dimension, cell.type) ? std::abs(signed_measure(model.dimension, cell, model.rest)) : 0.0;
  };
  const auto share = [&](const Cell& cell) { return measure(cell) / static_cast<double>(cell.particles.size()); };
  std::vector<double> around(model.rest.size(), 0.0);  // [N] m^3, of the cells of each particle
  for (const Cell& cell : model.cells) {
    for (const Index i : cell.particles) around[i] += share(cell);
  }
  std::vector<double> mass(model.materials.size(), 0.0), volume(model.materials.size(), 0.0);
  for (const Cell& cell : model.cells) {
    if (cell.material < 0 || measure(cell) == 0.0) continue;
    volume[cell.material] += measure(cell);
    for (const Index i : cell.particles) mass[cell.material] += model.mass[i] * share(cell) / around[i];
  }
  std::vector<Index> found;
  for (std::size_t row = 0; row < model.materials.size(); ++row) {
    Material& material = model.materials[row];
    if (material.density != 0.0 || volume[row] == 0.0) continue;
    const double density = mass[row] / volume[row];
    if (!(density > 0.0) || !std::isfinite(density)) continue;
    material.density = density;
    found.push_back(static_cast<Index>(row));
  }
  for (Cell& cell : model.cells) {
    if (cell.material < 0) continue;
    const auto first = std::ranges::find(model.materials, model.materials[cell.material]);
    cell.material = static_cast<Index>(first - model.materials.begin());
  }
  return found;
}

std::vector<std::string> add_body_types(Scene& scene) {
  const Model& model = scene.model();
  std::vector<std::string> done;
  std::vector<std::vector<Index>> held;
  std::vector<std::pair<std::string, Joint>> joints;
  int colliding = 0;
  for (const Component& component : model.components) {
    const std::string_view type = body_type(component);
    if (type.empty()) continue;
    if (attribute_of(component, "collision") == "true") ++colliding;
    const std::string label = "component \"" + component.name + "\" (bodyType \"" + std::string(type) + "\"): ";
    if (is_immovable(component)) {
      held.push_back(own_particles(model, component));
      done.push_back(label + "its " + std::to_string(held.back().size()) + " particle(s) are held");
    } else if (type == "interaction" || type == "stiffSpring") {
      const std::vector<Ends> springs = type == "interaction" ? lines_of(model, component) : net_of(model, component);
      if (springs.empty()) {
        done.push_back(label + "no springs, because it has no edges of cells without a material");
        continue;
      }
      joints.emplace_back(component.name, joint_of(component, springs));
      done.push_back(label + std::to_string(springs.size()) + " spring(s) of " +
                     to_decimal(joints.back().second.stiffness) + " N/m");
    } else if (type == "FEM") {
      const bool elastic =
          std::ranges::any_of(component.cells, [&](Index it) { return model.cells[it].material >= 0; });
      done.push_back(label + (elastic ? "its cells have a material"
                                      : "its cells have no material, because it has no young and poisson"));
    } else {
      done.push_back(label + "nothing is added; known are FEM, stiffSpring, rigid and interaction");
    }
  }
  Scene filled(scene);  // an error leaves `scene` as it was
  for (auto& [name, joint] : joints) filled.add_joint(name, joint);
  for (const std::vector<Index>& particles : held) scene.fix(particles);
  for (auto& [name, joint] : joints) scene.add_joint(name, std::move(joint));
  if (colliding > 1 && model.dimension == 3 && !scene.contacts()) {
    scene.contacts({});
    done.push_back("contacts, because " + std::to_string(colliding) + " components have collision=\"true\"");
  }
  return done;
}

}  // namespace phymul

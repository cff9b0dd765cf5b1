// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/pml.h>
#include <phymul/scene.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
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

/// An attribute of 0 or more, if there is one.
std::optional<double> number_of(const Component& component, const char* name, const char* unit) {
  const std::string_view text = attribute_of(component, name);
  if (text.data() == nullptr) return std::nullopt;
  const std::optional<double> value = parse_decimal(text);
  if (value && *value >= 0.0) return value;
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
  for (const Index row : cells_of(component)) {
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

/// Particles of the body that an attribute names; none where there is no such attribute.
std::optional<std::vector<Index>> body_of(const Model& model, const Component& component, const char* attribute) {
  const std::string_view body = attribute_of(component, attribute);
  if (body.data() == nullptr) return std::nullopt;
  if (model.has_group(body)) return model.group(body);
  // In a merged model the body is called as the component is.
  const std::string beside = component.name.substr(0, component.name.rfind('/') + 1) + std::string(body);
  if (model.has_group(beside)) return model.group(beside);
  fail(component,
       std::string("expected the name of a component in ") + attribute + ", got \"" + std::string(body) + '"');
}

/// The lines of an interaction.
std::vector<Ends> lines_of(const Model& model, const Component& component) {
  const std::array bodies{body_of(model, component, "body1"), body_of(model, component, "body2")};
  const auto is_in = [&bodies](std::size_t body, Index particle) {
    return !bodies[body] || std::ranges::binary_search(*bodies[body], particle);
  };
  std::vector<Ends> lines;
  for (const Index row : cells_of(component)) {
    const Cell& cell = model.cells[row];
    if (cell.type != CellType::line) continue;
    const Ends ends{cell.particles[0], cell.particles[1]};
    if (ends[0] == ends[1]) {
      fail(component, "expected lines between two particles, got one from " +
                          std::to_string(model.file_index(ends[0])) + " to itself");
    }
    if (!(is_in(0, ends[0]) && is_in(1, ends[1])) && !(is_in(0, ends[1]) && is_in(1, ends[0]))) {
      fail(component, "expected lines between particles of body1 and body2, but that from " +
                          std::to_string(model.file_index(ends[0])) + " to " +
                          std::to_string(model.file_index(ends[1])) + " is none; both attributes may be left out");
    }
    lines.push_back(ends);
  }
  return lines;
}

/// What is to be added to a scene, and what to say of it.
class BodyTypes {
 public:
  explicit BodyTypes(const Model& model) : model_(model) {
    for (const Component& component : model.components) {
      const std::string_view type = body_type(component);
      if (type.empty()) continue;
      if (attribute_of(component, "collision") == "true") ++colliding_;
      const std::string added = add(component, type);
      done.push_back("component \"" + component.name + "\" (bodyType \"" + std::string(type) + "\"): " + added);
    }
  }

  std::vector<Index> held;
  std::vector<std::pair<std::string, Joint>> joints;
  std::vector<std::string> done;

  void add_contacts_to(Scene& scene) {
    if (colliding_ < 2 || model_.dimension == 2 || scene.contacts()) return;
    scene.contacts({});
    done.push_back("contacts, because " + std::to_string(colliding_) + " components have collision=\"true\"");
  }

 private:
  std::string add(const Component& component, std::string_view type) {
    if (is_immovable(component)) return hold(component);
    if (type == "interaction") return join(component, lines_of(model_, component), "it has no lines");
    if (type == "stiffSpring") {
      return join(component, net_of(model_, component), "it has no edges of cells without a material");
    }
    if (type != "FEM") return "nothing is added; known are FEM, stiffSpring, rigid and interaction";
    const auto has_material = [this](Index cell) { return model_.cells[cell].material >= 0; };
    return std::ranges::any_of(cells_of(component), has_material)
               ? "its cells have a material"
               : "its cells have no material, which takes young, poisson, and masses or a density";
  }

  std::string hold(const Component& component) {
    const std::vector<Index> particles = particles_of(model_, component);
    held.insert(held.end(), particles.begin(), particles.end());
    if (particles.empty()) return "nothing is held, because it has no cells or particles of its own";
    return "its " + std::to_string(particles.size()) + " particle(s) are held";
  }

  std::string join(const Component& component, const std::vector<Ends>& springs, const std::string& none_because) {
    const std::optional<double> stiffness = number_of(component, "stiffness", "N/m");
    const double damping = number_of(component, "damping", "N s/m").value_or(0.0);
    if (springs.empty()) return "no springs, because " + none_because;
    if (!stiffness) return "no springs, because it has no stiffness in N/m";
    Joint joint{.stiffness = *stiffness, .damping = damping};
    for (const auto [a, b] : springs) joint.springs.push_back({.a = at_particle(a), .b = at_particle(b)});
    joints.emplace_back(free_name(component), std::move(joint));
    return std::to_string(springs.size()) + " spring(s) of " + to_decimal(*stiffness) + " N/m";
  }

  std::string free_name(const Component& component) {
    const std::string name = component.name.empty() ? std::string(body_type(component)) : component.name;
    std::string free = name;
    while (!next_of_name_.try_emplace(free, 2).second) free = name + ' ' + std::to_string(next_of_name_.at(name)++);
    return free;
  }

  const Model& model_;
  int colliding_ = 0;
  std::map<std::string, int> next_of_name_;  // by the name of a joint: the number that another one of that name gets
};

}  // namespace

std::vector<std::string> add_body_types(Scene& scene) {
  BodyTypes types(scene.model());
  Scene checked = scene.copy();  // an error leaves `scene` as it was
  for (const auto& [name, joint] : types.joints) checked.add_joint(name, joint);
  if (!types.held.empty()) scene.fix(types.held);
  for (auto& [name, joint] : types.joints) scene.add_joint(name, std::move(joint));
  types.add_contacts_to(scene);
  return std::move(types.done);
}

}  // namespace phymul

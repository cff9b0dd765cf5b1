// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>
#include <phymul/body.h>
#include <phymul/error.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "base/files.h"
#include "base/union_find.h"
#include "loose_parts.h"
#include "model/body_type.h"
#include "model/cell_cutter.h"
#include "model/cell_geometry.h"
#include "model/file_extras.h"
#include "scene_items.h"

namespace phymul {
namespace {

constexpr const char* all_bodies = "Bodies";  // the parent of their groups

void require_joinable(std::span<const NamedBody> bodies) {
  if (bodies.empty()) throw Error("merge_models: expected one body or more, got none");
  std::set<std::string> taken{all_bodies};
  for (const NamedBody& body : bodies) {
    const std::string label = "merge_models: body \"" + body.name + "\": ";
    if (body.model == nullptr) throw Error(label + "expected a model, got none");
    if (body.name.empty() || body.name.find('/') != std::string::npos) {
      throw Error(label +
                  "expected a name that is not empty and without '/', which stands between a body and its "
                  "groups");
    }
    if (!taken.insert(body.name).second)
      throw Error(label + "expected a name of its own; another body has it, or their common group");
    if (body.model->dimension != bodies.front().model->dimension) {
      throw Error(label + "expected " + std::to_string(bodies.front().model->dimension) +
                  " dimensions, as the first body has, got " + std::to_string(body.model->dimension));
    }
    if (body.model->materials.empty() != bodies.front().model->materials.empty()) {
      throw Error(label + "expected a material on every body or on none; set_material gives one");
    }
    try {
      validate(*body.model);
    } catch (const Error& error) {
      throw with_prefix(label, error);
    }
  }
}

Index shifted(Index row, Index by) {
  return row < 0 ? row : row + by;
}

void shift(std::vector<Index>& rows, Index by) {
  for (Index& row : rows) row += by;
}

/// Rows of [N] or empty lists; `first`: row of the first new particle, `count`: N with them.
template <class Rows>
void append_rows(Rows& all, const Rows& added, Index first, std::size_t count) {
  if (added.empty() && all.empty()) return;
  all.resize(static_cast<std::size_t>(first));
  all.insert(all.end(), added.begin(), added.end());
  all.resize(count);
}

/// The spare particles of all bodies come after all others.
Model without_spare_particles(Model body) {
  Index kept = body.particle_count();
  const std::vector<Index> spare = spare_particles_of(body);
  for (auto own = spare.rbegin(); own != spare.rend() && *own == kept - 1; ++own) --kept;
  if (kept == body.particle_count()) return body;
  body.rest.resize(kept);
  body.mass.resize(kept);
  body.stiffness.resize(kept);
  body.neighbours.offset.resize(kept + 1);
  for (Component& component : body.components) std::erase_if(component.particles, [&](Index i) { return i >= kept; });
  body.extras = nullptr;
  return body;
}

void append_particles(Model& all, const Model& body, Index first) {
  all.rest.insert(all.rest.end(), body.rest.begin(), body.rest.end());
  all.mass.insert(all.mass.end(), body.mass.begin(), body.mass.end());
  all.stiffness.insert(all.stiffness.end(), body.stiffness.begin(), body.stiffness.end());
  std::vector<Index> row;
  for (Index i = 0; i < body.neighbours.rows(); ++i) {
    row.assign(body.neighbours.begin(i), body.neighbours.end(i));
    shift(row, first);
    all.neighbours.push_row(row.begin(), row.end());
  }
  change_extras(all, [&](FileExtras& extras) {
    append_rows(extras.particle_name, extras_of(body).particle_name, first, all.rest.size());
    append_rows(extras.particle_fields, extras_of(body).particle_fields, first, all.rest.size());
  });
}

/// Equal materials are one row, as set_material leaves them.
void append_cells(Model& all, const Model& body, Index first) {
  std::vector<Index> material_row;
  for (const Material& material : body.materials) {
    const auto known = std::find(all.materials.begin(), all.materials.end(), material);
    material_row.push_back(static_cast<Index>(known - all.materials.begin()));
    if (known == all.materials.end()) all.materials.push_back(material);
  }
  for (Cell cell : body.cells) {
    shift(cell.particles, first);
    if (cell.material >= 0) cell.material = material_row[cell.material];
    all.cells.push_back(std::move(cell));
  }
}

void append_components(Model& all, const Model& body, const std::string& name, Index first, Index first_cell) {
  const Index offset = static_cast<Index>(all.components.size());
  for (Component component : body.components) {
    if (!component.name.empty()) component.name = name + '/' + component.name;
    component.parent = shifted(component.parent, offset);
    shift(component.cells, first_cell);
    shift(component.cell_refs, first_cell);
    shift(component.particles, first);
    all.components.push_back(std::move(component));
  }
  Component own{.name = name, .parent = 0, .exclusive = false};
  own.particles.resize(body.rest.size());
  std::iota(own.particles.begin(), own.particles.end(), first);
  all.components.push_back(std::move(own));
}

/// [cells] Whether it joins its particles. Lists only name them; so do faces and edges of a mesh file that lie on
/// tissue, or on what was removed: they hold nothing together that a cut parts.
std::vector<char> joining_cells(const Model& model) {
  std::vector<char> in_tissue(model.rest.size(), 0);
  for (const Cell& cell : model.cells) {
    if (!is_tissue(model, cell)) continue;
    for (const Index i : cell.particles) in_tissue[i] = 1;
  }
  std::vector<char> joins = interaction_cells(model);
  for (std::size_t row = 0; row < joins.size(); ++row) {
    const Cell& cell = model.cells[row];
    const auto is_in_tissue = [&](Index i) { return in_tissue[i] != 0; };
    joins[row] = joins[row] == 0 && cell_size(cell.type) != 0 && cell.share != 0.0 &&
                 (is_tissue(model, cell) || !std::ranges::all_of(cell.particles, is_in_tissue));
  }
  return joins;
}

}  // namespace

Model merge_models(std::span<const NamedBody> bodies) {
  require_joinable(bodies);
  Model all;
  all.dimension = bodies.front().model->dimension;
  all.most_mass_moved = 1.0;
  Component names;
  names.name = all_bodies;
  names.exclusive = names.structural = false;
  all.components.push_back(std::move(names));
  Index spare = 0;
  for (const auto& [name, model] : bodies) {
    const Model body = without_spare_particles(*model);
    spare += model->particle_count() - body.particle_count();
    const Index first = all.particle_count(), first_cell = static_cast<Index>(all.cells.size());
    all.name += (all.name.empty() ? "" : "+") + name;
    append_particles(all, body, first);
    append_cells(all, body, first);
    append_components(all, body, name, first, first_cell);
    all.most_mass_moved = std::min(all.most_mass_moved, body.most_mass_moved);
    for (const std::string& note : body.notes) all.notes.push_back(name + ": " + note);
  }
  if (spare > 0) return with_spare_particles(std::move(all), spare);
  validate(all);
  return all;
}

Model moved(Model model, const Vec3& by) {
  for (Vec3& x : model.rest) x += by;
  validate(model);
  return model;
}

Load for_merged(Load load, Index first) {
  shift(load.particles, first);
  load.toward = shifted(load.toward, first);
  return load;
}

BodyRows body_rows(const Model& model) {
  UnionFind sets(model.rest.size());
  // Lists of neighbours do not follow cuts and removals.
  const bool whole =
      std::ranges::all_of(model.cells, [](const Cell& cell) { return cell.share == 1.0 && cell.cuts.empty(); });
  for (Index i = 0; whole && i < model.neighbours.rows(); ++i) {
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) sets.join(i, *j);
  }
  const std::vector<char> joins = joining_cells(model);
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    if (joins[row] == 0) continue;
    for (const Index i : model.cells[row].particles) sets.join(model.cells[row].particles.front(), i);
  }
  BodyRows rows{std::vector<Index>(model.rest.size(), -1), 0};
  std::vector<Index> row_of(model.rest.size(), -1);  // of roots
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (!model.mass.empty() && model.mass[i] == 0.0) continue;  // of surfaces alone there are no masses
    Index& row = row_of[sets.root(i)];
    if (row < 0) row = rows.count++;
    rows.of[i] = row;
  }
  return rows;
}

std::vector<ConnectedBody> connected_bodies(const Model& model) {
  const BodyRows rows = body_rows(model);
  std::vector<ConnectedBody> bodies(rows.count);
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (rows.of[i] >= 0) bodies[rows.of[i]].particles.push_back(i);
  }
  const std::vector<char> joins = joining_cells(model);
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Cell& cell = model.cells[row];
    if (joins[row] == 0) continue;
    Index own = -1;
    for (const Index i : cell.particles) own = std::max(own, rows.of[i]);
    if (own < 0) continue;  // a triangle that lies where all is removed
    ConnectedBody& body = bodies[own];
    body.cells.push_back(static_cast<Index>(row));
    body.volume += tissue_volume(model, cell);
  }
  std::set<std::string> seen;
  for (const Component& component : model.components) {
    if (component.name.empty() || !seen.insert(component.name).second) continue;
    const std::vector<Index> group = model.group(component.name);
    if (group.empty() || rows.of[group.front()] < 0) continue;
    ConnectedBody& body = bodies[rows.of[group.front()]];
    const bool shorter = body.name.empty() || component.name.size() < body.name.size();
    if (shorter && body.particles == group) body.name = component.name;
  }
  return bodies;
}

namespace {

/// Calls visit(spring) for those that hold.
template <class Visit>
void for_each_spring(const Scene& scene, std::span<const JointState> joints, const Visit& visit) {
  for (const SceneJoint& joint : scene.joints()) {
    if (!(joint.joint.stiffness > 0.0)) continue;
    const auto state = std::ranges::find(joints, joint.name, &JointState::name);
    const auto is_broken = [&](std::size_t row) {
      return state != joints.end() && std::ranges::binary_search(state->broken, static_cast<Index>(row));
    };
    for (std::size_t row = 0; row < joint.joint.springs.size(); ++row) {
      if (!is_broken(row)) visit(joint.joint.springs[row]);
    }
  }
}

bool holds(const Load& load) {
  return load.type == LoadType::rotation ||
         (load.type == LoadType::translation &&
          std::ranges::any_of(load.axes, [](Axis axis) { return axis != Axis::free; }));
}

/// Whether loads other than imposed positions act on the part.
bool is_pushed(const ConnectedBody& part, const Scene& scene) {
  if (scene.gravity() != Vec3::Zero()) return true;
  return std::ranges::any_of(scene.loads(), [&](const Load& load) {
    return !imposes(load.type) &&
           std::ranges::any_of(load.particles, [&](Index i) { return std::ranges::binary_search(part.particles, i); });
  });
}

}  // namespace

bool may_hold_any(const Scene& scene) {
  return scene.contacts() || !scene.tools().empty() || !scene.threads().empty();
}

std::vector<char> held_particles(const Scene& scene, std::span<const JointState> joints) {
  std::vector<char> is_held(scene.model().rest.size(), 0);
  for (const Load& load : scene.loads()) {
    if (!holds(load)) continue;
    for (const Index i : load.particles) is_held[i] = 1;
  }
  for_each_spring(scene, joints, [&](const JointSpring& spring) {
    if (!spring.a.particles.empty() && !spring.b.particles.empty()) return;
    for (const Anchor* end : {&spring.a, &spring.b}) {
      for (const Index i : end->particles) is_held[i] = 1;
    }
  });
  return is_held;
}

std::vector<ConnectedBody> loose_parts(const Scene& scene, const std::vector<char>& is_held,
                                       std::span<const JointState> joints) {
  std::vector<ConnectedBody> parts = connected_bodies(scene.model());
  // One more for particles that were removed.
  std::vector<std::size_t> part_of(is_held.size(), parts.size());
  std::vector<char> part_is_held(parts.size() + 1, 0);
  for (std::size_t row = 0; row < parts.size(); ++row) {
    for (const Index i : parts[row].particles) {
      part_of[i] = row;
      part_is_held[row] |= is_held[i];
    }
  }
  for (bool spreads = true; spreads;) {
    spreads = false;
    for_each_spring(scene, joints, [&](const JointSpring& spring) {
      if (spring.a.particles.empty() || spring.b.particles.empty()) return;
      const std::size_t of_a = part_of[spring.a.particles.front()], of_b = part_of[spring.b.particles.front()];
      char &a = part_is_held[of_a], &b = part_is_held[of_b];
      if (std::max(of_a, of_b) == parts.size() || a == b) return;
      spreads = true;
      a = b = 1;
    });
  }
  std::erase_if(parts, [&](const ConnectedBody& part) { return part_is_held[part_of[part.particles.front()]] != 0; });
  return parts;
}

Index first_loose(const Scene& scene, std::span<const JointState> joints) {
  if (may_hold_any(scene)) return -1;
  for (const ConnectedBody& part : loose_parts(scene, held_particles(scene, joints), joints)) {
    if (is_pushed(part, scene)) return part.particles.front();
  }
  return -1;
}

}  // namespace phymul

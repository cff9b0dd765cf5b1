// SPDX-License-Identifier: MIT
//
// Patches of the surface attached to the world, to a tool, or to another body.
#include <phymul/error.h>
#include <phymul/scene.h>
#include <phymul/skin.h>
#include <phymul/surface_patch.h>

#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "base/files.h"
#include "model/cell_geometry.h"
#include "model/group.h"
#include "model/outer_faces.h"
#include "scene_items.h"

namespace phymul {
namespace {

/// The layer between patch and world is as stiff as tissue of 1/25 of the spacing. Stiffer ones make a coarse body too
/// stiff: its cells cannot follow the stress at the edge of the patch. Softer ones let it move.
/// docs/measurements/accuracy.md, "Held patches".
constexpr double layers_in_spacing = 25.0;

/// Largest distance of a point from the body, in sizes of a cell: bodies round off the edges of their surface.
constexpr double most_outside = 2.0;

void require_patch(const Model& model, const SurfacePatch& patch) {
  if (model.dimension != 3) throw Error(ErrorCode::not_supported, "hold: expected a body in 3 dimensions");
  if (model.materials.empty()) {
    throw Error(
        "hold: expected a body with a material, from which the stiffness follows; call set_material, or fix() "
        "particles");
  }
  if (patch.points.empty() || patch.points.size() != patch.areas.size()) {
    throw Error("hold: expected points and as many areas, got " + std::to_string(patch.points.size()) + " and " +
                std::to_string(patch.areas.size()));
  }
  for (const double area : patch.areas) {
    if (!(area > 0.0) || !std::isfinite(area)) {
      throw Error("hold: expected finite areas above 0 m^2, got " + to_decimal(area));
    }
  }
}

Skin bound(const Model& model, const SurfacePatch& patch) {
  try {
    return {model, patch.points, most_outside};
  } catch (const Error& error) {
    throw with_prefix("hold: ", error);
  }
}

/// Per particle Young's modulus over the distance to its neighbours, Pa/m: means over its cells and their edges.
std::vector<double> modulus_over_spacing(const Model& model) {
  std::vector<double> modulus(model.rest.size(), 0.0), cells(modulus), distance(modulus), edges(modulus);
  const bool in_space = is_made_of_cells(model);  // then a capsule says nothing of the tissue below it
  for (const Cell& cell : model.cells) {
    if (cell.material < 0 || (in_space && !is_solid(model.dimension, cell))) continue;
    for (const Index i : cell.particles) {
      modulus[i] += model.materials[cell.material].young;
      cells[i] += 1.0;
      for (const Index j : cell.particles) {
        if (j == i) continue;
        distance[i] += (model.rest[j] - model.rest[i]).norm();
        edges[i] += 1.0;
      }
    }
  }
  for (std::size_t i = 0; i < modulus.size(); ++i) {
    if (cells[i] > 0.0) modulus[i] *= edges[i] / (cells[i] * distance[i]);
  }
  return modulus;
}

/// Share of the mean of stiffness over mass, weighted by stiffness.
constexpr double most_for_mass = 0.8;

/// Light particles, as at sharp edges, would set the step of the whole body, and they hold little. So the stiffness of
/// a particle is limited by its mass.
void spare_light_particles(Joint& joint, const std::vector<double>& mass) {
  std::vector<double> stiffness(mass.size(), 0.0);
  for (const JointSpring& spring : joint.springs) {
    double weights = 0.0;  // 1 for a point in the body
    for (const double w : spring.a.weights) weights += std::abs(w);
    for (std::size_t k = 0; k < spring.a.particles.size(); ++k) {
      stiffness[spring.a.particles[k]] += joint.stiffness * spring.share * weights * std::abs(spring.a.weights[k]);
    }
  }
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    sum += stiffness[i];
    if (stiffness[i] > 0.0) squares += stiffness[i] * stiffness[i] / mass[i];  // spare particles have no mass
  }
  const double most = most_for_mass * squares / sum;  // 1/s^2
  for (JointSpring& spring : joint.springs) {
    double factor = 1.0;
    for (const Index i : spring.a.particles) {
      if (stiffness[i] > most * mass[i]) factor = std::min(factor, most * mass[i] / stiffness[i]);
    }
    spring.share *= factor;
  }
}

}  // namespace

JointHandle Scene::hold(const SurfacePatch& patch) & {
  require_patch(*model_, patch);
  const Skin skin = bound(*model_, patch);
  const VecList places = skin.deform(model_->rest);
  const std::vector<double> stiffness = modulus_over_spacing(*model_);
  Joint joint;
  double area = 0.0;
  for (std::size_t k = 0; k < patch.points.size(); ++k) {
    const std::span<const Index> particles = skin.particles(k);
    const std::span<const double> weights = skin.weights(k);
    JointSpring spring{
        .a = {.particles = {particles.begin(), particles.end()}, .weights = {weights.begin(), weights.end()}},
        .b = at_world(places[k]),
        .rest_length = 0.0,
        .share = patch.areas[k]};
    double mean = 0.0;
    for (const Index i : particles) mean += stiffness[i] / static_cast<double>(particles.size());
    joint.stiffness += patch.areas[k] * layers_in_spacing * mean;
    area += patch.areas[k];
    joint.springs.push_back(std::move(spring));
  }
  joint.stiffness /= area;
  spare_light_particles(joint, model_->mass);
  return add_joint(default_name("joint", next_joint_, joints_), std::move(joint));
}

namespace {

void require_particles(std::span<const Index> patch, const Model& model) {
  if (patch.empty()) throw Error("attach: expected particles of the surface, got none");
  require_indices(patch, model.rest.size(), "particles", [] { return std::string("attach: "); });
}

/// [N] m^2, 0 off the patch.
std::vector<double> area_shares(const Model& model, std::span<const Index> patch) {
  std::vector<char> chosen(model.rest.size(), 0);
  for (const Index i : patch) chosen[i] = 1;
  const std::vector<Facet> facets = surface_facets(model, chosen);
  if (facets.empty()) {
    throw Error(
        "attach: expected particles that span facets of the surface, but no facet has all of its particles "
        "among the " +
        std::to_string(patch.size()) + " given; add_joint() joins single particles");
  }
  std::vector<double> share(model.rest.size(), 0.0);
  for (const Facet& facet : facets) {
    for (const Index i : facet.particles) share[i] += facet.area.norm() / static_cast<double>(facet.particles.size());
  }
  return share;
}

std::span<const Vec3> places(const Model& model, const Attachment& springs) {
  if (springs.position.empty()) return model.rest;
  if (springs.position.size() == model.rest.size()) {
    for (std::size_t i = 0; i < springs.position.size(); ++i) {
      if (springs.position[i].allFinite()) continue;
      throw Error("attach: expected finite positions, but that of particle " + std::to_string(i) + " is not");
    }
    return springs.position;
  }
  throw Error("attach: expected " + std::to_string(model.rest.size()) + " positions, or none; got " +
              std::to_string(springs.position.size()));
}

/// The volume cells of a group, at these positions.
Model partner_body(const Model& model, std::span<const Index> patch, std::string_view group,
                   std::span<const Vec3> position) {
  const std::vector<Index> members = model.group(group);
  for (const Index i : patch) {
    if (!std::ranges::binary_search(members, i)) continue;
    throw Error("attach: expected particles outside the group \"" + std::string(group) +
                "\", to which they are glued; particle " + std::to_string(i) + " belongs to it");
  }
  Model partner = part_of(model, group);
  partner.rest.assign(position.begin(), position.end());
  std::erase_if(partner.cells, [](const Cell& cell) { return !is_volume(cell.type); });
  if (!partner.cells.empty()) return partner;
  throw Error(
      "attach: expected a group with volume cells, mostly a whole body, to glue to; it lists none, and no cell has all "
      "its particles in \"" +
      std::string(group) + '"');
}

Skin bound(const Model& partner, const VecList& points, std::string_view group) {
  try {
    return {partner, points};
  } catch (const Error& error) {
    throw with_prefix("attach: expected each particle of the patch within one cell of \"" + std::string(group) + "\": ",
                      error);
  }
}

}  // namespace

JointHandle Scene::attach(std::span<const Index> patch, std::span<const Anchor> partners, double rest_length,
                          const Attachment& springs) {
  const std::vector<double> share = area_shares(*model_, patch);
  Joint joint{.stiffness = springs.stiffness,
              .damping = springs.damping,
              .slack = springs.slack,
              .breaking_force = springs.breaking_stress};
  std::vector<char> done(model_->rest.size(), 0);
  for (std::size_t k = 0; k < patch.size(); ++k) {
    const Index i = patch[k];
    if (share[i] == 0.0 || done[i] != 0) continue;
    done[i] = 1;
    joint.springs.push_back({at_particle(i), partners[k], rest_length, share[i]});
  }
  return add_joint(springs.name.empty() ? default_name("joint", next_joint_, joints_) : springs.name, std::move(joint));
}

JointHandle Scene::attach(std::span<const Index> patch, const World& world, const Attachment& springs) & {
  require_particles(patch, *model_);
  const std::span<const Vec3> position = places(*model_, springs);
  std::vector<Anchor> partners;
  for (const Index i : patch) partners.push_back(at_world(position[i] + world.offset));
  return attach(patch, partners, world.offset.norm(), springs);
}

JointHandle Scene::attach(std::span<const Index> patch, const ToolHandle& tool, const Attachment& springs) & {
  require_particles(patch, *model_);
  if (!tool.is_of(*this)) throw Error("attach: expected a tool of this scene, got a handle of another scene");
  const std::span<const Vec3> position = places(*model_, springs);
  const ToolPose& pose = tool.target_pose();
  const std::string& name = std::ranges::find(tools_, tool.id(), &SceneTool::id)->name;
  std::vector<Anchor> partners;
  for (const Index i : patch) {
    partners.push_back(at_tool(name, pose.orientation.conjugate() * (position[i] - pose.position)));
  }
  return attach(patch, partners, 0.0, springs);
}

JointHandle Scene::attach(std::span<const Index> patch, std::string_view group, const Attachment& springs) & {
  require_particles(patch, *model_);
  const std::span<const Vec3> position = places(*model_, springs);
  const Model partner = partner_body(*model_, patch, group, position);
  VecList points;
  for (const Index i : patch) points.push_back(position[i]);
  // By shape functions, beyond the cell too: then the spring has no rest length, and what it does turns with the body.
  const Skin skin = bound(partner, points, group);
  std::vector<Anchor> partners;
  for (std::size_t k = 0; k < patch.size(); ++k) {
    const std::span<const Index> particles = skin.particles(k);
    const std::span<const double> weights = skin.weights(k);
    partners.push_back(
        {.particles = {particles.begin(), particles.end()}, .weights = {weights.begin(), weights.end()}});
  }
  return attach(patch, partners, 0.0, springs);
}

}  // namespace phymul

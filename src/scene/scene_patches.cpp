// SPDX-License-Identifier: MIT
//
// Patches of the surface attached to the world, to a tool, or to another body.
#include <phymul/error.h>
#include <phymul/scene.h>
#include <phymul/skin.h>

#include <algorithm>

#include "base/files.h"
#include "model/group.h"
#include "model/require_indices.h"
#include "model/surface_facets.h"
#include "scene_items.h"

namespace phymul {
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

// SPDX-License-Identifier: MIT
//
// The tools of a scene: what is accepted, and the handles that move them.
#include <phymul/error.h>
#include <phymul/scene.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/decimal.h"
#include "model/cell_geometry.h"
#include "scene_items.h"
#include "tool_state.h"

namespace phymul {
namespace {

/// Share of a spacing below which a needle's nodes, one every `spread`, are means of the same particles: hundreds of
/// them, each pair of which a step couples, for curves that a few give.
constexpr double least_spread = 0.1;
constexpr double most_of_circle = 0.9;  // that an arc may be

std::string label(std::string_view tool) {
  return "tool \"" + std::string(tool) + "\": ";
}

void require_size(std::string_view tool, const char* what, double size) {
  if (size > 0.0 && std::isfinite(size)) return;
  throw Error(label(tool) + "expected a " + what + " above 0 m, got " + to_decimal(size));
}

void require_needle(std::string_view tool, const Needle& needle) {
  require_size(tool, "length", needle.length);
  require_size(tool, "radius", needle.radius);
  require_not_negative(label(tool), "puncture force (N)", needle.puncture);
  require_not_negative(label(tool), "cutting force (N)", needle.cutting);
  require_not_negative(label(tool), "static friction (N/m)", needle.static_friction);
  require_not_negative(label(tool), "kinetic friction (N/m)", needle.kinetic_friction);
  require_not_negative(label(tool), "spread (m)", needle.spread);
  require_not_negative(label(tool), "bending stiffness (N m^2)", needle.bending_stiffness);
  if (needle.bending_stiffness > 0.0 && needle.bending_stiffness < 1e-12) {
    throw Error(label(tool) + "expected a bending stiffness of 0 (stiff), or at least 1e-12 N m^2, got " +
                to_decimal(needle.bending_stiffness));
  }
  require_not_negative(label(tool), "radius of an arc (m)", needle.arc_radius);
  require_not_negative(label(tool), "force to come out (N)", needle.leaving);
  if (needle.arc_radius > 0.0 && needle.length > most_of_circle * 2.0 * std::numbers::pi * needle.arc_radius) {
    throw Error(label(tool) + "expected an arc of at most nine tenths of a circle, " +
                to_decimal(most_of_circle * 2.0 * std::numbers::pi * needle.arc_radius) + " m; got a length of " +
                to_decimal(needle.length) + " m");
  }
  if (needle.arc_radius > 0.0 && needle.bending_stiffness > 0.0) {
    throw Error(label(tool) + "expected a bending stiffness of 0 (stiff) for an arc, got " +
                to_decimal(needle.bending_stiffness) + " N m^2");
  }
  if (needle.cutting > needle.puncture) {
    throw Error(label(tool) + "expected a cutting force of at most the puncture force " + to_decimal(needle.puncture) +
                " N, got " + to_decimal(needle.cutting));
  }
  if (needle.kinetic_friction > needle.static_friction) {
    throw Error(label(tool) + "expected a kinetic friction of at most the static friction " +
                to_decimal(needle.static_friction) + " N/m, got " + to_decimal(needle.kinetic_friction));
  }
}

void require_spread(std::string_view tool, double spread, const Model& model) {
  if (spread == 0.0) return;
  const double spacing = needle_spacing(model);
  if (spread >= least_spread * spacing) return;
  throw Error(label(tool) +
              "expected a spread of 0 (34 radii, at least two spacings), or of at least a tenth of this body's spacing "
              "of " +
              to_decimal(spacing) + " m; got " + to_decimal(spread) +
              " m. From 2.7 spacings on, forces hardly depend on the mesh");
}

struct ShapeCheck {
  std::string_view tool;
  void operator()(const Sphere& sphere) const { require_size(tool, "radius", sphere.radius); }
  void operator()(const Capsule& capsule) const {
    require_size(tool, "radius", capsule.radius);
    require_not_negative(label(tool), "length", capsule.length);
  }
  void operator()(const HalfSpace&) const {}
  void operator()(const Box& box) const {
    for (int a = 0; a < 3; ++a) require_size(tool, "half size", box.half_size[a]);
  }
  void operator()(const std::shared_ptr<const DistanceGrid>& grid) const {
    if (!grid) throw Error(label(tool) + "expected a distance grid, got none; make_distance_grid makes one");
  }
  void operator()(const Needle& needle) const { require_needle(tool, needle); }
  void operator()(const Blade& blade) const {
    require_size(tool, "width", blade.width);
    require_not_negative(label(tool), "toughness (J/m^2)", blade.toughness);
    require_not_negative(label(tool), "height (m)", blade.height);
    require_not_negative(label(tool), "friction (N/m^2)", blade.friction);
    // An arc of more than half a circle meets itself along z.
    for (const auto& [what, got] : {std::pair{"belly", blade.belly}, {"bow", blade.bow}}) {
      if (std::abs(got) <= 0.5 * blade.width) continue;
      throw Error(label(tool) + "expected a " + what + " (m) of at most half the width, " +
                  to_decimal(0.5 * blade.width) + ", got " + to_decimal(got));
    }
  }
};

ToolPose accepted_pose(std::string_view tool, ToolPose pose) {
  const double turn = pose.orientation.norm();
  if (!pose.position.allFinite() || !pose.velocity.allFinite() || !pose.spin.allFinite() || !std::isfinite(turn)) {
    throw Error(label(tool) + "expected a pose of finite numbers");
  }
  if (!(turn > 0.0)) throw Error(label(tool) + "expected an orientation that is not zero; a unit quaternion turns");
  // Divided only where it must be: a pose that was one keeps its bits.
  if (std::abs(turn - 1.0) > 1e-15) pose.orientation.coeffs() /= turn;
  return pose;
}

}  // namespace

ToolHandle Scene::add_tool(std::string name, Tool tool) & {
  if (name.empty()) throw Error("add_tool: expected a name, got an empty one");
  const auto same = [&](const SceneTool& known) { return known.name == name; };
  if (std::ranges::any_of(tools_, same)) {
    throw Error(label(name) + "there is one of that name; remove_tool it first, or take another name");
  }
  std::visit(ShapeCheck{name}, tool.shape);
  require_not_negative(label(name), "friction", tool.friction);
  require_not_negative(label(name), "compliance (m/N)", tool.compliance);
  require_not_negative(label(name), "margin (m)", tool.margin);
  require_not_negative(label(name), "suction (N)", tool.suction);
  if (tool.suction > 0.0) require_size(name, "suction reach", tool.suction_reach);
  const bool pierces = std::holds_alternative<Needle>(tool.shape) || std::holds_alternative<Blade>(tool.shape);
  if (pierces && tool.suction > 0.0) {
    throw Error(label(name) + "expected a suction of 0 N for a needle or a blade, got " + to_decimal(tool.suction));
  }
  if (const auto* const needle = std::get_if<Needle>(&tool.shape)) {
    if (tool.contact != ToolContact::particles) {
      throw Error(label(name) + "expected ToolContact::particles, got surface: a needle finds the surface by itself");
    }
    if (model_->dimension == 2) {
      throw Error(label(name) + "expected a body in three dimensions: a needle spreads its forces around its shaft");
    }
    require_spread(name, needle->spread, *model_);
  }
  if (std::holds_alternative<Blade>(tool.shape)) {
    if (tool.contact != ToolContact::particles) {
      throw Error(label(name) + "expected ToolContact::particles, got surface: a blade finds the tissue by itself");
    }
    const auto is_cut = [&](const Cell& cell) { return cell.type == CellType::tetrahedron || is_wall(*model_, cell); };
    if (model_->dimension == 2 || model_->materials.empty() || std::ranges::none_of(model_->cells, is_cut)) {
      throw Error(ErrorCode::not_supported,
                  label(name) + "expected a body of tetrahedra or walls with a material for a blade");
    }
  }
  SceneTool added;
  added.pose = tool.pose = accepted_pose(name, tool.pose);
  added.id = next_tool_;
  added.name = std::move(name);
  added.tool = std::move(tool);
  tools_.push_back(std::move(added));
  ++next_tool_;
  ++version_;
  return {*this, tools_.back().id};
}

ToolHandle Scene::add_tool(Tool tool) & {
  return add_tool(default_name("tool", next_tool_, tools_), std::move(tool));
}

ToolHandle Scene::add_tool(ToolShape shape) & {
  Tool tool{.shape = std::move(shape)};
  return add_tool(std::move(tool));
}

Scene& Scene::remove_tool(std::string_view name) {
  const std::uint64_t id = tool(name).id_;
  for (const SceneJoint& known : joints_) {
    for (const JointSpring& spring : known.joint.springs) {
      if (spring.a.tool != name && spring.b.tool != name) continue;
      throw Error(label(name) + "the joint \"" + known.name + "\" has an anchor at it; remove_joint that one first");
    }
  }
  for (const SceneThread& known : threads_) {
    for (const ThreadEnd& end : known.control.ends) {
      if (end.hold != TipHold::anchored || end.anchor.tool != name) continue;
      throw Error(label(name) + "the thread \"" + known.name +
                  "\" is joined to it; pull or join its tip elsewhere first");
    }
  }
  std::erase_if(tools_, [&](const SceneTool& known) { return known.id == id; });
  ++version_;
  return *this;
}

ToolHandle Scene::tool(std::string_view name) & {
  return {*this, item_named(tools_, "tool", name).id};
}

SceneTool& ToolHandle::own() const {
  return item_with(scene_->tools_, "tool", id_);
}

void ToolHandle::move_to(const ToolPose& pose) const {
  SceneTool& tool = own();
  tool.pose = accepted_pose(tool.name, pose);
  ++tool.moves;
}

void ToolHandle::teleport(const ToolPose& pose) const {
  SceneTool& tool = own();
  tool.pose = accepted_pose(tool.name, pose);
  ++tool.moves;
  ++tool.places;
}

const ToolPose& ToolHandle::target_pose() const {
  return own().pose;
}

void ToolHandle::grasp(double distance) const {
  SceneTool& tool = own();
  require_not_negative(label(tool.name), "distance to grasp within (m)", distance);
  if (std::holds_alternative<Needle>(tool.tool.shape)) throw Error(label(tool.name) + "a needle cannot grasp");
  if (std::holds_alternative<Blade>(tool.tool.shape)) throw Error(label(tool.name) + "a blade cannot grasp");
  tool.grasping = true;
  tool.grasp_distance = distance;
  ++tool.grasps;
}

void ToolHandle::release() const {
  SceneTool& tool = own();
  tool.grasping = false;
  tool.released = ++tool.grasps;
}

}  // namespace phymul

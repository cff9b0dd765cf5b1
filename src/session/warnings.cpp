// SPDX-License-Identifier: MIT
#include "warnings.h"

#include <phymul/bodies.h>
#include <phymul/surface.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/decimal.h"
#include "base/place_text.h"
#include "interaction/closest_point.h"
#include "interaction/moved_tool.h"
#include "interaction/tool_shape.h"
#include "model/cell_cutter.h"
#include "model/cell_geometry.h"
#include "model/outer_faces.h"
#include "scene/loose_parts.h"

namespace phymul {
namespace {

struct Range {
  double least, greatest;
  bool has(double value) const { return value >= least && value <= greatest; }
};

// Beyond these another unit is likelier than such a body.
constexpr Range sizes{1e-3, 5.0};            // m, from a gland to a person
constexpr Range moduli{50.0, 1e12};          // Pa, from mucus to bone and steel
constexpr Range densities{50.0, 25e3};       // kg/m^3, from lung filled with air to metal
constexpr Range accelerations{0.0, 1000.0};  // m/s^2

void look_at_units(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  const double size = body_size(model);
  if (size > 0.0 && !sizes.has(size)) {
    found.emplace_back("the body is " + to_decimal(size) + " m large: expected lengths in m; were they in " +
                       (size > sizes.greatest ? "mm?" : "km, or is a factor of 0.001 in them twice?"));
  }
  for (const Material& material : model.materials) {
    if (!moduli.has(material.young)) {
      found.emplace_back("Young's modulus is " + to_decimal(material.young) + " Pa: expected Pa; was it in " +
                         (material.young < moduli.least ? "kPa or MPa?" : "mPa?"));
    }
    if (!densities.has(material.density)) {
      found.emplace_back("the density is " + to_decimal(material.density) + " kg/m^3: expected kg/m^3; was it in " +
                         (material.density < densities.least ? "g/cm^3 (water: 1)?" : "g/m^3?"));
    }
  }
  if (!accelerations.has(scene.gravity().norm())) {
    found.emplace_back("gravity is " + to_decimal(scene.gravity().norm()) +
                       " m/s^2: expected m/s^2 (on Earth 9.81); was it in mm/s^2?");
  }
}

std::string place_of(const ConnectedBody& part, const Model& model) {
  const Vec3& x = model.rest[part.particles.front()];
  std::string text = part.name.empty() ? "a part of " : "\"" + part.name + "\", ";
  text += std::to_string(part.particles.size()) + (part.particles.size() == 1 ? " particle" : " particles");
  return text + " at " + place_text(x);
}

void look_for_what_is_loose(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  if (may_hold_any(scene)) return;
  const std::vector<char> is_held = held_particles(scene);
  const bool any_held = std::ranges::find(is_held, 1) != is_held.end();
  if (!any_held) {
    if (first_loose(scene) >= 0)
      found.emplace_back("nothing holds the body: it moves away; Scene::fix() holds a group of particles");
    return;
  }
  const std::vector<ConnectedBody> loose = loose_parts(scene, is_held);
  if (loose.empty()) return;
  found.emplace_back(place_of(loose.front(), model) +
                     (loose.size() == 1 ? " is" : " and " + std::to_string(loose.size() - 1) + " more are") +
                     " joined to nothing that is held; hold " + (loose.size() == 1 ? "it" : "them") +
                     " too, join the meshes, or use Scene::attach() or Scene::contacts({})");
}

void look_at_joints(const Scene& scene, std::vector<std::string>& found) {
  for (const SceneJoint& joint : scene.joints()) {
    if (joint.joint.stiffness > 0.0 || joint.joint.damping > 0.0) continue;
    found.emplace_back("joint \"" + joint.name + "\" has neither stiffness nor damping: it holds nothing");
  }
}

/// Whether the surface at rest encloses the place: by the solid angle of its triangles (Van Oosterom and Strackee,
/// IEEE Trans. Biomed. Eng. 1983, equation 8), 4 pi inside and 0 outside.
bool encloses(const Model& model, std::span<const std::array<Index, 3>> triangles, const Vec3& place) {
  double angle = 0.0;
  for (const auto& [i, j, k] : triangles) {
    const Vec3 a = model.rest[i] - place, b = model.rest[j] - place, c = model.rest[k] - place;
    const double x = a.norm(), y = b.norm(), z = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + a.dot(c) * y + b.dot(c) * x);
  }
  return std::abs(angle) > 2.0 * std::numbers::pi;
}

/// m: of the points on a tool's axis the largest distance from the surface at rest among those that it encloses; 0:
/// none.
double depth_inside(const Model& model, std::span<const std::array<Index, 3>> triangles, const SceneTool& tool) {
  const ToolPose& pose = first_pose(tool);
  std::vector<Vec3> axis{pose.position};
  if (const auto* capsule = std::get_if<Capsule>(&tool.tool.shape)) {
    const Vec3 along = pose.orientation.normalized() * Vec3(0, 0, capsule->length);
    axis.insert(axis.end(), {pose.position + 0.5 * along, pose.position + along});
  }
  double deepest = 0.0;
  for (const Vec3& place : axis) {
    if (!encloses(model, triangles, place)) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [i, j, k] : triangles) {
      const Vec3 share = closest_point(place, model.rest[i], model.rest[j], model.rest[k]);
      const Vec3 at = share[0] * model.rest[i] + share[1] * model.rest[j] + share[2] * model.rest[k];
      nearest = std::min(nearest, (at - place).norm());
    }
    deepest = std::max(deepest, nearest);
  }
  return deepest;
}

/// m: what of a shape tells its unit; 0: nothing does.
double thickness_of(const ToolShape& shape) {
  if (const auto* needle = std::get_if<Needle>(&shape)) return 2.0 * needle->radius;
  if (const auto* blade = std::get_if<Blade>(&shape)) return blade->width;
  return 2.0 * least_radius(shape).value_or(0.0);
}

void look_at_tools(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  constexpr double many = 5.0;  // bodies; a floor made of a box is thinner
  constexpr double rounding = 1e-9;
  // What walls enclose is a lumen, no tissue.
  const bool hollow = !is_made_of_cells(model) &&
                      std::ranges::any_of(model.cells, [&](const Cell& cell) { return is_of_wall(model, cell); });
  const std::vector<std::array<Index, 3>> triangles =
      scene.tools().empty() || hollow ? std::vector<std::array<Index, 3>>{} : surface_triangles(model);
  const double size = body_size(model);
  for (const SceneTool& tool : scene.tools()) {
    const double thickness = thickness_of(tool.tool.shape);
    const bool pushes = least_radius(tool.tool.shape).value_or(0.0) > 0.0;
    if (size > 0.0 && thickness > many * size) {
      found.emplace_back("the tool \"" + tool.name + "\" is " + to_decimal(thickness) + " m thick, the body " +
                         to_decimal(size) + " m large: expected lengths in m; was it in mm?");
    } else if (const double depth = pushes ? depth_inside(model, triangles, tool) : 0.0; depth > rounding * size) {
      found.emplace_back(
          "the middle of the tool \"" + tool.name + "\" begins inside the body, " + length_text(depth) +
          " m deep, where a tool pushes to either side and forces mislead; begin outside and move it in");
    }
  }
}

void look_at_threads(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  const double size = body_size(model);
  for (const SceneThread& thread : scene.threads()) {
    if (size == 0.0 || 2.0 * thread.thread.radius <= size) continue;
    found.emplace_back("the thread \"" + thread.name + "\" is " + to_decimal(2.0 * thread.thread.radius) +
                       " m thick, the body " + to_decimal(size) + " m large: expected lengths in m; was it in mm?");
  }
}

void look_for_what_cannot_cut(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  const auto is_blade = [](const SceneTool& tool) { return std::holds_alternative<Blade>(tool.tool.shape); };
  const auto blade = std::ranges::find_if(scene.tools(), is_blade);
  if ((blade == scene.tools().end() && scene.tearing().empty()) || !spare_particles_of(model).empty()) return;
  found.emplace_back(
      (blade == scene.tools().end() ? "nothing can tear" : "the tool \"" + blade->name + "\" cannot cut") +
      ": the body has no spare particles, which become the copies of particles at a cut; "
      "with_spare_particles() gives it some");
}

/// Even where nothing spreads the particles. How thick a DistanceGrid is, is not known.
void look_for_thin_tools(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  const auto meets_particles = [](const SceneTool& tool) {
    return tool.tool.contact == ToolContact::particles &&
           !std::holds_alternative<std::shared_ptr<const DistanceGrid>>(tool.tool.shape);
  };
  if (std::ranges::none_of(scene.tools(), meets_particles) || surface_triangles(model).empty()) return;
  for (const SceneTool& tool : scene.tools()) {
    if (!meets_particles(tool)) continue;
    const double least = least_margin(model, tool.tool.shape, 1.0);
    if (!(least > tool.tool.margin)) continue;
    found.emplace_back("the tool \"" + tool.name +
                       "\" can pass between the particles of the surface without a force; take "
                       "ToolContact::surface, a finer body, or a margin of " +
                       to_decimal(least_margin(model, tool.tool.shape)) + " m, which makes it thicker");
  }
}

}  // namespace

void look_for_tools_beyond_cuts(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  const auto meets_particles = [](const SceneTool& tool) {
    return tool.tool.contact == ToolContact::particles && !std::holds_alternative<Needle>(tool.tool.shape) &&
           !std::holds_alternative<Blade>(tool.tool.shape);
  };
  const auto tool = std::ranges::find_if(scene.tools(), meets_particles);
  if (tool == scene.tools().end() || !has_cuts(model)) return;
  std::string text =
      "the tool \"" + tool->name +
      "\" touches particles, of which some at a cut are copies that stand beyond the cut, where no tissue "
      "is; take ToolContact::surface";
  if (std::ranges::find(found, text) == found.end()) found.push_back(std::move(text));
}

std::vector<std::string> warnings_of(const Model& model, const Scene& scene, bool takes_material) {
  std::vector<std::string> found;
  if (model.materials.empty() && takes_material) {
    found.emplace_back(
        "the body has no material: Model::stiffness, N/m, pulls its particles, and means something else on every mesh; "
        "give SimulationOptions::material for a Young's modulus");
  }
  look_at_units(model, scene, found);
  look_at_joints(scene, found);
  look_at_tools(model, scene, found);
  look_at_threads(model, scene, found);
  look_for_what_cannot_cut(model, scene, found);
  look_for_tools_beyond_cuts(model, scene, found);
  look_for_overlaps(model, scene, found);
  look_for_thin_tools(model, scene, found);
  look_for_what_is_loose(model, scene, found);
  return found;
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>
#include <phymul/error.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "base/decimal.h"
#include "interaction/contact_surface.h"
#include "interaction/moved_tool.h"
#include "interaction/tool_shape.h"
#include "model/cell_cutter.h"
#include "model/cell_geometry.h"
#include "model/closed_surface.h"
#include "model/outer_faces.h"
#include "scene/loose_parts.h"
#include "simulation_parts.h"

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
  constexpr double many = 5.0;          // bodies; a floor made of a box is thinner
  constexpr double least_depth = 1e-9;  // of the body: less is rounding
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
    } else if (const double depth = pushes ? depth_inside(model, triangles, tool) : 0.0; depth > least_depth * size) {
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

/// Of an edge: less is rounding.
constexpr double least_overlap = 1e-6;
/// Of the longest edge of both bodies. Of 300 pairs of blocks at random, of hexahedra or tetrahedra of 10 kPa, the 96
/// that overlapped less came apart, no particle faster than 0.33 m/s. At 0.3 to 0.4 particles reached 0.8 m/s, from 0.4
/// on some pairs interlocked: particles are then nearer to another side than to the one that they are to leave through.
constexpr double largest_overlap = 0.25;

/// Of one body.
struct BodySurface {
  std::vector<Index> particles;     // of the contact surface
  std::vector<Triangle> triangles;  // likewise
  bool encloses = true;             // the triangles the body
  double edge = 0.0;                // m, the longest of a triangle
  Eigen::AlignedBox3d box;
};

struct Overlap {
  std::size_t outer = 0, inner = 0;  // bodies
  double depth = 0.0;                // m
  Vec3 place{0, 0, 0};
  double edge = 0.0;   // m, the longest of both
  double least = 0.0;  // m, depth of the particle that is least deep; 0: it is outside
  bool is_enclosed() const { return least > ContactSurface::depth_factor * edge; }  // contacts do not act
  bool interlocks() const { return depth > largest_overlap * edge && !is_enclosed(); }
};

std::vector<BodySurface> surfaces_of_bodies(const ContactSurface& surface, std::size_t count) {
  std::vector<BodySurface> bodies(count);
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    BodySurface& own = bodies[surface.particles[k].body];
    own.particles.push_back(static_cast<Index>(k));
    own.box.extend(surface.rest[k]);
  }
  for (const ContactSurface::Triangle& triangle : surface.triangles) {
    BodySurface& own = bodies[triangle.body];
    own.edge = std::max(own.edge, triangle.edge);
    if (!triangle.has_inside) continue;
    own.triangles.push_back(triangle.corner);
  }
  for (BodySurface& own : bodies) {
    own.encloses =
        !own.triangles.empty() && flat_triangle(surface.rest, own.triangles) < 0 && open_edge(own.triangles)[0] < 0;
  }
  return bodies;
}

/// Of the particles of one body in the other, the deepest; depth 0 if there is none.
Overlap deepest(const ContactSurface& surface, const std::vector<BodySurface>& bodies, std::size_t outer,
                std::size_t inner) {
  const BodySurface& around = bodies[outer];
  Overlap found{.outer = outer, .inner = inner, .edge = std::max(around.edge, bodies[inner].edge)};
  if (!around.encloses || !around.box.intersects(bodies[inner].box)) return found;
  found.least = std::numeric_limits<double>::infinity();
  std::optional<ClosestTriangle> closest;
  for (const Index k : bodies[inner].particles) {
    const Vec3& place = surface.rest[k];
    double depth = 0.0;
    if (around.box.contains(place)) {
      if (!closest) closest.emplace(surface.rest, around.triangles);
      depth = -closest->signed_distance(place);
    }
    found.least = std::min(found.least, depth);
    if (depth <= std::max(found.depth, least_overlap * around.edge)) continue;
    found.depth = depth;
    found.place = place;
  }
  return found;
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

void look_for_overlaps(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  const std::vector<ConnectedBody> named = scene.contacts() ? connected_bodies(model) : std::vector<ConnectedBody>{};
  if (named.size() < 2) return;
  const ContactSurface surface = make_contact_surface(model);
  const std::vector<BodySurface> bodies = surfaces_of_bodies(surface, named.size());
  Overlap worst;
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (a != b)
        worst = std::max(worst, deepest(surface, bodies, a, b), [](const Overlap& one, const Overlap& other) {
          return std::pair(one.interlocks(), one.depth) < std::pair(other.interlocks(), other.depth);
        });
    }
  }
  if (worst.depth == 0.0) return;
  const auto name_of = [&](std::size_t body) {
    return named[body].name.empty() ? "the body of particle " + std::to_string(named[body].particles.front())
                                    : '"' + named[body].name + '"';
  };
  const std::string depth = name_of(worst.inner) + " begins " + length_text(worst.depth) + " m deep inside " +
                            name_of(worst.outer) + ", at " + place_text(worst.place);
  if (worst.interlocks()) {
    throw Error("expected bodies with contacts that overlap by at most " + length_text(largest_overlap * worst.edge) +
                " m, a quarter of the longest edge, got more: " + depth +
                "; deeper, contacts do not know the way out; move them apart, or switch Scene::contacts() off");
  }
  found.push_back(depth + (worst.is_enclosed() ? ": contacts do not act between them"
                                               : ": contacts part them little by little; move them apart"));
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "base/place_text.h"
#include "interaction/contact_surface.h"
#include "model/closest_triangle.h"
#include "warnings.h"

namespace phymul {
namespace {

/// Of an edge: less is rounding.
constexpr double least_overlap = 1e-6;

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
    own.triangles.push_back(triangle.corner);
    own.edge = std::max(own.edge, triangle.edge);
    const auto& [a, b, c] = triangle.corner;
    const double area = (surface.rest[b] - surface.rest[a]).cross(surface.rest[c] - surface.rest[a]).norm();
    own.encloses = own.encloses && triangle.has_inside && area > 0.0;
  }
  for (BodySurface& own : bodies) {
    own.encloses = own.encloses && !own.triangles.empty() && open_edge(own.triangles)[0] < 0;
  }
  return bodies;
}

/// Of the particles of one body in the other, the deepest; depth 0 if there is none.
Overlap deepest(const ContactSurface& surface, const std::vector<BodySurface>& bodies, std::size_t outer,
                std::size_t inner) {
  const BodySurface& around = bodies[outer];
  Overlap found{outer, inner};
  if (!around.encloses || !around.box.intersects(bodies[inner].box)) return found;
  std::optional<ClosestTriangle> closest;
  for (const Index k : bodies[inner].particles) {
    const Vec3& place = surface.rest[k];
    if (!around.box.contains(place)) continue;
    if (!closest) closest.emplace(surface.rest, around.triangles);
    const double depth = -closest->signed_distance(place);
    if (depth > std::max(found.depth, least_overlap * around.edge)) found = {outer, inner, depth, place};
  }
  return found;
}

}  // namespace

void look_for_overlaps(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  const std::vector<ConnectedBody> named = scene.contacts() ? connected_bodies(model) : std::vector<ConnectedBody>{};
  if (named.size() < 2) return;
  const ContactSurface surface = make_contact_surface(model);
  const std::vector<BodySurface> bodies = surfaces_of_bodies(surface, named.size());
  Overlap worst;
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (a != b)
        worst = std::max(worst, deepest(surface, bodies, a, b),
                         [](const Overlap& one, const Overlap& other) { return one.depth < other.depth; });
    }
  }
  if (worst.depth == 0.0) return;
  const auto name_of = [&](std::size_t body) {
    return named[body].name.empty() ? "the body of particle " + std::to_string(named[body].particles.front())
                                    : '"' + named[body].name + '"';
  };
  const double edge = bodies[worst.outer].edge;
  found.push_back(
      name_of(worst.inner) + " begins " + length_text(worst.depth) + " m deep inside " + name_of(worst.outer) +
      ", at " + place_text(worst.place) +
      (worst.depth > ContactSurface::depth_factor * edge
           ? ": deeper than a cell (" + length_text(edge) + " m), where contacts do not push, so that they interlock"
           : ": contacts part them little by little") +
      "; move them apart");
}

}  // namespace phymul

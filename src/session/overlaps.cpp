// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "base/place_text.h"
#include "interaction/contact_surface.h"
#include "model/closest_triangle.h"
#include "warnings.h"

namespace phymul {
namespace {

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

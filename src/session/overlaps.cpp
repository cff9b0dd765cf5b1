// SPDX-License-Identifier: MIT
#include "overlaps.h"

#include <phymul/bodies.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "base/place_text.h"
#include "interaction/contact_surface.h"
#include "model/closest_triangle.h"

namespace phymul {
namespace {

/// Of an edge: less is rounding.
constexpr double least_overlap = 1e-6;

/// Of one body.
struct BodySurface {
  std::vector<Index> particles;     // of the contact surface
  std::vector<Triangle> triangles;  // likewise; none unless they enclose the body
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
  std::vector<char> is_flawed(count, 0);
  for (const ContactSurface::Triangle& triangle : surface.triangles) {
    BodySurface& own = bodies[triangle.body];
    own.triangles.push_back(triangle.corner);
    own.edge = std::max(own.edge, triangle.edge);
    const auto& [a, b, c] = triangle.corner;
    const double area = (surface.rest[b] - surface.rest[a]).cross(surface.rest[c] - surface.rest[a]).norm();
    is_flawed[triangle.body] |= !triangle.has_inside || !(area > 0.0);
  }
  for (std::size_t body = 0; body < count; ++body) {
    if (is_flawed[body] || open_edge(bodies[body].triangles)[0] >= 0) bodies[body].triangles.clear();
  }
  return bodies;
}

/// Of the particles of one body in the other, the deepest.
std::optional<Overlap> deepest(const ContactSurface& surface, const std::vector<BodySurface>& bodies, std::size_t outer,
                               std::size_t inner) {
  const BodySurface& around = bodies[outer];
  if (around.triangles.empty() || !around.box.intersects(bodies[inner].box)) return {};
  std::optional<ClosestTriangle> closest;
  Overlap found{outer, inner};
  for (const Index k : bodies[inner].particles) {
    const Vec3& place = surface.rest[k];
    if (!around.box.contains(place)) continue;
    if (!closest) closest.emplace(surface.rest, around.triangles);
    const double depth = -closest->signed_distance(place);
    if (depth > found.depth) found = {outer, inner, depth, place};
  }
  return found.depth > least_overlap * around.edge ? std::optional(found) : std::nullopt;
}

}  // namespace

void look_for_overlaps(const Model& model, const Scene& scene, std::vector<std::string>& found) {
  if (!scene.contacts()) return;
  const std::vector<ConnectedBody> named = connected_bodies(model);
  if (named.size() < 2) return;
  const ContactSurface surface = make_contact_surface(model);
  const std::vector<BodySurface> bodies = surfaces_of_bodies(surface, named.size());
  Overlap worst;
  int pairs = 0;
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    for (std::size_t b = a + 1; b < bodies.size(); ++b) {
      const auto one = deepest(surface, bodies, a, b), other = deepest(surface, bodies, b, a);
      if (one || other) ++pairs;
      for (const auto& each : {one, other}) {
        if (each && each->depth > worst.depth) worst = *each;
      }
    }
  }
  if (pairs == 0) return;
  const auto name_of = [&](std::size_t body) {
    return named[body].name.empty() ? "the body of particle " + std::to_string(named[body].particles.front())
                                    : '"' + named[body].name + '"';
  };
  const double edge = bodies[worst.outer].edge;
  std::string text = name_of(worst.inner) + " begins " + length_text(worst.depth) + " m deep inside " +
                     name_of(worst.outer) + ", at " + place_text(worst.place);
  text += worst.depth > ContactSurface::depth_factor * edge
              ? ": deeper than a cell (" + length_text(edge) + " m), where contacts do not push, so that they interlock"
              : ": contacts part them little by little";
  text += "; move them apart";
  if (pairs > 1) text += "; " + std::to_string(pairs - 1) + " more pairs of bodies overlap less";
  found.push_back(text);
}

}  // namespace phymul

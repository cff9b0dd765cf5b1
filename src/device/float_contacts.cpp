// SPDX-License-Identifier: MIT
#include "float_contacts.h"

#include <phymul/error.h>

#include <map>
#include <string>

namespace phymul {
namespace {

/// Edges from the middle: cells are at least one wide, and floats know places that far away to 1/128 of it, which the
/// cells' slack in contact_grid_kernel.glsl is for, with as much again for motion.
constexpr double furthest = 65536.0;

}  // namespace

FloatContacts::FloatContacts(const Scene& scene) : options(*scene.contacts()) {
  const ContactSurface surface = make_contact_surface(scene.model());
  longest_edge = surface.longest_edge;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& X : scene.model().rest) middle += X / static_cast<double>(scene.model().rest.size());
  // Bodies that have triangles, in their order: each particle may meet each of these, and no other.
  std::map<Index, Index> solid;
  for (const ContactSurface::Triangle& own : surface.triangles) solid.emplace(own.body, 0);
  for (auto& [body, number] : solid) number = bodies++;
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    const ContactSurface::Particle& own = surface.particles[k];
    const auto number = solid.find(own.body);
    particle.push_back(
        {own.row, number == solid.end() ? -1 : number->second, bits_of(static_cast<float>(own.edge)), 0});
    const Vec3 X = surface.rest[k] - middle;
    if (X.cwiseAbs().maxCoeff() > furthest * longest_edge) {
      throw Error(ErrorCode::not_supported,
                  "contacts in single precision: expected surfaces within 65536 of their longest edges (" +
                      std::to_string(longest_edge) + " m) of the middle of all particles, got particle " +
                      std::to_string(own.row) + " at " + std::to_string(X.norm()) +
                      " m; bring the bodies nearer to each other, or use the backend \"cpu\"");
    }
    for (const Float4& half : halves(X)) rest.push_back(half);
  }
  for (const ContactSurface::Triangle& own : surface.triangles) {
    triangle.push_back(
        {own.corner[0], own.corner[1], own.corner[2], 2 * solid.at(own.body) + (own.has_inside ? 1 : 0)});
    triangle_law.push_back({static_cast<float>(own.edge), 0.0f, 0.0f, 0.0f});
  }
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/topology_textures.h>

#include <span>

namespace phymul {

/// Calls visit(e, area) for the links and surface links of domain d.
template <class Visit>
void for_each_area(const TopologyTextures& t, Index d, const Visit& visit) {
  for (const LinkTexel& link : t.links_of(d)) visit(d + link.offset, link.area);
  for (const SurfaceLinkTexel& link : t.surface_links_of(d)) visit(d + link.offset, link.area);
}

/// H_d = F_d - I, the mean displacement gradient of domain d. `displacement(e)`, m: of the particle of domain e.
template <class Displacement>
Mat3 mean_gradient(const TopologyTextures& t, Index d, const Displacement& displacement) {
  const Vec3 own = displacement(d);
  Mat3 H = Mat3::Zero();
  for_each_area(t, d, [&](Index e, const Vec3& area) { H += (displacement(e) - own) * area.transpose(); });
  return t.domains[d].inverse_volume * H;
}

/// From positions `x` [N], m, the displacements that mean_gradient() takes.
inline auto displacements_at(const TopologyTextures& t, std::span<const Vec3> x) {
  return [&t, x](Index e) {
    const Index i = t.domains[e].particle;
    return Vec3(x[i] - t.rest[i]);
  };
}

}  // namespace phymul

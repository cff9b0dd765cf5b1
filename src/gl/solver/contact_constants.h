// SPDX-License-Identifier: MIT
//
// The uniforms of contact_law.glsl, contact_nearest.glsl and contact_range.glsl.
#pragma once

#include "device/float_contacts.h"

namespace phymul::gl {

struct ContactConstants {
  explicit ContactConstants(const FloatContacts& contacts)
      : options(contacts.options),
        particles(static_cast<int>(contacts.particle.size())),
        bodies(contacts.bodies),
        longest_edge(contacts.longest_edge),
        largest_skins(contacts.largest_skins()) {}

  /// Calls set(name, value), of an int or a float, for each.
  template <class Set>
  void for_each(Set&& set) const {
    const auto real = [&](const char* name, double value) { set(name, static_cast<float>(value)); };
    set("surface_count", particles);
    set("body_count", bodies);
    set("rounds", options.rounds);
    set("touches_itself", options.self ? 1 : 0);
    real("friction", options.friction);
    real("skin", options.margin);
    real("facing_share", ContactSurface::facing_share);
    real("usual_skin", ContactSurface::usual_skin);
    real("skin_factor", ContactSurface::skin_factor);
    real("depth_factor", ContactSurface::depth_factor);
    real("parted_share", ContactSurface::parted_share);
    real("largest_parting", ContactSurface::largest_parting);
    real("longest_edge", longest_edge);
    real("largest_skins", largest_skins);
  }

  ContactOptions options;
  int particles, bodies;               ///< of the surfaces; with triangles
  double longest_edge, largest_skins;  // m
};

}  // namespace phymul::gl

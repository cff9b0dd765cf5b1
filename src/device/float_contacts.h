// SPDX-License-Identifier: MIT
//
// FloatContacts: what of a scene can touch (Scene::contacts), packed for backends that compute in float. Places at rest
// stand as FloatTools has them: from the middle of the rest shape, as two floats whose sum they are.
#pragma once

#include <phymul/scene.h>

#include <vector>

#include "interaction/contact_surface.h"
#include "table_rows.h"

namespace phymul {

struct FloatContacts {
  /// Of a scene with contacts. Throws Error where bodies are too far apart for floats to tell cells of a grid apart.
  explicit FloatContacts(const Scene& scene);

  ContactOptions options;
  Index bodies = 0;           ///< that have triangles
  double longest_edge = 0.0;  ///< m

  // Rows as glsl/contact/contact_tables.glsl has them.
  std::vector<Int4> particle;        ///< row of the model, body or -1, bits of the mean edge around it (m)
  std::vector<Float4> rest;          ///< [2 particles] m
  std::vector<Int4> triangle;        ///< corners: rows of `particle`; 2 * body + 1 where it has an inside
  std::vector<Float4> triangle_law;  ///< longest edge, m

  bool empty() const { return triangle.empty(); }  ///< nothing can touch anything
  /// Of two that meet, together, m.
  double largest_skins() const {
    return 2.0 * (options.margin > 0.0 ? options.margin : ContactSurface::usual_skin * longest_edge);
  }
};

}  // namespace phymul

// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/bodies.h>

#include <vector>

namespace phymul {

/// What connected_bodies() returns, without its lists: of each particle the row of its body, -1 where it was removed.
struct BodyRows {
  std::vector<Index> of;  ///< [N]
  Index count = 0;
};
BodyRows body_rows(const Model& model);

}  // namespace phymul

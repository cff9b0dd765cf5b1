// SPDX-License-Identifier: MIT
//
// VisibleSkin: what a display shows in place of a body.
#pragma once

#include <phymul/skin.h>

namespace phymul {

struct VisibleSkin {
  Skin skin;
  Model surface;  ///< the skin's points at rest as particles, its triangles as cells
};

}  // namespace phymul

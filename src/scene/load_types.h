// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/load.h>

namespace phymul {

/// Whether a load of this type imposes positions; others apply forces.
inline bool imposes(LoadType type) {
  return type == LoadType::translation || type == LoadType::rotation;
}

}  // namespace phymul

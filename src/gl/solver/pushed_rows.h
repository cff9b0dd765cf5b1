// SPDX-License-Identifier: MIT
//
// Where a step is open between its forces and its motion, among the rows of the loads: glsl/tools/pushed_tables.glsl.
#pragma once

#include <cstdint>

#include "gl/objects/kernel.h"

namespace phymul::gl {

class PushedRows {
 public:
  /// Takes rows from `first` on.
  PushedRows(std::int64_t first, std::int64_t places) : first_(first), places_(places) {}

  std::int64_t end() const { return first_ + 3 * places_; }
  void place(Kernel& kernel) const {
    kernel.set("place_count", static_cast<int>(places_));
    kernel.set("pushed_force_place", static_cast<int>(first_));
    kernel.set("free_velocity_place", static_cast<int>(first_ + places_));
    kernel.set("pushed_shift_place", static_cast<int>(first_ + 2 * places_));
  }

 private:
  std::int64_t first_, places_;
};

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
//
// Where a step is open between its forces and its motion, in textures: glsl/tools/pushed_tables.glsl. What pushes
// particles reads one set and writes the other.
#pragma once

#include <array>

#include "gl/objects/pass.h"

namespace phymul::gl {

class FragmentPushed {
 public:
  explicit FragmentPushed(int particles);

  /// The step opens: free_pass.glsl, over forces, velocities and shifts.
  void begin(Pass& free);
  /// A pass over forces and velocities, which reads the newest of all.
  void push(Pass& pass);
  /// Likewise one that shifts as well; once a step.
  void press(Pass& pass);
  /// The newest, for a pass that only reads them.
  void bind(Pass& pass) const;

 private:
  void draw(Pass& pass, const Framebuffer& target) const;

  int particles_;
  std::array<Texture, 2> force_, velocity_, shift_;  // shift: as the step opens, as it was pressed
  Framebuffer free_target_;
  std::array<Framebuffer, 2> pushed_, pressed_;
  std::size_t turn_ = 0, shifted_ = 0;  // of the newest
};

}  // namespace phymul::gl

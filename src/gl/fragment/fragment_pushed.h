// SPDX-License-Identifier: MIT
//
// Where a step is open between its forces and its motion, in textures: glsl/tools/pushed_tables.glsl.
#pragma once

#include "gl/objects/pass.h"

namespace phymul::gl {

class FragmentPushed {
 public:
  explicit FragmentPushed(int particles);

  /// The step opens: free_pass.glsl, over forces, velocities and shifts.
  void begin(Pass& free) const;
  void bind(Pass& pass) const;

 private:
  int particles_;
  Texture force_, velocity_, shift_;
  Framebuffer target_;
};

}  // namespace phymul::gl

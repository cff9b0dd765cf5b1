// SPDX-License-Identifier: MIT
//
// Where a step is open between its forces and its motion, in textures: glsl/pushed_tables.glsl.
#pragma once

#include "gl/pass.h"

namespace phymul::gl {

struct FragmentPushed {
  explicit FragmentPushed(std::int64_t particles)
      : force(Texture::target(particles, TexelFormat::rgba32f, "forces with what pushes")),
        velocity(Texture::target(particles, TexelFormat::rgba32f, "free velocities")),
        shift(Texture::target(particles, TexelFormat::rgba32f, "shifts")),
        target({{&force}, {&velocity}, {&shift}}) {}

  void bind(Pass& pass) const {
    pass.input("pushed_force", force);
    pass.input("free_velocity", velocity);
    pass.input("pushed_shift", shift);
  }

  Texture force, velocity, shift;
  Framebuffer target;
};

}  // namespace phymul::gl

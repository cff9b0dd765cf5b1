// SPDX-License-Identifier: MIT
#include "fragment_pushed.h"

namespace phymul::gl {

FragmentPushed::FragmentPushed(int particles)
    : particles_(particles),
      force_(Texture::target(particles, TexelFormat::rgba32f, "forces before a step's motion")),
      velocity_(Texture::target(particles, TexelFormat::rgba32f, "velocities before a step's motion")),
      shift_(Texture::target(particles, TexelFormat::rgba32f, "shifts before a step's motion")),
      target_({{&force_}, {&velocity_}, {&shift_}}) {}

void FragmentPushed::bind(Pass& pass) const {
  pass.input("pushed_force", force_);
  pass.input("free_velocity", velocity_);
  pass.input("pushed_shift", shift_);
}

void FragmentPushed::begin(Pass& free) const {
  free.set_rows(force_, particles_);
  free.draw(target_);
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#include "fragment_pushed.h"

namespace phymul::gl {

FragmentPushed::FragmentPushed(int particles) : particles_(particles) {
  for (std::size_t turn = 0; turn < 2; ++turn) {
    force_[turn] = Texture::target(particles, TexelFormat::rgba32f, "forces before a step's motion");
    velocity_[turn] = Texture::target(particles, TexelFormat::rgba32f, "velocities before a step's motion");
    shift_[turn] = Texture::target(particles, TexelFormat::rgba32f, "shifts before a step's motion");
  }
  free_target_ = Framebuffer({{&force_[0]}, {&velocity_[0]}, {&shift_[0]}});
  for (std::size_t turn = 0; turn < 2; ++turn) {
    pushed_[turn] = Framebuffer({{&force_[turn]}, {&velocity_[turn]}});
    pressed_[turn] = Framebuffer({{&force_[turn]}, {&velocity_[turn]}, {&shift_[1]}});
  }
}

void FragmentPushed::bind(Pass& pass) const {
  pass.input("pushed_force", force_[turn_]);
  pass.input("free_velocity", velocity_[turn_]);
  pass.input("pushed_shift", shift_[shifted_]);
}

void FragmentPushed::draw(Pass& pass, const Framebuffer& target) const {
  pass.set_rows(force_[0], particles_);
  pass.draw(target);
}

void FragmentPushed::begin(Pass& free) {
  turn_ = shifted_ = 0;
  draw(free, free_target_);
}

void FragmentPushed::push(Pass& pass) {
  bind(pass);
  turn_ = 1 - turn_;
  draw(pass, pushed_[turn_]);
}

void FragmentPushed::press(Pass& pass) {
  bind(pass);
  turn_ = 1 - turn_;
  shifted_ = 1;
  draw(pass, pressed_[turn_]);
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
//
// The passes of a step in a scene with tools that touch surfaces, between free_pass.glsl and the motion, tool by tool:
// of one that does, where its points are, how the particles are split among them, then rounds of two draws, and what
// they come to (surface_press.h); of another, one draw. Compiled where a scene has such tools.
#pragma once

#include <functional>

#include "fragment_surfaces.h"
#include "gl/solver/body_kind.h"

namespace phymul::gl {

class FragmentSurfacePasses {
 public:
  /// A pass of these files behind those of tools.
  using Compile = std::function<Pass(const ShaderFiles& files)>;

  FragmentSurfacePasses() = default;
  explicit FragmentSurfacePasses(const Compile& compiled);

  template <class Function>
  void for_each(Function&& function) {
    for (Pass* const pass : {&start_, &load_, &gather_, &press_, &push_, &end_, &particles_}) function(*pass);
  }

  void bind(const FragmentSurfaces& surfaces);
  void set_step(double dt);
  /// Of step `batch_step` from places `displacement`, opened in FragmentSurfaces::open_target(). What it comes to is in
  /// open() there.
  void act(FragmentSurfaces& surfaces, const Texture& displacement, int batch_step);

 private:
  void act_on_surfaces(FragmentSurfaces& surfaces, int tool, int batch_step);

  Pass start_, load_, gather_, press_, push_, end_;
  Pass particles_;  // of tools that touch these
};

}  // namespace phymul::gl

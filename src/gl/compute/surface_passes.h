// SPDX-License-Identifier: MIT
//
// The passes of a step for a tool that touches surfaces, between free_kernel.glsl and the motion: where its points are,
// how the particles are split among them, then rounds of two dispatches, and what they come to (surface_press.h).
// Compiled where a scene has such tools.
#pragma once

#include <functional>

#include "compute_surfaces.h"

namespace phymul::gl {

class SurfacePasses {
 public:
  /// A kernel of these files in front of surface_kernel.glsl, with one more macro.
  using Compile = std::function<Kernel(const ShaderFiles& files, const char* define)>;

  SurfacePasses() = default;
  explicit SurfacePasses(const Compile& compiled);

  template <class Function>
  void for_each(Function&& function) {
    for (Kernel* const kernel : {&start_, &load_, &gather_, &press_, &push_, &end_}) {
      if (*kernel) function(*kernel);
    }
  }

  struct Step {
    int number = 0, pair = 0;  // of the batch, from 1; of ComputeState
    bool measuring = false;
  };
  void act(const ComputeSurfaces& surfaces, int tool, Index particles, const Step& step);

 private:
  Kernel start_, load_, gather_, press_, push_, end_;
};

}  // namespace phymul::gl

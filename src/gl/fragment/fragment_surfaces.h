// SPDX-License-Identifier: MIT
//
// The points at which tools touch surfaces in textures, and what the passes of fragment_surface_passes.h write: of one
// tool at a time where its corners are and what they get, and of all where the step stands between its forces and its
// motion, and what each tool gave.
#pragma once

#include <array>
#include <vector>

#include "device/float_surfaces.h"
#include "fragment_state.h"

namespace phymul::gl {

class FragmentSurfaces : public SurfaceTools {
 public:
  FragmentSurfaces(const FloatSurfaces& surfaces, const FloatTools& tools);

  int patches() const { return patches_; }
  int particles() const { return particles_; }
  /// Tables, and what each of these passes finds always in the same place.
  void bind(Pass& pass) const;

  // What passes draw into, in their order.
  Framebuffer first_target, load_target, push_target;
  const Texture& first_end() const { return first_[0]; }
  const Texture& load() const { return load_; }
  const Texture& push() const { return push_; }

  void bind_corners(Pass& pass) const;
  /// The other one than bind_corners() binds; becomes that.
  const Framebuffer& next_corners();

  /// Where free_pass.glsl opens the step.
  const Framebuffer& open_target();
  const OpenStep& open() const { return open_[open_turn_]; }
  /// The other one than open(), which becomes that, with what this tool gave.
  const Framebuffer& next_open(int tool);
  void bind_given(Pass& pass) const { pass.input("given_by_tools", given_); }

 private:
  int patches_, particles_;
  NamedTables tables_;
  std::array<Texture, 2> first_;                  // end, way
  Texture load_, push_;                           // push: a layer for each corner
  std::array<std::array<Texture, 4>, 2> rounds_;  // [turn]: end, way, given, shift
  std::array<Framebuffer, 2> round_targets_;
  std::size_t round_turn_ = 0;                     // of the newest
  std::array<OpenStep, 2> open_;                   // [turn]
  Texture given_;                                  // a layer for each tool
  Framebuffer open_target_;                        // of turn 0
  std::array<std::vector<Framebuffer>, 2> acted_;  // [turn][tool]
  std::size_t open_turn_ = 0;                      // of the newest
};

}  // namespace phymul::gl

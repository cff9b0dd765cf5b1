// SPDX-License-Identifier: MIT
//
// The volumes that a scene keeps in textures, and what passes write of them: where particles would go by themselves and
// which way back, sums over facets level by level, and how far.
#pragma once

#include <array>
#include <vector>

#include "device/float_volumes.h"
#include "gl/objects/pass.h"

namespace phymul::gl {

class FragmentVolumes {
 public:
  explicit FragmentVolumes(const FloatVolumes& volumes);

  int count() const { return count_; }
  /// Tables and what never changes of the others, for any of the passes.
  void bind(Pass& pass) const;

  /// Where step_pass.glsl leaves a step: displacement, velocity, acceleration.
  const Framebuffer& free_target() const { return free_target_; }

  /// The passes after it, which know the state the step began with.
  void follow_gradient(Pass& along);
  void sum(Pass& facets, Pass& sums);
  void find_roots(Pass& roots, int batch_step);
  /// For what ends the step.
  void bind_roots(Pass& step) const;

  /// The texels of the newest roots, and where they go from `offset` on in the buffer bound to GL_PIXEL_PACK_BUFFER.
  std::size_t texels() const { return static_cast<std::size_t>(root_targets_[0].shape().texels()); }
  void copy(std::size_t offset) const;

 private:
  struct Level {
    Texture sums;
    Framebuffer target;
    int first_node = 0, rows = 0;
  };

  int count_, particles_;
  NamedTables tables_;
  std::array<Texture, 3> free_;
  Texture along_;
  Framebuffer free_target_, along_target_;
  std::vector<Level> levels_;
  std::array<Texture, 2> roots_;  // [turn]: a pass reads one and writes the other
  std::array<Framebuffer, 2> root_targets_;
  std::size_t turn_ = 0;  // of the newest
};

}  // namespace phymul::gl

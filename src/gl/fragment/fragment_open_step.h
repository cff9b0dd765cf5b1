// SPDX-License-Identifier: MIT
//
// A step that the host acts in, between its forces and its motion: where particles would go, the list of those that the
// host asks for, and what it adds. Room for all particles, so that no step allocates.
#pragma once

#include <span>
#include <vector>

#include "gl/objects/pass.h"
#include "gl/solver/device.h"

namespace phymul::gl {

class FragmentOpenStep {
 public:
  /// `measured`: where free_pass.glsl leaves speeds.
  FragmentOpenStep(Index particles, const Texture& measured);

  const Framebuffer& target() const { return target_; }  ///< of free_pass.glsl
  /// A pass that reads what free_pass.glsl left.
  void bind(Pass& pass) const;
  void bind_pushes(Pass& pass) const;

  void set_gathered(std::span<const Index> rows);
  void gather(Pass& pass) const;
  void read(std::span<OpenRow> rows);
  void set_pushes(std::span<const Push> pushes);
  int push_count() const { return push_count_; }

 private:
  Texture force_, velocity_, withheld_;
  Framebuffer target_;
  Texture asked_, gathered_[3];
  Framebuffer gathered_target_;
  Texture push_rows_, push_forces_, push_shifts_;
  int asked_count_ = 0, push_count_ = 0;
  std::vector<Int4> rows_;
  std::vector<Float4> texels_, more_texels_;
};

}  // namespace phymul::gl

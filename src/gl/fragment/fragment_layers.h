// SPDX-License-Identifier: MIT
//
// FragmentLayers: rows of up to four texels that a step reads and writes, with each pair of FragmentState: a layer per
// texel. Rows on the host have four.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fragment_state.h"

namespace phymul::gl {

class FragmentLayers {
 public:
  static constexpr std::size_t host_texels = 4;

  FragmentLayers(std::int64_t rows, int layers, const char* name);

  const Texture& texture(int pair) const { return textures_[pair]; }
  const Framebuffer& target(int pair) const { return targets_[pair]; }
  void write(std::span<const Float4> rows, int pair);
  std::vector<Float4> read(int pair) const;  ///< waits for the device

 private:
  int layers_;
  std::array<Texture, FragmentState::pairs> textures_;
  std::array<Framebuffer, FragmentState::pairs> targets_;
};

}  // namespace phymul::gl

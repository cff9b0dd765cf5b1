// SPDX-License-Identifier: MIT
//
// The tools of a scene in textures, and, where they act on the device, what the particles do to each: added up per
// particle step by step, and over the particles once a report.
#pragma once

#include <array>
#include <optional>

#include "device/float_tools.h"
#include "reduction.h"

namespace phymul::gl {

class FragmentTools {
 public:
  static constexpr int rows_to_one = 16;  ///< of sum()

  /// `acts`: on the device; else joints alone look where they are.
  FragmentTools(const FloatTools& tools, bool acts);

  int count() const { return count_; }
  bool any_grid() const { return any_grid_; }
  void set_held(const FloatTools& tools);
  void set_frames(const FloatTools& tools);
  void bind(Pass& pass) const;

  /// A row for each tool and particle, drawn with tools_pass.glsl over the sums so far.
  void tell(Pass& pass);

  /// Brings the sums of the last tell() down to one row a tool.
  void sum(Pass& added);
  /// After sum(): the texels of a row of them, of which there are four; where they go from `offset` on in the buffer
  /// bound to GL_PIXEL_PACK_BUFFER.
  std::size_t texels() const { return static_cast<std::size_t>(added_->target().shape().texels()); }
  void copy(std::size_t offset) const;

 private:
  bool any_grid_;
  int count_, particles_;
  NamedTables tables_;
  Texture frames_, held_;
  std::array<std::array<Texture, 2>, 2> sums_;  // [turn]: forces, torques; a pass reads one and writes the other
  std::array<Texture, 2> last_;
  std::array<Framebuffer, 2> targets_;
  int turn_ = 0;                    // of the newest
  std::optional<Reduction> added_;  // forces, torques, and both of the last step
};

}  // namespace phymul::gl

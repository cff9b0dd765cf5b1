// SPDX-License-Identifier: MIT
//
// The needles of a scene in textures: laws, the body's surface, the holes as they are, as they were before the present
// batch and before a step that is only tried, and what the passes of a step write down. Rows:
// glsl/needle/needle_state.glsl.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "device/float_needles.h"
#include "device/float_tools.h"
#include "gl/objects/pass.h"
#include "gl/solver/device.h"

namespace phymul::gl {

/// What a needle's passes draw into, and read again. [nodes], [pairs] ...: rows.
struct NeedleTextures {
  static constexpr int team = 16;    ///< rows a node that its sums are made from
  static constexpr int branch = 32;  ///< needle_state.glsl
  static constexpr int pivots = 4;   ///< of an inversion, at a time

  NeedleTextures(const FloatNeedles::One& law, int particles, int facets);

  struct Level {  // of terms that are brought down to one row
    std::array<Texture, 3> rows;
    Framebuffer target;
    int count = 0;
  };

  std::array<Texture, 2> state;  // a pass reads one and writes the other
  std::array<Framebuffer, 2> state_targets;
  Texture lists;
  Framebuffer lists_target;
  std::array<Texture, 3> parts, means;  // [nodes * team], [nodes]: places, motions, what hubs feel
  Framebuffer parts_target, means_target;
  std::vector<Level> facets, around;
  Texture who;    // beside the first level of `around`
  Texture found;  // [particles of a node]
  Framebuffer found_target;
  std::array<std::array<Texture, 2>, 2> weights;  // [turn]: sums, solutions
  std::array<Framebuffer, 2> weight_targets;
  Texture coupling;  // [nodes * nodes]
  Framebuffer coupling_target;
  Texture marks;  // [particles of the body]
  Framebuffer marks_target;
  std::array<std::array<Texture, 2>, 2> settled;  // [turn]: sides, motions
  Texture impulses, node_ends;
  std::array<Framebuffer, 2> settled_targets;
  // Of a shaft that turns: pushes, moments.
  std::array<Texture, 2> turn_parts, twists;
  Framebuffer turn_parts_target, twists_target;
  // Of one that bends.
  std::array<Texture, 2> stiffness;  // [nodes * nodes + nodes]
  std::array<Framebuffer, 2> stiffness_targets;
  Texture panel, holds;  // [pivots * nodes], [nodes]
  Framebuffer panel_target, holds_target;
};

class FragmentNeedles {
 public:
  /// `loop_turns`: ContextInfo's.
  FragmentNeedles(const FloatNeedles& needles, const FloatTools& tools, std::int64_t loop_turns);

  struct Placed {
    FloatNeedles::One law;
    NeedleTextures drawn;
    std::size_t turn = 0;  // of the newest state
    bool coupled = false;  // coupling and marks are those of its hole
    struct Copy {
      Texture state, lists;
      Framebuffer state_target, lists_target;
    };
    std::array<Copy, 2> copies;  // checkpoint, trial
    int state_rows() const { return 8 + 2 * law.nodes; }
  };
  std::vector<Placed>& placed() { return placed_; }
  int count() const { return static_cast<int>(placed_.size()); }
  int particles() const { return particles_; }
  int facet_count() const { return facet_count_; }
  bool any_bends() const;
  bool turns(const Placed& needle, int number) const;  ///< in that step

  /// What every pass of a needle reads.
  void bind(Pass& pass) const;
  void set_frames(const FloatTools& tools) { frames_.assign(tools.frames().begin(), tools.frames().end()); }

  /// Holes as `tools` have them. Throws Error, and changes nothing, where one is longer than there is room for.
  void write(const FloatTools& tools);
  void read(FloatTools& tools) const;
  /// What is held has changed.
  void uncouple();

  // Copies of all holes on the device.
  void set_checkpoint() { copy_out(0); }
  void go_back() { copy_in(0); }
  void begin_trial() { copy_out(1); }
  void end_trial() { copy_in(1); }

  // Nodes a step may make: none is known before. What did not suffice is known from a report.
  int nodes_to_make(int number) const { return nodes_to_make_[static_cast<std::size_t>(number)]; }
  void begin_batch();
  void give_more();

  /// What a report carries: rows, and where they go from `offset` on in the buffer bound to GL_PIXEL_PACK_BUFFER.
  std::size_t told_texels() const;
  void copy_told(std::size_t offset) const;
  /// Of the rows that were copied; fills `sums` of the needles and what `report` says of them.
  void take(std::span<const Float4> rows, std::span<ToolSums> sums, BatchReport& report);

 private:
  std::vector<Float4> state_rows(const Placed& needle, const NeedleState& state) const;
  std::vector<Int2> list_rows(const Placed& needle, const NeedleState& state) const;
  NeedleState state_of(const Placed& needle, std::span<const Float4> rows, std::span<const Int4> lists) const;
  void require_room(const Placed& needle, const NeedleState& state) const;
  void copy_out(std::size_t copy);
  void copy_in(std::size_t copy);

  std::vector<Placed> placed_;
  int particles_, facet_count_, tool_count_;
  Texture laws_, facets_;
  std::vector<Float4> frames_;
  std::vector<int> nodes_to_make_;  // [step of the batch]
  int unfinished_step_ = 0;         // of the last report
  int later_ = 1;                   // nodes a step, after one that had too few
  std::size_t last_short_ = 0;
};

}  // namespace phymul::gl

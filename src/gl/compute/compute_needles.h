// SPDX-License-Identifier: MIT
//
// The needles of a scene in a buffer of words of their own: laws, the body's surface, the holes as they are, as they
// were before the present batch and before a step that is only tried, and what the passes of a step write down.
#pragma once

#include <span>
#include <vector>

#include "compute_tables.h"
#include "device/float_needles.h"
#include "device/float_tools.h"

namespace phymul::gl {

class ComputeNeedles {
 public:
  /// Throws Error where a needle's hole is more than this renderer's loops can take.
  ComputeNeedles(const FloatNeedles& needles, const FloatTools& tools, const ComputeTables& tables,
                 const ComputeLimits& limits);

  /// What needle_tables.glsl reads words by.
  static void define(ShaderRequest& request);

  int count() const { return static_cast<int>(needles_.size()); }
  bool any_bends() const;

  /// In place of constants, which passes of needles do not read.
  void bind() const { buffer_.bind(constant_rows_binding); }
  void place(Kernel& kernel) const;

  /// Holes as `tools` have them. Throws Error, and changes nothing, where one is longer than there is room for.
  void write(const FloatTools& tools);
  void read(FloatTools& tools) const;
  /// What is held or imposed has changed.
  void uncouple();

  // Copies of all holes on the device.
  void set_checkpoint() const { copy(now, checkpoint); }
  void go_back() const { copy(checkpoint, now); }
  void begin_trial() const { copy(now, trial); }
  void end_trial() const { copy(trial, now); }

  // What a report carries: a header of 4 rows for each needle, and where it bends the forces on its shaft.
  std::int64_t told_rows() const;
  void copy_told(std::int64_t to_byte) const;  ///< to the buffer bound to GL_PIXEL_PACK_BUFFER
  struct Told {
    int full_step = 0;  ///< first of the batch that there was no room for; 0: none
    int tool = -1;      ///< row of the needle
  };
  /// Of the rows that were copied; fills `sums` of the tools. The first needle that was full.
  Told take(std::span<const Float4> rows, std::span<ToolSums> sums) const;

  int follow_units() const { return units_; }  ///< of needle_follow_kernel.glsl, in a dispatch
  int follow_dispatches() const { return dispatches_; }

 private:
  enum Copy { now, checkpoint, trial, copies };
  struct Placed {
    FloatNeedles::One law;
    std::int64_t state = 0;  // words; in the first copy
    std::int64_t coupling = 0, stiffness = 0, inverse = 0, share = 0;
    int load_words() const { return law.bends() ? 4 * law.nodes : 0; }
    int front_words() const { return header_words + load_words() + 2 * law.nodes; }  // before the nodes' particles
    std::int64_t state_words() const;
  };
  static constexpr int header_words = 16;
  template <class Whole, class Real>
  static void for_each_law_word(const Placed& needle, Whole&& whole, Real&& real);
  std::vector<std::int32_t> law_words() const;
  std::vector<std::int32_t> state_words(const Placed& needle, const NeedleState& state) const;
  NeedleState state_of(const Placed& needle, const std::vector<std::int32_t>& words) const;
  void require_room(const Placed& needle, const NeedleState& state) const;
  void require_turns(std::int64_t particles, const ComputeLimits& limits);
  void copy(Copy from, Copy to) const;

  const ComputeTables* tables_;
  std::vector<Placed> needles_;
  std::vector<Index> particle_at_;  // [places] row of the model
  std::int64_t facets_ = 0, facet_count_ = 0, order_ = 0, state_ = 0, state_size_ = 0;
  int units_ = 0, dispatches_ = 1;
  StorageBuffer buffer_;
};

}  // namespace phymul::gl

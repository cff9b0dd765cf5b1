// SPDX-License-Identifier: MIT
//
// The passes of a step in which needles act, drawn, between free_pass.glsl and what presses after them: for each needle
// its hole as it goes on, then its forces. Made where a scene has needles.
#pragma once

#include <cstdint>

#include "fragment_needles.h"
#include "fragment_pushed.h"
#include "fragment_state.h"
#include "fragment_tools.h"
#include "gl/solver/body_kind.h"

namespace phymul::gl {

class FragmentNeedlePasses {
 public:
  /// Compiles. `loop_turns`: of a shader, after which this renderer breaks off; `bending`: some needle bends.
  FragmentNeedlePasses(const ShaderLibrary& library, const BodyKind& kind, std::int64_t loop_turns, bool bending);

  bool bending() const { return bending_; }

  void set_needles(FragmentNeedles& needles, const FragmentTools& tools);
  void set_step(double dt);

  /// Step `number` of a batch, from the present state.
  void act(const FragmentState& state, int number, FragmentPushed& pushed);

 private:
  using Placed = FragmentNeedles::Placed;
  Pass compiled(ShaderFiles files, std::vector<std::pair<std::string, int>> defines = {}) const;
  void prepare(Pass& pass, const Placed& needle) const;
  void draw(Pass& pass, const Placed& needle, const Texture& rows, int count, const Framebuffer& target) const;
  void draw_state(Pass& pass, Placed& needle) const;
  void gather(Placed& needle, bool only_new);
  void meet_surface(const Placed& needle);
  void take_aim(Placed& needle, bool after_node, bool ends);
  void make_node(Placed& needle);
  void find_particles(const Placed& needle);
  void weigh(const Placed& needle);
  void couple(Placed& needle);
  void twist(Placed& needle, FragmentPushed& pushed);
  void stiffen(const Placed& needle);
  void settle(const Placed& needle);
  void settle_on_bent(const Placed& needle);
  void sweep(const Placed& needle, int from, int to);
  int sweeps_at_a_time(const Placed& needle) const;
  template <class Function>
  void for_all(Function&& function);

  const ShaderLibrary* library_;
  BodyKind kind_;
  std::int64_t loop_turns_;
  bool bending_;
  Pass parts_, means_, begin_, first_facets_, facets_, aim_, first_around_, around_, select_, first_weights_, weights_,
      append_, marks_, coupling_, turn_parts_, twist_, give_twist_, stiffness_, panel_, invert_, hold_, settle_, give_,
      end_;
  FragmentNeedles* needles_ = nullptr;
  // Of the step at hand.
  const FragmentPushed* pushed_ = nullptr;
  const FragmentState* state_ = nullptr;
  int number_ = 0, row_ = 0;
  std::size_t settled_ = 0;  // turn of the newest
};

}  // namespace phymul::gl

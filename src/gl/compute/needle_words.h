// SPDX-License-Identifier: MIT
//
// The words of a needle's law and of the header of its state: glsl/needle/needle_tables.glsl.
#pragma once

namespace phymul::gl {

// What the words of a law and of a state's header mean; shaders know them as LAW_STATE ..., HEADER_COUNT ...
enum LawWord {
  state_law,
  coupling_law,
  stiffness_law,
  inverse_law,
  share_law,
  nodes_law,
  particles_law,
  tool_law,
  length_law,
  radius_law,
  puncture_law,
  cutting_law,
  static_friction_law,
  kinetic_friction_law,
  surface_friction_law,
  spread_law,
  reach_law,
  bending_stiffness_law,
  law_words_used
};
enum HeaderWord {
  count_word,
  punctured_word,
  through_word,
  slip_word,
  loads_word,
  full_word,
  coupled_word,
  stage_word,
  left_word,
  reach_word,
  first_word,
  way_word,
  header_words_used
};
constexpr int words_a_law = (law_words_used + 3) / 4 * 4;

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
//
// The words of the header of a needle's state, and how many its law has: glsl/needle/needle_tables.glsl.
#pragma once

namespace phymul::gl {

constexpr int words_a_law = 20;  ///< two to spare

/// What the words of a state's header mean; shaders know them as HEADER_COUNT ...
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

}  // namespace phymul::gl

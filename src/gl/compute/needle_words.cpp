// SPDX-License-Identifier: MIT
//
// Laws and states of needles as words.
#include "needle_words.h"

#include <array>
#include <bit>
#include <utility>

#include "compute_needles.h"

namespace phymul::gl {
namespace {

constexpr std::array names{
    std::pair{"LAW_STATE", int{state_law}},
    std::pair{"LAW_COUPLING", int{coupling_law}},
    std::pair{"LAW_STIFFNESS", int{stiffness_law}},
    std::pair{"LAW_INVERSE", int{inverse_law}},
    std::pair{"LAW_SHARE", int{share_law}},
    std::pair{"LAW_NODES", int{nodes_law}},
    std::pair{"LAW_PARTICLES", int{particles_law}},
    std::pair{"LAW_TOOL", int{tool_law}},
    std::pair{"LAW_LENGTH", int{length_law}},
    std::pair{"LAW_RADIUS", int{radius_law}},
    std::pair{"LAW_PUNCTURE", int{puncture_law}},
    std::pair{"LAW_CUTTING", int{cutting_law}},
    std::pair{"LAW_STATIC_FRICTION", int{static_friction_law}},
    std::pair{"LAW_KINETIC_FRICTION", int{kinetic_friction_law}},
    std::pair{"LAW_SURFACE_FRICTION", int{surface_friction_law}},
    std::pair{"LAW_SPREAD", int{spread_law}},
    std::pair{"LAW_REACH", int{reach_law}},
    std::pair{"LAW_BENDING_STIFFNESS", int{bending_stiffness_law}},
    std::pair{"HEADER_COUNT", int{count_word}},
    std::pair{"HEADER_PUNCTURED", int{punctured_word}},
    std::pair{"HEADER_THROUGH", int{through_word}},
    std::pair{"HEADER_SLIP", int{slip_word}},
    std::pair{"HEADER_LOADS", int{loads_word}},
    std::pair{"HEADER_FULL", int{full_word}},
    std::pair{"HEADER_COUPLED", int{coupled_word}},
    std::pair{"HEADER_STAGE", int{stage_word}},
    std::pair{"HEADER_LEFT", int{left_word}},
    std::pair{"HEADER_REACH", int{reach_word}},
    std::pair{"HEADER_FIRST", int{first_word}},
    std::pair{"HEADER_WAY", int{way_word}},
    std::pair{"LAW_WORDS", words_a_law},
};

}  // namespace

void ComputeNeedles::define(ShaderRequest& request) {
  static_assert(header_words_used <= header_words);
  for (const auto& [name, word] : names) request.defines.emplace_back(name, word);
  request.defines.emplace_back("HEADER_WORDS", header_words);
}

std::vector<std::int32_t> ComputeNeedles::law_words() const {
  std::vector<std::int32_t> words(words_a_law * needles_.size(), 0);
  std::int32_t* own = words.data();
  for (const Placed& needle : needles_) {
    const auto whole = [&](LawWord word, std::int64_t value) { own[word] = static_cast<std::int32_t>(value); };
    const auto real = [&](LawWord word, double value) { own[word] = bits_of(static_cast<float>(value)); };
    whole(state_law, needle.state);
    whole(coupling_law, needle.coupling);
    whole(stiffness_law, needle.stiffness);
    whole(inverse_law, needle.inverse);
    whole(share_law, needle.share);
    whole(nodes_law, needle.law.nodes);
    whole(particles_law, needle.law.particles);
    whole(tool_law, needle.law.tool);
    const Needle& law = needle.law.needle;
    real(length_law, law.length);
    real(radius_law, law.radius);
    real(puncture_law, law.puncture);
    real(cutting_law, law.cutting);
    real(static_friction_law, law.static_friction);
    real(kinetic_friction_law, law.kinetic_friction);
    real(surface_friction_law, needle.law.friction);
    real(spread_law, needle.law.spread);
    real(reach_law, needle.law.reach);
    real(bending_stiffness_law, law.bending_stiffness);
    own += words_a_law;
  }
  return words;
}

std::vector<std::int32_t> ComputeNeedles::state_words(const Placed& needle, const NeedleState& state) const {
  const auto most = static_cast<std::size_t>(needle.law.particles);
  const auto front = static_cast<std::size_t>(needle.front_words());
  std::vector<std::int32_t> words(front + 2 * most * state.hole.size(), 0);
  const auto real = [](double value) { return bits_of(static_cast<float>(value)); };
  words[count_word] = static_cast<std::int32_t>(state.hole.size());
  words[punctured_word] = state.punctured ? 1 : 0;
  words[through_word] = state.through ? 1 : 0;
  words[slip_word] = real(state.slip);
  if (needle.law.bends()) {
    words[loads_word] = static_cast<std::int32_t>(state.shaft.size());
    for (std::size_t k = 0; k < state.shaft.size(); ++k) {
      std::int32_t* const load = &words[header_words + 4 * k];
      load[0] = real(state.shaft[k].along);
      load[1] = real(state.shaft[k].x);
      load[2] = real(state.shaft[k].y);
    }
  }
  for (std::size_t k = 0; k < state.hole.size(); ++k) {
    const NeedleNode& node = state.hole[k];
    std::int32_t* const own = &words[front - 2 * static_cast<std::size_t>(needle.law.nodes) + 2 * k];
    own[0] = static_cast<std::int32_t>(node.particles.size());
    own[1] = node.slides ? 1 : 0;
    std::int32_t* const list = &words[front + 2 * most * k];
    for (std::size_t j = 0; j < node.particles.size(); ++j) {
      list[j] = tables_->place_of()[static_cast<std::size_t>(node.particles[j])];
      list[most + j] = real(node.weights[j]);
    }
  }
  return words;
}

NeedleState ComputeNeedles::state_of(const Placed& needle, const std::vector<std::int32_t>& words) const {
  const auto real = [](std::int32_t bits) { return static_cast<double>(std::bit_cast<float>(bits)); };
  const auto most = static_cast<std::size_t>(needle.law.particles);
  const auto front = static_cast<std::size_t>(needle.front_words());
  NeedleState state{
      .punctured = words[punctured_word] != 0, .through = words[through_word] != 0, .slip = real(words[slip_word])};
  for (std::int32_t k = 0; k < words[loads_word]; ++k) {
    const std::int32_t* const load = &words[static_cast<std::size_t>(header_words + 4 * k)];
    state.shaft.push_back({.along = real(load[0]), .x = real(load[1]), .y = real(load[2])});
  }
  state.hole.resize(static_cast<std::size_t>(words[count_word]));
  for (std::size_t k = 0; k < state.hole.size(); ++k) {
    NeedleNode& node = state.hole[k];
    const std::int32_t* const own = &words[front - 2 * static_cast<std::size_t>(needle.law.nodes) + 2 * k];
    const std::int32_t* const list = &words[front + 2 * most * k];
    for (std::size_t j = 0; j < static_cast<std::size_t>(own[0]); ++j) {
      node.particles.push_back(particle_at_[static_cast<std::size_t>(list[j])]);
      node.weights.push_back(real(list[most + j]));
    }
    node.slides = own[1] != 0;
  }
  return state;
}

}  // namespace phymul::gl

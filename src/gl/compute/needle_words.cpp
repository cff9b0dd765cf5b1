// SPDX-License-Identifier: MIT
//
// Laws and states of needles as words.
#include "needle_words.h"

#include <array>
#include <bit>
#include <cassert>

#include "compute_needles.h"

namespace phymul::gl {
namespace {

/// By HeaderWord.
constexpr std::array header_names{"HEADER_COUNT", "HEADER_PUNCTURED", "HEADER_THROUGH", "HEADER_SLIP",
                                  "HEADER_LOADS", "HEADER_FULL",      "HEADER_COUPLED", "HEADER_STAGE",
                                  "HEADER_LEFT",  "HEADER_REACH",     "HEADER_FIRST",   "HEADER_WAY"};
static_assert(header_names.size() == header_words_used);

}  // namespace

/// Calls whole(name, value) or real(name, value) for each word of a law, in order.
template <class Whole, class Real>
void ComputeNeedles::for_each_law_word(const Placed& needle, Whole&& whole, Real&& real) {
  const FloatNeedles::One& own = needle.law;
  whole("LAW_STATE", needle.state);
  whole("LAW_COUPLING", needle.coupling);
  whole("LAW_STIFFNESS", needle.stiffness);
  whole("LAW_INVERSE", needle.inverse);
  whole("LAW_SHARE", needle.share);
  whole("LAW_NODES", own.nodes);
  whole("LAW_PARTICLES", own.particles);
  whole("LAW_TOOL", own.tool);
  real("LAW_LENGTH", own.needle.length);
  real("LAW_RADIUS", own.needle.radius);
  real("LAW_PUNCTURE", own.needle.puncture);
  real("LAW_CUTTING", own.needle.cutting);
  real("LAW_STATIC_FRICTION", own.needle.static_friction);
  real("LAW_KINETIC_FRICTION", own.needle.kinetic_friction);
  real("LAW_SURFACE_FRICTION", own.friction);
  real("LAW_SPREAD", own.spread);
  real("LAW_REACH", own.reach);
  real("LAW_BENDING_STIFFNESS", own.needle.bending_stiffness);
}

void ComputeNeedles::define(ShaderRequest& request) {
  static_assert(header_words_used <= header_words);
  int word = 0;
  const auto name_it = [&](const char* name, auto) { request.defines.emplace_back(name, word++); };
  for_each_law_word({}, name_it, name_it);
  assert(word <= words_a_law);
  for (int k = 0; k < header_words_used; ++k) request.defines.emplace_back(header_names[k], k);
  request.defines.emplace_back("LAW_WORDS", words_a_law);
  request.defines.emplace_back("HEADER_WORDS", header_words);
}

std::vector<std::int32_t> ComputeNeedles::law_words() const {
  std::vector<std::int32_t> words;
  for (const Placed& needle : needles_) {
    for_each_law_word(
        needle, [&](const char*, std::int64_t value) { words.push_back(static_cast<std::int32_t>(value)); },
        [&](const char*, double value) { words.push_back(bits_of(static_cast<float>(value))); });
    words.resize((words.size() + words_a_law - 1) / words_a_law * words_a_law, 0);
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

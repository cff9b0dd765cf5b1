// SPDX-License-Identifier: MIT
#include "compute_needles.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <string>

#include "needle_passes.h"
#include "needle_words.h"

namespace phymul::gl {
namespace {

std::int64_t whole_rows(std::int64_t words) {
  return (words + 3) / 4 * 4;
}

}  // namespace

std::int64_t ComputeNeedles::Placed::state_words() const {
  return whole_rows(front_words() + std::int64_t{2} * law.nodes * law.particles);
}

ComputeNeedles::ComputeNeedles(const FloatNeedles& needles, const FloatTools& tools, const ComputeTables& tables,
                               const ComputeLimits& limits)
    : tables_(&tables), facet_count_(static_cast<std::int64_t>(needles.facets.size())) {
  const auto particles = static_cast<std::int64_t>(tables.place_of().size());
  std::int64_t end = 0;
  const auto take = [&end](std::int64_t words) {
    const std::int64_t word = end;
    end += whole_rows(words);
    return word;
  };
  for (const FloatNeedles::One& one : needles.needles) needles_.push_back({.law = one});
  require_turns(particles, limits);
  take(words_a_law * static_cast<std::int64_t>(needles_.size()));
  facets_ = take(3 * facet_count_);
  order_ = take(particles);
  state_ = end;
  for (Placed& needle : needles_) needle.state = take(needle.state_words());
  state_size_ = end - state_;
  end += (copies - 1) * state_size_;
  for (Placed& needle : needles_) {
    const std::int64_t pairs = std::int64_t{needle.law.nodes} * needle.law.nodes;
    needle.coupling = take(4 * pairs);
    if (needle.law.bends()) {
      needle.stiffness = take(2 * pairs);
      needle.inverse = take(2 * pairs);
    }
    needle.share = take(4 * std::int64_t{tables.places()});
  }
  if (end > std::numeric_limits<int>::max()) {
    throw Error(ErrorCode::not_supported,
                "the scene's needles take more than the 2147483647 words a shader counts to; use a larger "
                "Needle::spread, or the backend \"cpu\"");
  }
  buffer_ = StorageBuffer(end / 4, "the scene's needles", limits);
  buffer_.write_rows(0, law_words());
  std::vector<std::int32_t> corners;
  for (const std::array<Index, 3>& facet : needles.facets) {
    for (const Index i : facet) corners.push_back(tables.place_of()[static_cast<std::size_t>(i)]);
  }
  buffer_.write_rows(facets_ / 4, corners);
  buffer_.write_rows(order_ / 4, tables.place_of());
  particle_at_.assign(static_cast<std::size_t>(tables.places()), -1);
  for (std::size_t i = 0; i < tables.place_of().size(); ++i) {
    particle_at_[static_cast<std::size_t>(tables.place_of()[i])] = static_cast<Index>(i);
  }
  const std::vector<Int4> zeros(static_cast<std::size_t>(tables.places()), Int4{});
  for (const Placed& needle : needles_) buffer_.write_rows(needle.share / 4, zeros);
  write(tools);
}

bool ComputeNeedles::any_bends() const {
  return std::ranges::any_of(needles_, [](const Placed& needle) { return needle.law.bends(); });
}

/// What a dispatch of needle_follow_kernel.glsl may do, and how many are surely enough for a step: half of a renderer's
/// turns are left to what is not counted. A unit looks for particles around a place, or couples a node; five times,
/// wider and wider, is more than any mesh asks for.
void ComputeNeedles::require_turns(std::int64_t particles, const ComputeLimits& limits) {
  const std::int64_t group = NeedlePasses::group(limits), team = NeedlePasses::team;
  const auto rounds = [group](std::int64_t rows) { return (rows + group - 1) / group; };
  std::int64_t unit = 1, acting = 1, nodes = 1;
  for (const Placed& needle : needles_) {
    const std::int64_t most = needle.law.particles, longest = needle.law.nodes;
    const std::int64_t teams = group / team,
                       by_team = (longest + teams - 1) / teams * ((most + team - 1) / team + team);
    nodes = std::max(nodes, longest);
    unit = std::max(unit, 2 * rounds(particles) + 3 * rounds(facet_count_) + 8 * rounds(most) + by_team + 320);
    acting = std::max(acting, 2 * by_team + 4 * longest * rounds(most) + 64 * longest + 4 * longest * longest);
  }
  const std::int64_t turns = limits.loop_turns / 2;
  const std::int64_t needed = 6 * nodes + 32;
  if (unit > turns || acting > turns) {
    throw Error(ErrorCode::not_supported,
                "expected needles that take at most " + std::to_string(turns) +
                    " turns of a shader's loops, half of where this renderer breaks off, got up to " +
                    std::to_string(std::max(unit, acting)) + " for a body of " + std::to_string(particles) +
                    " particles; use the backend \"cpu\"");
  }
  units_ = static_cast<int>(std::min(turns / unit, needed));
  dispatches_ = static_cast<int>((needed + units_ - 1) / units_);
}

void ComputeNeedles::place(Kernel& kernel) const {
  kernel.set("needle_facets", static_cast<int>(facets_));
  kernel.set("facet_count", static_cast<int>(facet_count_));
  kernel.set("needle_order", static_cast<int>(order_));
  kernel.set("model_count", static_cast<int>(tables_->place_of().size()));
}

void ComputeNeedles::require_room(const Placed& needle, const NeedleState& state) const {
  std::size_t most = 0;
  for (const NeedleNode& node : state.hole) most = std::max(most, node.particles.size());
  const auto nodes = static_cast<std::size_t>(needle.law.nodes),
             particles = static_cast<std::size_t>(needle.law.particles);
  if (state.hole.size() <= nodes && state.shaft.size() <= nodes && most <= particles) return;
  throw Error(ErrorCode::not_supported,
              "expected a needle's hole of at most " + std::to_string(nodes) + " points, means of at most " +
                  std::to_string(particles) + " particles, which is what this device has room for, got " +
                  std::to_string(std::max(state.hole.size(), state.shaft.size())) + " of " + std::to_string(most) +
                  "; give the needle a larger Needle::spread, or use the backend \"cpu\"");
}

void ComputeNeedles::write(const FloatTools& tools) {
  for (const Placed& needle : needles_) require_room(needle, tools.needle(needle.law.tool));
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  for (const Placed& needle : needles_) {
    buffer_.write_rows(needle.state / 4, state_words(needle, tools.needle(needle.law.tool)));
  }
  set_checkpoint();
}

void ComputeNeedles::read(FloatTools& tools) const {
  for (const Placed& needle : needles_) {
    const auto read_words = [&](std::int64_t count) {
      std::vector<std::int32_t> words(static_cast<std::size_t>(whole_rows(count)));
      buffer_.read(needle.state / 4, static_cast<std::int64_t>(words.size() / 4), words.data());
      return words;
    };
    std::vector<std::int32_t> words = read_words(header_words);
    const std::int64_t nodes = words[count_word];
    if (nodes > 0 || words[loads_word] > 0) words = read_words(needle.front_words() + 2 * nodes * needle.law.particles);
    tools.set_needle(needle.law.tool, state_of(needle, words));
  }
}

void ComputeNeedles::uncouple() {
  const std::int32_t none = 0;
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  for (const Placed& needle : needles_) buffer_.write(4 * (needle.state + coupled_word), &none, 4);
}

void ComputeNeedles::copy(Copy from, Copy to) const {
  const auto row = [this](Copy which) { return (state_ + which * state_size_) / 4; };
  glBindBuffer(GL_COPY_WRITE_BUFFER, buffer_.id());
  buffer_.copy(row(from), state_size_ / 4, GL_COPY_WRITE_BUFFER, 16 * row(to));
  glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
}

std::int64_t ComputeNeedles::told_rows() const {
  std::int64_t rows = 0;
  for (const Placed& needle : needles_) rows += (header_words + needle.load_words()) / 4;
  return rows;
}

void ComputeNeedles::copy_told(GLintptr to_byte) const {
  for (const Placed& needle : needles_) {
    const std::int64_t rows = (header_words + needle.load_words()) / 4;
    buffer_.copy(needle.state / 4, rows, GL_PIXEL_PACK_BUFFER, to_byte);
    to_byte += 16 * rows;
  }
}

ComputeNeedles::Told ComputeNeedles::take(std::span<const Float4> rows, std::span<ToolSums> sums) const {
  Told told;
  for (const Placed& needle : needles_) {
    const auto header = [&](int word) {
      return bits_of(rows[static_cast<std::size_t>(word / 4)][static_cast<std::size_t>(word % 4)]);
    };
    std::vector<ShaftLoad>& shaft = sums[static_cast<std::size_t>(needle.law.tool)].shaft;
    shaft.clear();
    for (int k = 0; k < header(loads_word); ++k) {
      const Float4& load = rows[static_cast<std::size_t>(header_words / 4 + k)];
      shaft.push_back({.along = load[0], .x = load[1], .y = load[2]});
    }
    const int full = header(full_word);
    if (full > 0 && (told.full_step == 0 || full < told.full_step)) told = {full, needle.law.tool};
    rows = rows.subspan(static_cast<std::size_t>((header_words + needle.load_words()) / 4));
  }
  return told;
}

}  // namespace phymul::gl

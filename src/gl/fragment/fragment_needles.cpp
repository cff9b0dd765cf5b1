// SPDX-License-Identifier: MIT
#include "fragment_needles.h"

#include <phymul/error.h>

#include <algorithm>
#include <bit>
#include <string>
#include <utility>

namespace phymul::gl {
namespace {

// As glsl/needle/needle_state.glsl has them.
constexpr int header_rows = 4, hub_rows = 4;

Float4 row_of(double x, double y = 0.0, double z = 0.0, double w = 0.0) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(w)};
}

std::size_t index(int k) {
  return static_cast<std::size_t>(k);
}

}  // namespace

FragmentNeedles::FragmentNeedles(const FloatNeedles& needles, const FloatTools& tools, std::int64_t loop_turns)
    : particles_(static_cast<int>(tools.held().size())),
      facet_count_(static_cast<int>(needles.facets.size())),
      tool_count_(tools.count()) {
  std::vector<Float4> laws;
  for (FloatNeedles::One one : needles.needles) {
    // Coupling takes three turns for each particle of a node; half of the turns are left to what is not counted.
    one.particles = static_cast<Index>(std::min<std::int64_t>(one.particles, loop_turns / 6));
    const Needle& law = one.needle;
    laws.push_back(row_of(one.nodes, one.particles, one.tool));
    laws.push_back(row_of(law.length, law.radius));
    laws.push_back(row_of(law.puncture, law.cutting, law.static_friction, law.kinetic_friction));
    laws.push_back(row_of(one.friction, one.spread, one.reach, law.bending_stiffness));
    Placed& placed = placed_.emplace_back(Placed{one, NeedleTextures(one, particles_, facet_count_), 0, false, {}});
    for (Placed::Copy& copy : placed.copies) {
      copy.state = Texture::target(placed.state_rows(), TexelFormat::rgba32f, "a needle's hole");
      copy.lists = Texture::target(std::int64_t{one.nodes} * one.particles, TexelFormat::rg32i, "a needle's hole");
      copy.state_target = Framebuffer({{&copy.state}});
      copy.lists_target = Framebuffer({{&copy.lists}});
    }
  }
  laws_ = Texture::table(std::span<const Float4>(laws), "needle_laws");
  std::vector<Int4> facets;
  for (const auto& [a, b, c] : needles.facets) facets.push_back({a, b, c, none});
  facets_ = Texture::table(std::span<const Int4>(facets), "needle_facets");
  begin_batch();
  set_frames(tools);
  write(tools);
}

bool FragmentNeedles::any_bends() const {
  return std::ranges::any_of(placed_, [](const Placed& needle) { return needle.law.bends(); });
}

bool FragmentNeedles::turns(const Placed& needle, int number) const {
  const std::size_t frame = index(number - 1) * index(tool_count_) + index(needle.law.tool);
  return frames_[FloatTools::frame_rows * frame + 3][3] != 0.0f;
}

void FragmentNeedles::bind(Pass& pass) const {
  pass.input("needle_laws", laws_);
  pass.input("needle_facets", facets_);
  pass.set("facet_count", facet_count_);
  pass.set("model_count", particles_);
}

void FragmentNeedles::require_room(const Placed& needle, const NeedleState& state) const {
  std::size_t most = 0;
  for (const NeedleNode& node : state.hole) most = std::max(most, node.particles.size());
  const std::size_t nodes = index(needle.law.nodes), particles = index(needle.law.particles);
  if (state.hole.size() <= nodes && state.shaft.size() <= nodes && most <= particles) return;
  throw Error("expected a needle's hole of at most " + std::to_string(nodes) + " points, means of at most " +
              std::to_string(particles) + " particles, which is what this device has room for, got " +
              std::to_string(std::max(state.hole.size(), state.shaft.size())) + " of " + std::to_string(most) +
              "; give the needle a larger Needle::spread, or use the backend \"cpu\"");
}

std::vector<Float4> FragmentNeedles::state_rows(const Placed& needle, const NeedleState& state) const {
  std::vector<Float4> rows(index(needle.state_rows()), Float4{});
  const bool bends = needle.law.bends();
  rows[0] = row_of(static_cast<double>(state.hole.size()), state.punctured ? 1.0 : 0.0, state.through ? 1.0 : 0.0,
                   state.slip);
  if (bends) rows[1][0] = static_cast<float>(state.shaft.size());
  for (std::size_t k = 0; k < state.hole.size(); ++k) {
    rows[header_rows + hub_rows + k] =
        row_of(static_cast<double>(state.hole[k].particles.size()), state.hole[k].slides ? 1.0 : 0.0);
  }
  const std::size_t loads = header_rows + hub_rows + index(needle.law.nodes);
  for (std::size_t k = 0; bends && k < state.shaft.size(); ++k) {
    rows[loads + k] = row_of(state.shaft[k].along, state.shaft[k].x, state.shaft[k].y);
  }
  return rows;
}

/// In the model's order, in which passes look for a particle.
std::vector<Int2> FragmentNeedles::list_rows(const Placed& needle, const NeedleState& state) const {
  const std::size_t most = index(needle.law.particles);
  std::vector<Int2> rows(most * state.hole.size(), Int2{});
  for (std::size_t k = 0; k < state.hole.size(); ++k) {
    const NeedleNode& node = state.hole[k];
    for (std::size_t j = 0; j < node.particles.size(); ++j) {
      rows[most * k + j] = {node.particles[j], bits_of(static_cast<float>(node.weights[j]))};
    }
    const auto from = rows.begin() + static_cast<std::ptrdiff_t>(most * k);
    std::sort(from, from + static_cast<std::ptrdiff_t>(node.particles.size()));
  }
  return rows;
}

NeedleState FragmentNeedles::state_of(const Placed& needle, std::span<const Float4> rows,
                                      std::span<const Int4> lists) const {
  NeedleState state;
  state.punctured = rows[0][1] > 0.0f;
  state.through = rows[0][2] > 0.0f;
  state.slip = static_cast<double>(rows[0][3]);
  const std::size_t loads = header_rows + hub_rows + index(needle.law.nodes);
  for (std::size_t k = 0; k < static_cast<std::size_t>(rows[1][0]); ++k) {
    const Float4& load = rows[loads + k];
    state.shaft.push_back({.along = load[0], .x = load[1], .y = load[2]});
  }
  state.hole.resize(static_cast<std::size_t>(rows[0][0]));
  for (std::size_t k = 0; k < state.hole.size(); ++k) {
    NeedleNode& node = state.hole[k];
    const Float4& own = rows[header_rows + hub_rows + k];
    for (std::size_t j = 0; j < static_cast<std::size_t>(own[0]); ++j) {
      const Int4& entry = lists[index(needle.law.particles) * k + j];
      node.particles.push_back(entry[0]);
      node.weights.push_back(static_cast<double>(std::bit_cast<float>(entry[1])));
    }
    node.slides = own[1] > 0.0f;
  }
  return state;
}

void FragmentNeedles::write(const FloatTools& tools) {
  for (const Placed& needle : placed_) require_room(needle, tools.needle(needle.law.tool));
  for (Placed& needle : placed_) {
    const NeedleState& state = tools.needle(needle.law.tool);
    const std::vector<Float4> rows = state_rows(needle, state);
    const std::vector<Int2> lists = list_rows(needle, state);
    needle.turn = 0;
    needle.drawn.state[0].upload(std::span<const Float4>(rows));
    if (!lists.empty()) needle.drawn.lists.upload(std::span<const Int2>(lists));
  }
  uncouple();
  set_checkpoint();
}

void FragmentNeedles::read(FloatTools& tools) const {
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  for (const Placed& needle : placed_) {
    const Framebuffer& state = needle.drawn.state_targets[needle.turn];
    std::vector<Float4> rows(static_cast<std::size_t>(state.shape().texels()));
    state.read(0, GL_RGBA, GL_FLOAT, rows.data());
    std::vector<Int4> lists;
    if (rows[0][0] > 0.0f) {
      lists.resize(static_cast<std::size_t>(needle.drawn.lists_target.shape().texels()));
      needle.drawn.lists_target.read(0, GL_RGBA_INTEGER, GL_INT, lists.data());
    }
    tools.set_needle(needle.law.tool, state_of(needle, rows, lists));
  }
}

void FragmentNeedles::uncouple() {
  for (Placed& needle : placed_) needle.coupled = false;
}

void FragmentNeedles::copy_out(std::size_t copy) {
  for (Placed& needle : placed_) {
    needle.drawn.state_targets[needle.turn].copy_to(needle.copies[copy].state_target);
    needle.drawn.lists_target.copy_to(needle.copies[copy].lists_target);
  }
}

void FragmentNeedles::copy_in(std::size_t copy) {
  for (Placed& needle : placed_) {
    needle.copies[copy].state_target.copy_to(needle.drawn.state_targets[needle.turn]);
    needle.copies[copy].lists_target.copy_to(needle.drawn.lists_target);
    needle.coupled = false;  // another hole may have been begun in what is taken back
  }
}

void FragmentNeedles::begin_batch() {
  nodes_to_make_.assign(index(Device::most_steps + 1), 0);
  unfinished_step_ = 0;
  later_ = 1;
}

/// A step that had too few gets four times as many; those after it, of which nothing is known, a few, and more of them
/// where one of those has had too few in its turn. What steps before it did they do again.
void FragmentNeedles::give_more() {
  const std::size_t short_step = index(unfinished_step_);
  if (short_step > 0 && short_step != last_short_ && nodes_to_make_[short_step] > 0) later_ *= 2;
  last_short_ = short_step;
  const int more = std::max(1, 4 * nodes_to_make_[short_step]);
  nodes_to_make_[short_step] = more;
  const int later = short_step > 0 ? std::min(more, later_) : more;
  for (std::size_t step = short_step + 1; step < nodes_to_make_.size(); ++step) {
    nodes_to_make_[step] = std::max(nodes_to_make_[step], later);
  }
}

std::size_t FragmentNeedles::told_texels() const {
  std::size_t texels = 0;
  for (const Placed& needle : placed_) {
    texels += static_cast<std::size_t>(needle.drawn.state_targets[0].shape().texels());
  }
  return texels;
}

void FragmentNeedles::copy_told(std::size_t offset) const {
  for (const Placed& needle : placed_) {
    const Framebuffer& state = needle.drawn.state_targets[needle.turn];
    state.read(0, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(offset));  // an offset in the buffer
    offset += static_cast<std::size_t>(state.shape().texels()) * sizeof(Float4);
  }
}

void FragmentNeedles::take(std::span<const Float4> rows, std::span<ToolSums> sums, BatchReport& report) {
  unfinished_step_ = 0;
  const auto sees = [](int& earliest, float step) {
    const bool is_earlier = step > 0.0f && (earliest == 0 || static_cast<int>(step) < earliest);
    if (is_earlier) earliest = static_cast<int>(step);
    return is_earlier;
  };
  for (const Placed& needle : placed_) {
    ToolSums& told = sums[index(needle.law.tool)];
    told.force = rows[header_rows];
    told.torque = rows[header_rows + 1];
    told.last_force = rows[header_rows + 2];
    told.last_torque = rows[header_rows + 3];
    told.shaft.clear();
    const std::size_t loads = header_rows + hub_rows + index(needle.law.nodes);
    for (std::size_t k = 0; k < static_cast<std::size_t>(rows[1][0]); ++k) {
      told.shaft.push_back({.along = rows[loads + k][0], .x = rows[loads + k][1], .y = rows[loads + k][2]});
    }
    if (sees(report.full_step, rows[1][1])) report.full_needle = needle.law.tool;
    sees(unfinished_step_, rows[1][2]);
    rows = rows.subspan(static_cast<std::size_t>(needle.drawn.state_targets[0].shape().texels()));
  }
  // What comes after a step in which a particle ran away was not to be done.
  report.unfinished = unfinished_step_ > 0 && (report.runaway_step == 0 || unfinished_step_ <= report.runaway_step);
}

}  // namespace phymul::gl

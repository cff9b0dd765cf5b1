// SPDX-License-Identifier: MIT
#include "fragment_tools.h"

#include <span>

namespace phymul::gl {
namespace {

constexpr std::array<const char*, 4> sum_inputs{"forces", "torques", "last_forces", "last_torques"};

}  // namespace

FragmentTools::FragmentTools(const FloatTools& tools, bool acts)
    : any_grid_(tools.any_grid()), count_(tools.count()), particles_(static_cast<int>(tools.held().size())) {
  tables_.add("tool_laws", tools.laws());
  tables_.add("tool_rest", tools.rest());
  if (any_grid_) tables_.add("tool_grid", tools.grid_values());
  held_ = Texture::table(std::span<const Float4>(tools.held()), "tool_held");
  frames_ = Texture::target(static_cast<std::int64_t>(tools.most_frames()), "tool_frames");
  if (!acts) return;
  added_.emplace(particles_, rows_to_one,
                 std::vector<Reduction::Result>{{sum_inputs[0]}, {sum_inputs[1]}, {sum_inputs[2]}, {sum_inputs[3]}},
                 "forces on tools", count_);
  const std::int64_t rows = std::int64_t{count_} * particles_;
  for (Texture& texture : last_) texture = Texture::target(rows, "forces on tools");
  for (std::size_t turn = 0; turn < sums_.size(); ++turn) {
    for (Texture& texture : sums_[turn]) texture = Texture::target(rows, "forces on tools");
    targets_[turn] = Framebuffer({{&sums_[turn][0]}, {&sums_[turn][1]}, {&last_[0]}, {&last_[1]}});
  }
}

void FragmentTools::set_held(const FloatTools& tools) {
  held_.upload(std::span<const Float4>(tools.held()));
}

void FragmentTools::set_frames(const FloatTools& tools) {
  frames_.upload(tools.frames());
}

void FragmentTools::bind(Pass& pass) const {
  tables_.bind(pass);
  pass.input("tool_frames", frames_);
  pass.input("tool_held", held_);
  pass.set("tool_count", count_);
}

void FragmentTools::tell(Pass& pass) {
  pass.input("tool_forces", sums_[static_cast<std::size_t>(turn_)][0]);
  pass.input("tool_torques", sums_[static_cast<std::size_t>(turn_)][1]);
  turn_ = 1 - turn_;
  pass.set("particle_rows", particles_);
  pass.set_rows(last_[0], count_ * particles_);
  pass.draw(targets_[static_cast<std::size_t>(turn_)]);
}

void FragmentTools::sum(Pass& added) {
  const auto& newest = sums_[static_cast<std::size_t>(turn_)];
  const std::array<const Texture*, 4> source{&newest[0], &newest[1], &last_[0], &last_[1]};
  for (std::size_t k = 0; k < source.size(); ++k) added.input(sum_inputs[k], *source[k]);
  added_->draw(added);
}

void FragmentTools::copy(std::size_t offset) const {
  for (int k = 0; k < 4; ++k) {
    const std::size_t at = offset + static_cast<std::size_t>(k) * texels() * sizeof(Float4);
    added_->target().read(k, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(at));  // an offset in the buffer
  }
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#include "fragment_open_step.h"

namespace phymul::gl {

FragmentOpenStep::FragmentOpenStep(Index particles, const Texture& measured)
    : force_(Texture::target(particles, "forces before a step's motion")),
      velocity_(Texture::target(particles, "velocities before a step's motion")),
      withheld_(Texture::target(particles, "withheld forces")),
      target_({{&force_}, {&velocity_}, {&withheld_}, {&measured}}),
      asked_(Texture::target(particles, TexelFormat::rgba32i, "rows to gather")),
      gathered_{Texture::target(particles, "gathered displacements"), Texture::target(particles, "gathered velocities"),
                Texture::target(particles, "gathered forces")},
      gathered_target_({{&gathered_[0]}, {&gathered_[1]}, {&gathered_[2]}}),
      push_rows_(Texture::target(particles, TexelFormat::rgba32i, "rows that are pushed")),
      push_forces_(Texture::target(particles, "forces of the host")),
      push_shifts_(Texture::target(particles, "shifts of the host")) {
  const auto texels = static_cast<std::size_t>(gathered_target_.shape().texels());
  rows_.reserve(texels);
  texels_.resize(texels);
  more_texels_.reserve(texels);
}

void FragmentOpenStep::bind(Pass& pass) const {
  pass.input("pushed_force", force_);
  pass.input("free_velocity", velocity_);
  pass.input("pushed_shift", withheld_);
}

void FragmentOpenStep::bind_pushes(Pass& pass) const {
  pass.input("push_rows", push_rows_);
  pass.input("push_forces", push_forces_);
  pass.input("push_shifts", push_shifts_);
}

void FragmentOpenStep::set_gathered(std::span<const Index> rows) {
  asked_count_ = static_cast<int>(rows.size());
  rows_.clear();
  for (const Index row : rows) rows_.push_back({row, 0, 0, 0});
  if (!rows_.empty()) asked_.upload(std::span<const Int4>(rows_));
}

void FragmentOpenStep::gather(Pass& pass) const {
  if (asked_count_ == 0) return;
  pass.input("gather_rows", asked_);
  pass.set_rows(gathered_[0], asked_count_);
  pass.draw(gathered_target_);
}

void FragmentOpenStep::read(std::span<OpenRow> rows) {
  if (rows.empty()) return;
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  const auto take = [&](int k, Float4 OpenRow::*part) {
    gathered_target_.read(k, GL_RGBA, GL_FLOAT, texels_.data(), static_cast<std::int64_t>(rows.size()));
    for (std::size_t row = 0; row < rows.size(); ++row) rows[row].*part = texels_[row];
  };
  take(0, &OpenRow::displacement);
  take(1, &OpenRow::velocity);
  take(2, &OpenRow::withheld);
}

void FragmentOpenStep::set_pushes(std::span<const Push> pushes) {
  push_count_ = static_cast<int>(pushes.size());
  if (pushes.empty()) return;
  rows_.clear();
  for (const Push& push : pushes) rows_.push_back({push.particle, 0, 0, 0});
  push_rows_.upload(std::span<const Int4>(rows_));
  more_texels_.clear();
  for (const Push& push : pushes) more_texels_.push_back(push.force);
  push_forces_.upload(std::span<const Float4>(more_texels_));
  more_texels_.clear();
  for (const Push& push : pushes) more_texels_.push_back(push.shift);
  push_shifts_.upload(std::span<const Float4>(more_texels_));
}

}  // namespace phymul::gl

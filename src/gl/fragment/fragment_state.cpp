// SPDX-License-Identifier: MIT
#include "fragment_state.h"

namespace phymul::gl {

FragmentTables::FragmentTables(const FloatTables& tables) : kind_(tables), materials_(tables.domains.material) {
  const auto add = [this](const char* name, const auto& rows) {
    if (!rows.empty()) tables_.add(name, rows);
  };
  tables.for_each(add);
  const FloatEntries entries(tables);
  add("entries", entries.rows);
  volume_start_ = entries.volume_start;
  spring_start_ = entries.spring_start;
  wall_start_ = entries.wall_start;
}

void FragmentTables::bind(Pass& pass) const {
  tables_.bind(pass);
  pass.set("volume_start", volume_start_);
  pass.set("spring_start", spring_start_);
  pass.set("wall_start", wall_start_);
}

FragmentLayers::FragmentLayers(std::int64_t rows, int layers, const char* name) : layers_(layers) {
  for (int k = 0; k < StatePairs::pairs; ++k) {
    textures_[k] = Texture::target(rows, name, layers_);
    std::vector<Attachment> attachments;
    for (int layer = 0; layer < layers_; ++layer) attachments.push_back({&textures_[k], layer});
    targets_[k] = Framebuffer(attachments);
  }
}

void FragmentLayers::write(std::span<const Float4> rows, int pair) {
  std::vector<Float4> layer(static_cast<std::size_t>(textures_[pair].rows()));
  for (int k = 0; k < layers_; ++k) {
    for (std::size_t row = 0; row < layer.size(); ++row) layer[row] = rows[host_texels * row + k];
    textures_[pair].upload(std::span<const Float4>(layer), k);
  }
}

std::vector<Float4> FragmentLayers::read(int pair) const {
  const auto count = static_cast<std::size_t>(textures_[pair].rows());
  std::vector<Float4> rows(host_texels * count, Float4{});
  std::vector<Float4> layer(static_cast<std::size_t>(targets_[pair].shape().texels()));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  for (int k = 0; k < layers_; ++k) {
    targets_[pair].read(k, GL_RGBA, GL_FLOAT, layer.data());
    for (std::size_t row = 0; row < count; ++row) rows[host_texels * row + k] = layer[row];
  }
  return rows;
}

FragmentState::FragmentState(Index particles) : measured_(Texture::target(particles, "measured speeds and forces")) {
  for (int k = 0; k < pairs; ++k) {
    displacement_[k] = Texture::target(particles, "displacement");
    velocity_[k] = Texture::target(particles, "velocity");
    plain_[k] = Framebuffer({{&displacement_[k]}, {&velocity_[k]}});
    measuring_[k] = Framebuffer({{&displacement_[k]}, {&velocity_[k]}, {&measured_}});
  }
}

void FragmentState::read(const VecList& rest, State& state) const {
  const auto texels = static_cast<std::size_t>(framebuffer().shape().texels());
  std::vector<Float4> u(texels), v(texels);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  framebuffer().read(0, GL_RGBA, GL_FLOAT, u.data());
  framebuffer().read(1, GL_RGBA, GL_FLOAT, v.data());
  unpack_state(u.data(), v.data(), rest, {}, state);
}

void FragmentState::write(const VecList& rest, const State& state) {
  std::vector<Float4> u(rest.size(), Float4{}), v(rest.size(), Float4{});
  pack_state(rest, state, {}, u.data(), v.data());
  displacement_[current()].upload(std::span<const Float4>(u));
  velocity_[current()].upload(std::span<const Float4>(v));
  set_checkpoint();
  set_strains_fresh(true);
}

void FragmentState::request_copy(StateCopies& copies, const State& header) const {
  const auto texels = static_cast<std::size_t>(framebuffer().shape().texels());
  copies.request(texels, header, [&] {
    framebuffer().read(0, GL_RGBA, GL_FLOAT, nullptr);  // an offset in the buffer
    framebuffer().read(1, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(texels * sizeof(Float4)));
  });
}

}  // namespace phymul::gl

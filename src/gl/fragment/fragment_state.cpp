// SPDX-License-Identifier: MIT
#include "fragment_state.h"

namespace phymul::gl {

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

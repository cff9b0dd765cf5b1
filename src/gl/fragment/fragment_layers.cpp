// SPDX-License-Identifier: MIT
#include "fragment_layers.h"

namespace phymul::gl {

FragmentLayers::FragmentLayers(std::int64_t rows, int layers, const char* name) : layers_(layers) {
  for (int k = 0; k < FragmentState::pairs; ++k) {
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

}  // namespace phymul::gl

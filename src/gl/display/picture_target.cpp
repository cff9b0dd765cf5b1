// SPDX-License-Identifier: MIT
#include "picture_target.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <string>

namespace phymul::gl {
namespace {

constexpr int best_factor = 3;

/// The largest factor up to the best one that the driver has room for.
int factor_for(int width, int height) {
  if (width < 1 || height < 1) {
    throw Error("Display: expected a picture of at least 1 x 1 pixels, got " + std::to_string(width) + " x " +
                std::to_string(height));
  }
  std::array<GLint, 2> view{};
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, view.data());
  const GLint largest = std::min({integer_of(GL_MAX_RENDERBUFFER_SIZE), view[0], view[1]});
  const int factor = std::min(best_factor, largest / std::max(width, height));
  if (factor < 1) {
    throw Error("Display: a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels is larger than this driver draws, at most " + std::to_string(largest) + " a side");
  }
  return factor;
}

}  // namespace

PictureTarget::PictureTarget(int width, int height)
    : width_(width), height_(height), factor_(factor_for(width, height)) {
  forget_errors();
  glGenRenderbuffers(2, buffers_);
  const std::array<GLenum, 2> formats{GL_RGBA8, GL_DEPTH_COMPONENT24};
  for (std::size_t k = 0; k < formats.size(); ++k) {
    glBindRenderbuffer(GL_RENDERBUFFER, buffers_[k]);
    glRenderbufferStorage(GL_RENDERBUFFER, formats[k], width * factor_, height * factor_);
  }
  glBindRenderbuffer(GL_RENDERBUFFER, 0);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers_[0]);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers_[1]);
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
  release();
  throw Error(ErrorCode::out_of_memory, "Display: the driver has no room for a picture of " +
                                            std::to_string(width * factor_) + " x " + std::to_string(height * factor_) +
                                            " pixels, 8 bytes each; ask for a smaller one");
}

PictureTarget::~PictureTarget() {
  release();
}

void PictureTarget::release() noexcept {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
  glDeleteRenderbuffers(2, buffers_);
}

Image PictureTarget::read() const {
  const auto wide = static_cast<std::size_t>(width_ * factor_), high = static_cast<std::size_t>(height_ * factor_);
  std::vector<std::uint8_t> fine(4 * wide * high);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
  glReadPixels(0, 0, width_ * factor_, height_ * factor_, GL_RGBA, GL_UNSIGNED_BYTE, fine.data());

  Image image{width_, height_, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width_) * height_)};
  const auto factor = static_cast<std::size_t>(factor_);
  const unsigned samples = static_cast<unsigned>(factor * factor);
  std::uint8_t* out = image.rgba.data();
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y) {
    const std::size_t bottom = high - factor * (y + 1);  // GL counts rows from below
    for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
      std::array<unsigned, 4> sum{};
      for (std::size_t row = 0; row < factor; ++row) {
        const std::uint8_t* in = &fine[4 * ((bottom + row) * wide + factor * x)];
        for (std::size_t k = 0; k < 4 * factor; ++k) sum[k % 4] += in[k];
      }
      for (const unsigned channel : sum) *out++ = static_cast<std::uint8_t>((channel + samples / 2) / samples);
    }
  }
  return image;
}

}  // namespace phymul::gl

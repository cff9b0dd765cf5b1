// SPDX-License-Identifier: MIT
#include "texture.h"

#include <phymul/error.h>

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

namespace phymul::gl {
namespace {

struct FormatRow {
  GLenum internal, layout, type;
  int bytes;
};

const FormatRow& row_of(TexelFormat format) {
  static constexpr FormatRow rows[] = {
      {GL_R32I, GL_RED_INTEGER, GL_INT, 4},
      {GL_RG32I, GL_RG_INTEGER, GL_INT, 8},
      {GL_RGBA32I, GL_RGBA_INTEGER, GL_INT, 16},
      {GL_R32F, GL_RED, GL_FLOAT, 4},
      {GL_RG32F, GL_RG, GL_FLOAT, 8},
      {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16},
  };
  return rows[static_cast<int>(format)];
}

void require_allocated(const char* name, const TextureShape& shape, int layers, int bytes) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  const std::int64_t texels = shape.texels() * std::max(layers, 1);
  throw Error(ErrorCode::device,
              "the texture of " + std::string(name) + " could not be made: " + std::to_string(shape.width) + " x " +
                  std::to_string(shape.height) + (layers > 0 ? " x " + std::to_string(layers) : std::string()) +
                  " texels, " + std::to_string(texels * bytes) + " bytes; the driver says " + memory_error(error) +
                  ". Its largest texture has " + std::to_string(largest_side()) +
                  " texels a side. Use fewer particles or bases, or a device with more memory");
}

/// Rows of integers are padded by `none`, others by 0.
template <class Row>
std::vector<Row> padded(std::span<const Row> rows, const TextureShape& shape, const Row& padding) {
  std::vector<Row> all(static_cast<std::size_t>(shape.texels()), padding);
  std::copy(rows.begin(), rows.end(), all.begin());
  return all;
}

void keep_plain_unpacking() {
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glPixelStorei(GL_UNPACK_SKIP_ROWS, 0);
  glPixelStorei(GL_UNPACK_SKIP_PIXELS, 0);
}

}  // namespace

int largest_side() {
  return integer_of(GL_MAX_TEXTURE_SIZE);
}

Texture::Texture(std::int64_t rows, TexelFormat format, const char* name, int layers, const void* padded)
    : id_(one_name(glGenTextures)),
      shape_(fit_texture(rows, largest_side(), name)),
      rows_(rows),
      layers_(layers),
      format_(format),
      name_(name) {
  const FormatRow& row = row_of(format);
  forget_errors();
  keep_plain_unpacking();
  glBindTexture(kind(), *id_);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) {
    glTexParameteri(kind(), filter, GL_NEAREST);
  }
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) glTexParameteri(kind(), wrap, GL_CLAMP_TO_EDGE);
  glTexParameteri(kind(), GL_TEXTURE_MAX_LEVEL, 0);
  const auto internal = static_cast<GLint>(row.internal);
  if (layers > 0) {
    glTexImage3D(kind(), 0, internal, shape_.width, shape_.height, layers, 0, row.layout, row.type, padded);
  } else {
    glTexImage2D(kind(), 0, internal, shape_.width, shape_.height, 0, row.layout, row.type, padded);
  }
  glBindTexture(kind(), 0);
  require_allocated(name, shape_, layers, row.bytes);
}

int Texture::log2_width() const {
  return std::countr_zero(static_cast<unsigned>(shape_.width));
}

#define PHYMUL_TABLE(Row, FORMAT, ...)                                                                     \
  Texture Texture::table(std::span<const Row> rows, const char* name) {                                    \
    const auto count = static_cast<std::int64_t>(rows.size());                                             \
    const std::vector<Row> all = padded<Row>(rows, fit_texture(count, largest_side(), name), __VA_ARGS__); \
    return {count, TexelFormat::FORMAT, name, 0, all.data()};                                              \
  }
PHYMUL_TABLE(std::int32_t, r32i, none)
PHYMUL_TABLE(Int2, rg32i, Int2{none, none})
PHYMUL_TABLE(Int4, rgba32i, Int4{none, none, none, none})
PHYMUL_TABLE(float, r32f, 0.0f)
PHYMUL_TABLE(Float2, rg32f, Float2{})
PHYMUL_TABLE(Float4, rgba32f, Float4{})
#undef PHYMUL_TABLE

void Texture::upload(std::span<const Float4> rows, int layer) {
  keep_plain_unpacking();
  upload_rows(rows.data(), static_cast<std::int64_t>(rows.size()), sizeof(Float4), layer);
}

void Texture::upload(std::span<const float> rows) {
  keep_plain_unpacking();
  upload_rows(rows.data(), static_cast<std::int64_t>(rows.size()), sizeof(float));
}

void Texture::upload(std::span<const Int4> rows) {
  keep_plain_unpacking();
  upload_rows(rows.data(), static_cast<std::int64_t>(rows.size()), sizeof(Int4));
}

void Texture::upload_from(GLuint buffer, std::int64_t first) {
  keep_plain_unpacking();
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer);
  upload_rows(reinterpret_cast<const void*>(static_cast<std::uintptr_t>(first) * sizeof(Float4)), rows_,
              sizeof(Float4));
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

void Texture::upload_rows(const void* data, std::int64_t count, std::size_t bytes, int layer) {
  const FormatRow& row = row_of(format_);
  const auto whole = static_cast<GLsizei>(count / shape_.width), rest = static_cast<GLsizei>(count % shape_.width);
  const auto send = [&](GLint line, GLsizei width, GLsizei lines, const void* texels) {
    if (layers_ > 0) {
      glTexSubImage3D(kind(), 0, 0, line, layer, width, lines, 1, row.layout, row.type, texels);
    } else {
      glTexSubImage2D(kind(), 0, 0, line, width, lines, row.layout, row.type, texels);
    }
  };
  glBindTexture(kind(), *id_);
  if (whole > 0) send(0, shape_.width, whole, data);
  const auto* last = static_cast<const char*>(data) + static_cast<std::size_t>(whole) * shape_.width * bytes;
  if (rest > 0) send(whole, rest, 1, last);
  glBindTexture(kind(), 0);
}

Framebuffer::Framebuffer(const std::vector<Attachment>& attachments) : id_(one_name(glGenFramebuffers)) {
  glBindFramebuffer(GL_FRAMEBUFFER, *id_);
  std::vector<GLenum> buffers;
  std::string names;
  for (const Attachment& attachment : attachments) {
    const auto point = static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + buffers.size());
    buffers.push_back(attachment.texture ? point : GL_NONE);
    if (!attachment.texture) continue;
    shape_ = attachment.texture->shape();
    names += std::string(names.empty() ? "" : ", ") + attachment.texture->name();
    const GLuint texture = attachment.texture->id();
    if (attachment.texture->kind() == GL_TEXTURE_2D_ARRAY) {
      glFramebufferTextureLayer(GL_FRAMEBUFFER, point, texture, 0, attachment.layer);
    } else {
      glFramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, texture, 0);
    }
  }
  glDrawBuffers(static_cast<GLsizei>(buffers.size()), buffers.data());
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status == GL_FRAMEBUFFER_COMPLETE) return;
  throw Error(ErrorCode::device, "this driver cannot draw into the textures of " + names + " (framebuffer status " +
                                     std::to_string(status) +
                                     "); it needs float and integer textures of 32 bits as colour targets, which " +
                                     "GL 3.3 and OpenGL ES 3.0 with GL_EXT_color_buffer_float have");
}

void Framebuffer::read(int k, GLenum layout, GLenum type, void* out, std::int64_t rows) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, *id_);
  glReadBuffer(static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + k));
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
  glPixelStorei(GL_PACK_SKIP_ROWS, 0);
  glPixelStorei(GL_PACK_SKIP_PIXELS, 0);
  const auto lines = static_cast<GLsizei>((rows + shape_.width - 1) / shape_.width);
  glReadPixels(0, 0, shape_.width, lines, layout, type, out);
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
//
// Texture: owns one GL texture, a table of constants or a target of passes. Lives and dies in a current context.
#pragma once

#include "gl/context/gl_api.h"

#include <phymul/topology_textures.h>

#include <cstdint>
#include <span>
#include <vector>

#include "device/table_rows.h"
#include "handle.h"

namespace phymul::gl {

enum class TexelFormat { r32i, rg32i, rgba32i, r32f, rg32f, rgba32f };

class Texture {
 public:
  Texture() = default;

  /// A table of one row a texel: row r is texel (r mod width, r / width). What is beyond the rows holds `none` in
  /// integer tables and 0 in the others. Throws Error when the rows do not fit the context's limits or its memory.
  static Texture table(std::span<const std::int32_t> rows, const char* name);
  static Texture table(std::span<const Int2> rows, const char* name);
  static Texture table(std::span<const Int4> rows, const char* name);
  static Texture table(std::span<const float> rows, const char* name);
  static Texture table(std::span<const Float2> rows, const char* name);
  static Texture table(std::span<const Float4> rows, const char* name);

  /// Something to draw into, of undefined content; with layers > 0 an array of as many rectangles.
  static Texture target(std::int64_t rows, TexelFormat format, const char* name, int layers = 0) {
    return {rows, format, name, layers, nullptr};
  }
  static Texture target(std::int64_t rows, const char* name, int layers = 0) {  ///< of TexelFormat::rgba32f
    return target(rows, TexelFormat::rgba32f, name, layers);
  }

  /// Writes over the first rows, of an array those of a layer; no more than there are.
  void upload(std::span<const Float4> rows, int layer = 0);
  void upload(std::span<const float> rows);
  void upload(std::span<const Int4> rows);
  /// All rows, of 16 bytes, from a buffer's row `first` on, without the host.
  void upload_from(GLuint buffer, std::int64_t first);

  explicit operator bool() const { return static_cast<bool>(id_); }
  GLuint id() const { return *id_; }
  GLenum kind() const { return layers_ > 0 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D; }
  TextureShape shape() const { return shape_; }
  int log2_width() const;
  std::int64_t rows() const { return rows_; }
  const char* name() const { return name_; }

 private:
  Texture(std::int64_t rows, TexelFormat format, const char* name, int layers, const void* padded);
  void upload_rows(const void* data, std::int64_t count, std::size_t bytes, int layer = 0);

  Handle<TextureKind> id_;
  TextureShape shape_;
  std::int64_t rows_ = 0;
  int layers_ = 0;
  TexelFormat format_ = TexelFormat::rgba32f;
  const char* name_ = "";
};

/// The context's own limit of a side, texels.
int largest_side();

struct Attachment {
  const Texture* texture = nullptr;  ///< nullptr: what the shader writes here is dropped
  int layer = 0;                     ///< of an array
};

/// The textures a pass draws into, and the way back from them.
class Framebuffer {
 public:
  Framebuffer() = default;
  /// Attachment k takes what the shader writes at location k; all have one shape. Throws Error when the driver cannot
  /// draw into them.
  explicit Framebuffer(const std::vector<Attachment>& attachments);

  GLuint id() const { return *id_; }
  TextureShape shape() const { return shape_; }

  /// Copies attachment k's texels of the first rows, in order, to `out`; at most to whole lines of texels, so `out`
  /// has room for shape().texels(). Waits for the device unless `out` is an offset in a bound GL_PIXEL_PACK_BUFFER.
  void read(int k, GLenum layout, GLenum type, void* out) const { read(k, layout, type, out, shape_.texels()); }
  /// Only of as many rows, again to whole lines of texels.
  void read(int k, GLenum layout, GLenum type, void* out, std::int64_t rows) const;

 private:
  Handle<FramebufferKind> id_;
  TextureShape shape_;
};

}  // namespace phymul::gl

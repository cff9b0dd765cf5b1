// SPDX-License-Identifier: MIT
//
// Framebuffer: the textures a pass draws into, and the way back from them.
#pragma once

#include "gl/context/gl_api.h"

#include <vector>

#include "handle.h"
#include "texture.h"

namespace phymul::gl {

struct Attachment {
  const Texture* texture = nullptr;  ///< nullptr: what the shader writes here is dropped
  int layer = 0;                     ///< of an array
};

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

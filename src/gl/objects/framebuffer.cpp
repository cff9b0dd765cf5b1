// SPDX-License-Identifier: MIT
#include "framebuffer.h"

#include <phymul/error.h>

#include <string>

namespace phymul::gl {

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

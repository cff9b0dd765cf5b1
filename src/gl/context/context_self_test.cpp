// SPDX-License-Identifier: MIT
#include <phymul/error.h>

#include <array>

#include "context_info.h"
#include "gl_api.h"
#include "gl_functions.h"

namespace phymul::gl {
namespace {

constexpr const char* vertex_source = R"(
void main() {
  gl_Position = vec4(4.0 * float(gl_VertexID == 1) - 1.0, 4.0 * float(gl_VertexID == 2) - 1.0, 0.0, 1.0);
}
)";
constexpr const char* fragment_source = R"(
uniform highp vec4 value;
layout(location = 0) out highp vec4 texel;
void main() {
  texel = value;
}
)";

/// No clamping to [0, 1], no half precision: all exact in float, the second in nothing shorter.
constexpr std::array<float, 4> written{-2.0f, 16777213.0f, 1e-30f, 3e30f};

GLuint compile(const ContextInfo& info, GLenum kind, const char* body) {
  const char* const parts[] = {info.es ? "#version 300 es\n" : "#version 330 core\n", body};
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 2, parts, nullptr);
  glCompileShader(shader);
  return shader;
}

/// The objects of the test, gone at its end.
struct Texel {
  GLuint texture = 0, framebuffer = 0, vertex_array = 0, program = 0;

  explicit Texel(const ContextInfo& info) {
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 1, 1, 0, GL_RGBA, GL_FLOAT, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    glGenVertexArrays(1, &vertex_array);
    glBindVertexArray(vertex_array);
    program = glCreateProgram();
    for (const auto& [kind, body] :
         {std::pair{GL_VERTEX_SHADER, vertex_source}, {GL_FRAGMENT_SHADER, fragment_source}}) {
      const GLuint shader = compile(info, static_cast<GLenum>(kind), body);
      glAttachShader(program, shader);
      glDeleteShader(shader);
    }
    glLinkProgram(program);
  }
  ~Texel() {
    glUseProgram(0);
    glBindVertexArray(0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glBindTexture(GL_TEXTURE_2D, 0);
    glDeleteProgram(program);
    glDeleteVertexArrays(1, &vertex_array);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);
  }
  Texel(const Texel&) = delete;
  Texel& operator=(const Texel&) = delete;
};

void require_linked(const ContextInfo& info, GLuint program) {
  GLint linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked) return;
  std::array<char, 1024> log{};
  glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw Error(ErrorCode::device, info.device() + " does not take the shader of the self-test: " + log.data());
}

}  // namespace

void self_test(const ContextInfo& info) {
  const Texel texel(info);
  const GLenum complete = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (complete != GL_FRAMEBUFFER_COMPLETE) {
    throw Error(ErrorCode::device, info.device() +
                                       " cannot draw into an RGBA32F texture: the framebuffer is incomplete, status " +
                                       std::to_string(complete));
  }
  require_linked(info, texel.program);
  glUseProgram(texel.program);
  glUniform4fv(glGetUniformLocation(texel.program, "value"), 1, written.data());
  glViewport(0, 0, 1, 1);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::array<float, 4> read{};
  glReadPixels(0, 0, 1, 1, GL_RGBA, GL_FLOAT, read.data());
  const GLenum error = glGetError();
  if (error != GL_NO_ERROR) {
    throw Error(ErrorCode::device,
                info.device() + " failed the self-test, one texel drawn and read: " + gl_error_name(error));
  }
  if (read != written) {
    throw Error(ErrorCode::device,
                info.device() + " failed the self-test: an RGBA32F texel reads otherwise than it was drawn");
  }
}

}  // namespace phymul::gl

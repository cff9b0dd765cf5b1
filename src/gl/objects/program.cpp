// SPDX-License-Identifier: MIT
#include "program.h"

#include <phymul/error.h>

#include <utility>

namespace phymul::gl {
namespace {

std::string renderer() {
  const std::string text = gl_text(GL_RENDERER);
  return text.empty() ? "an unnamed renderer" : text;
}

std::string name_of_last(const ShaderRequest& request) {
  return request.files.empty() ? std::string() : request.files.back();
}

/// The driver's log of a shader or a program, by its glGet...iv and glGet...InfoLog.
template <class GetNumber, class GetLog>
std::string log_of(GLuint name, GetNumber get_number, GetLog get_log) {
  GLint length = 0;
  get_number(name, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  if (length > 0) get_log(name, length, nullptr, log.data());
  return log.c_str();  // up to its end, which the length counts too
}

/// Needed until the program has it.
Handle<ShaderKind> compiled(GLenum stage, const ShaderLibrary& library, const ShaderRequest& request) {
  Handle<ShaderKind> shader(glCreateShader(stage));
  const std::string text = library.text(request, stage == GL_COMPUTE_SHADER ? Stage::compute : Stage::drawing);
  const char* start = text.c_str();
  glShaderSource(*shader, 1, &start, nullptr);
  glCompileShader(*shader);
  GLint good = GL_FALSE;
  glGetShaderiv(*shader, GL_COMPILE_STATUS, &good);
  if (good == GL_TRUE) return shader;
  const char* kind = stage == GL_VERTEX_SHADER ? "vertex" : stage == GL_COMPUTE_SHADER ? "compute" : "fragment";
  throw Error(ErrorCode::device,
              std::string(kind) + " shader " + name_of_last(request) + " does not compile on " + renderer() + ":\n" +
                  ShaderLibrary::readable(log_of(*shader, glGetShaderiv, glGetShaderInfoLog), request));
}

}  // namespace

void Program::link(std::initializer_list<GLuint> shaders, const ShaderRequest& named) {
  Handle<ProgramKind> program(glCreateProgram());
  for (const GLuint shader : shaders) glAttachShader(*program, shader);
  glLinkProgram(*program);
  GLint good = GL_FALSE;
  glGetProgramiv(*program, GL_LINK_STATUS, &good);
  if (good != GL_TRUE) {
    throw Error(ErrorCode::device,
                "the program of " + name_of_last(named) + " does not link on " + renderer() + ":\n" +
                    ShaderLibrary::readable(log_of(*program, glGetProgramiv, glGetProgramInfoLog), named));
  }
  id_ = std::move(program);
}

Program::Program(const ShaderLibrary& library, const ShaderRequest& vertex, const ShaderRequest& fragment) {
  const auto corners = compiled(GL_VERTEX_SHADER, library, vertex);
  const auto body = compiled(GL_FRAGMENT_SHADER, library, fragment);
  link({*corners, *body}, fragment);
}

Program Program::computing(const ShaderLibrary& library, const ShaderRequest& request) {
  const auto shader = compiled(GL_COMPUTE_SHADER, library, request);
  Program program;
  program.link({*shader}, request);
  return program;
}

GLint Program::use_uniform(const char* name) {
  glUseProgram(*id_);
  for (const Uniform& known : uniforms_) {
    if (known.name == name) return known.location;
  }
  uniforms_.push_back({name, uniform(name)});
  return uniforms_.back().location;
}

}  // namespace phymul::gl

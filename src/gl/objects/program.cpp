// SPDX-License-Identifier: MIT
#include "program.h"

#include <phymul/error.h>

#include <utility>

namespace phymul::gl {
namespace {

std::string renderer() {
  const auto* text = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return text ? text : "an unnamed renderer";
}

std::string name_of_last(const ShaderRequest& request) {
  return request.files.empty() ? std::string() : request.files.back();
}

/// Owns a shader object until the program has it.
class Shader {
 public:
  Shader(GLenum stage, const ShaderLibrary& library, const ShaderRequest& request) : id_(glCreateShader(stage)) {
    const std::string text = library.text(request, stage == GL_COMPUTE_SHADER ? Stage::compute : Stage::drawing);
    const char* start = text.c_str();
    glShaderSource(id_, 1, &start, nullptr);
    glCompileShader(id_);
    GLint good = GL_FALSE, length = 0;
    glGetShaderiv(id_, GL_COMPILE_STATUS, &good);
    if (good == GL_TRUE) return;
    glGetShaderiv(id_, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(length), '\0');
    if (length > 0) glGetShaderInfoLog(id_, length, nullptr, log.data());
    log = log.c_str();
    glDeleteShader(id_);
    const char* kind = stage == GL_VERTEX_SHADER ? "vertex" : stage == GL_COMPUTE_SHADER ? "compute" : "fragment";
    throw Error(ErrorCode::device, std::string(kind) + " shader " + name_of_last(request) + " does not compile on " +
                                       renderer() + ":\n" + ShaderLibrary::readable(log, request));
  }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
  ~Shader() { glDeleteShader(id_); }
  GLuint id() const { return id_; }

 private:
  GLuint id_;
};

}  // namespace

void Program::link(const ShaderRequest& named) {
  glLinkProgram(id_);
  GLint good = GL_FALSE, length = 0;
  glGetProgramiv(id_, GL_LINK_STATUS, &good);
  if (good == GL_TRUE) return;
  glGetProgramiv(id_, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  if (length > 0) glGetProgramInfoLog(id_, length, nullptr, log.data());
  log = log.c_str();
  glDeleteProgram(id_);
  id_ = 0;
  throw Error(ErrorCode::device, "the program of " + name_of_last(named) + " does not link on " + renderer() + ":\n" +
                                     ShaderLibrary::readable(log, named));
}

Program::Program(const ShaderLibrary& library, const ShaderRequest& vertex, const ShaderRequest& fragment) {
  const Shader corners(GL_VERTEX_SHADER, library, vertex);
  const Shader body(GL_FRAGMENT_SHADER, library, fragment);
  id_ = glCreateProgram();
  glAttachShader(id_, corners.id());
  glAttachShader(id_, body.id());
  link(fragment);
}

Program Program::computing(const ShaderLibrary& library, const ShaderRequest& request) {
  const Shader shader(GL_COMPUTE_SHADER, library, request);
  Program program;
  program.id_ = glCreateProgram();
  glAttachShader(program.id_, shader.id());
  program.link(request);
  return program;
}

GLint Program::known_uniform(const char* name) {
  for (const Uniform& known : uniforms_) {
    if (known.name == name) return known.location;
  }
  uniforms_.push_back({name, uniform(name)});
  return uniforms_.back().location;
}

Program::Program(Program&& other) noexcept {
  *this = std::move(other);
}

Program& Program::operator=(Program&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(uniforms_, other.uniforms_);
  return *this;
}

Program::~Program() {
  if (id_ != 0) glDeleteProgram(id_);
}

}  // namespace phymul::gl

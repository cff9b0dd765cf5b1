// SPDX-License-Identifier: MIT
//
// Drawing: a program that draws triangles out of tables in textures, without vertex attributes.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "gl/objects/program.h"
#include "gl/objects/texture.h"

namespace phymul::gl {

/// A texture by name, which a solver may own; rows as in Texture::table.
struct TextureView {
  GLuint id = 0;
  int log2_width = 0;
};

inline TextureView view_of(const Texture& texture) {
  return {texture.id(), texture.log2_width()};
}

class Drawing {
 public:
  Drawing() = default;
  Drawing(const ShaderLibrary& library, const ShaderRequest& vertex, const ShaderRequest& fragment)
      : program_(library, vertex, fragment) {}

  explicit operator bool() const { return program_.id() != 0; }

  /// Before set, input and draw.
  void use();

  void set(const char* name, int value) { glUniform1i(program_.uniform(name), value); }
  void set(const char* name, float value) { glUniform1f(program_.uniform(name), value); }
  void set(const char* name, const Eigen::Vector2f& value) { glUniform2fv(program_.uniform(name), 1, value.data()); }
  void set(const char* name, const Eigen::Vector3f& value) { glUniform3fv(program_.uniform(name), 1, value.data()); }
  void set(const char* name, const Eigen::Vector4f& value) { glUniform4fv(program_.uniform(name), 1, value.data()); }
  void set(const char* name, const Eigen::Matrix4f& value) {
    glUniformMatrix4fv(program_.uniform(name), 1, GL_FALSE, value.data());
  }
  void set(const char* name, const std::vector<Eigen::Vector3f>& values) {
    glUniform3fv(program_.uniform(name), static_cast<GLsizei>(values.size()), values.front().data());
  }

  /// The texture behind sampler `name`, and `name`_log2 that finds a row in it.
  void input(const std::string& name, const TextureView& texture);

  /// `count` things of six vertices each: two triangles. A vertex array must be bound.
  void draw(std::size_t count);

 private:
  Program program_;
  int units_ = 0;  // bound since use()
};

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
//
// Pass: a program with the textures it reads, ready to be drawn over a target.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "program.h"
#include "texture.h"

namespace phymul::gl {

class Pass {
 public:
  Pass() = default;
  Pass(const ShaderLibrary& library, const ShaderRequest& request);

  /// The texture behind sampler `name`, and the uniform `name`_place that finds a row in it. Stays until the next call;
  /// one the shader does not use is passed over. Throws Error above StateGuard::texture_units of them.
  void input(const char* name, const Texture& texture);

  /// For uniforms, which stay too. Makes the program current.
  void set(const char* name, int value) { glUniform1i(program_.use_uniform(name), value); }
  void set(const char* name, float value) { glUniform1f(program_.use_uniform(name), value); }
  void set(const char* name, const Float4& xyz) {  ///< a vec3: the first three
    glUniform3f(program_.use_uniform(name), xyz[0], xyz[1], xyz[2]);
  }

  /// The rectangle that will be drawn over, and how many of its rows mean something.
  void set_rows(const Texture& target, int rows);

  /// One fragment per texel of the target's lines that hold such rows. A vertex array must be bound.
  void draw(const Framebuffer& target);

 private:
  struct Input {
    std::string name;
    GLuint texture;
    GLenum kind;
    int log2_width;
    GLint place_location;
  };
  int lines_ = 0;     // of the rectangle, that hold its rows
  std::string name_;  // of its last shader file, without the ending
  Program program_;
  std::vector<Input> inputs_;  // at texture units 0, 1, ...
  std::vector<std::string> unused_;
};

/// Constant tables in textures, each under the name by which passes read it.
class NamedTables {
 public:
  template <class Row>
  void add(const char* name, const std::vector<Row>& rows) {
    tables_.push_back(Texture::table(std::span<const Row>(rows), name));
  }
  void bind(Pass& pass) const {
    for (const Texture& table : tables_) pass.input(table.name(), table);
  }

 private:
  std::vector<Texture> tables_;
};

/// What a draw without vertices needs in a core profile. Made and deleted in the context.
class EmptyVertexArray {
 public:
  void bind() const { glBindVertexArray(*id_); }

 private:
  Handle<VertexArrayKind> id_{one_name(glGenVertexArrays)};
};

}  // namespace phymul::gl

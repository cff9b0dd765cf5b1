// SPDX-License-Identifier: MIT
//
// Pass: a program with the textures it reads, ready to be drawn over a target. PassTimer: what each pass of a step
// costs, by timer queries of the device (GL_TIME_ELAPSED, in OpenGL ES EXT_disjoint_timer_query) and by the clock of
// the thread that hands the passes over.
#pragma once

#include <deque>
#include <span>
#include <string>
#include <vector>

#include "gl/context/context_info.h"
#include "gl/context/gl_api.h"
#include "program.h"
#include "solver/profile.h"
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

/// Made, used and deleted in its context. Nothing in a loop of passes waits for a result: queries are as many as are on
/// their way, and are looked at once in a few hundred passes.
class PassTimer {
 public:
  PassTimer(const ContextInfo& info, Profile& profile);
  PassTimer(const PassTimer&) = delete;
  PassTimer& operator=(const PassTimer&) = delete;
  ~PassTimer();

  /// Waits for what is on its way, and adds it to the profile.
  void finish() { collect(true); }

  /// While it lives, the passes that this thread draws are timed; null: they are not.
  class Current {
   public:
    explicit Current(PassTimer* timer) : before_(current_) { current_ = timer; }
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
    ~Current() { current_ = before_; }

   private:
    PassTimer* before_;
  };

  enum class Work { draw, dispatch };
  /// One of either, from here to its end. Without a current timer it asks no clock and calls no GL. They do not
  /// nest, as queries must not.
  class Timed {
   public:
    Timed(const std::string& pass, Work work) : timer_(current_) {
      if (timer_) timer_->begin(pass, work);
    }
    Timed(const Timed&) = delete;
    Timed& operator=(const Timed&) = delete;
    ~Timed() {
      if (timer_) timer_->end();
    }

   private:
    PassTimer* timer_;
  };

 private:
  struct Pending {
    GLuint query;
    int row;
  };
  void begin(const std::string& pass, Work work);
  void end();
  void collect(bool wait);
  bool was_disturbed() const;

  static thread_local PassTimer* current_;

  Profile& profile_;
  bool es_, has_queries_ = false, times_dispatches_;
  void(GLAPIENTRY* get_result_)(GLuint, GLenum, GLuint64*) = nullptr;
  std::vector<GLuint> idle_;
  std::deque<Pending> pending_;  // oldest first
  int row_ = 0;                  // of the pass that runs
  GLuint query_ = 0;             // likewise; 0: not timed
  unsigned passes_ = 0;
  Laps laps_{nullptr};
};

}  // namespace phymul::gl

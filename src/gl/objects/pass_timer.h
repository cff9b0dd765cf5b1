// SPDX-License-Identifier: MIT
//
// PassTimer: what each pass of a step costs, by timer queries of the device (GL_TIME_ELAPSED, in OpenGL ES
// EXT_disjoint_timer_query) and by the clock of the thread that hands the passes over.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "gl/context/context_info.h"
#include "solver/profile.h"

#include "gl/context/gl_api.h"

namespace phymul::gl {

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

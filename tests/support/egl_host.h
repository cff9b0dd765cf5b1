// SPDX-License-Identifier: MIT
//
// A host of the tests: a program that has a context of its own through EGL before it makes a solver.
#pragma once

#include <phymul/error.h>

#include <array>
#include <vector>

#include "gl/context/egl_display.h"
#include "gl/context/gl_functions.h"

namespace phymul::test {

enum class HostKind { desktop, compatibility, es };

class EglHost {
 public:
  /// Current on this thread, on two surfaces; throws Error where EGL has no such context.
  explicit EglHost(HostKind kind) : kind_(kind), display_(gl::display_choices("surfaceless").front().display) {
    gl::initialise(display_);
    eglBindAPI(api());
    const std::array<EGLint, 5> wish{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                     is_es() ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    eglChooseConfig(display_, wish.data(), &config, 1, &count);
    const std::array<EGLint, 5> size{EGL_WIDTH, 16, EGL_HEIGHT, 8, EGL_NONE};
    draw_ = eglCreatePbufferSurface(display_, config, size.data());
    read_ = eglCreatePbufferSurface(display_, config, size.data());
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes().data());
    if (context_ == EGL_NO_CONTEXT) throw Error("the host gets no context: " + gl::egl_error_name(eglGetError()));
    make_current();
    gl::load_functions();
  }
  ~EglHost() {
    put_away();
    eglDestroyContext(display_, context_);
    eglDestroySurface(display_, draw_);
    eglDestroySurface(display_, read_);
    eglBindAPI(EGL_OPENGL_ES_API);
  }
  EglHost(const EglHost&) = delete;
  EglHost& operator=(const EglHost&) = delete;

  void make_current() {
    if (!eglMakeCurrent(display_, draw_, read_, context_)) throw Error(gl::egl_error_name(eglGetError()));
  }
  void put_away() { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

  bool is_es() const { return kind_ == HostKind::es; }
  EGLenum api() const { return is_es() ? EGL_OPENGL_ES_API : EGL_OPENGL_API; }
  EGLDisplay display() const { return display_; }
  EGLContext context() const { return context_; }

 private:
  std::vector<EGLint> attributes() const {
    if (is_es()) return {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    return {
        EGL_CONTEXT_MAJOR_VERSION,
        3,
        EGL_CONTEXT_MINOR_VERSION,
        3,
        EGL_CONTEXT_OPENGL_PROFILE_MASK,
        kind_ == HostKind::desktop ? EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT : EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT,
        EGL_NONE};
  }

  HostKind kind_;
  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface draw_ = EGL_NO_SURFACE, read_ = EGL_NO_SURFACE;
};

/// What EGL has bound to this thread.
struct EglBindings {
  EGLenum api = eglQueryAPI();
  EGLContext context = eglGetCurrentContext();
  EGLDisplay display = eglGetCurrentDisplay();
  EGLSurface draw = eglGetCurrentSurface(EGL_DRAW), read = eglGetCurrentSurface(EGL_READ);
  bool operator==(const EglBindings&) const = default;
};

}  // namespace phymul::test

// SPDX-License-Identifier: MIT
#include "context_current.h"

#include <dlfcn.h>
#include <phymul/error.h>

#include "gl_functions.h"
#include "guard_state.h"

namespace phymul::gl {
namespace {

/// glXGetCurrentContext of a process that uses GLX; null in others. A host that does has loaded one of these.
void* glx_context() {
  using Query = void* (*)();
  static const Query query = [] {
    for (const char* library : {"libGLX.so.0", "libGL.so.1"}) {
      void* const loaded = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
      if (!loaded) continue;
      if (void* const symbol = dlsym(loaded, "glXGetCurrentContext")) return reinterpret_cast<Query>(symbol);
      dlclose(loaded);
    }
    return Query{};
  }();
  return query ? query() : nullptr;
}

void* current_handle() {
  const EGLContext context = eglGetCurrentContext();
  return context != EGL_NO_CONTEXT ? context : glx_context();
}

}  // namespace

CurrentContext::CurrentContext(GlBackend backend) : handle_(current_handle()) {
  if (!handle_) {
    throw Error(
        ErrorCode::device,
        "GlContext::current: no context of EGL or GLX is current on this thread; make the host's current first");
  }
  load_functions();
  info_ = read_context_info();
  require_backend(info_, backend);
  info_.display = "the host's context";
}

void CurrentContext::call(Task task, void* argument) {
  if (inside_) return task(argument);
  if (current_handle() != handle_) {
    throw Unreachable(
        "GlContext::current: the context that was current when the solver was made is not current on this thread now; "
        "make it current before every call");
  }
  struct Inside {
    bool& flag;
    explicit Inside(bool& f) : flag(f) { flag = true; }
    ~Inside() { flag = false; }
  };
  const StateGuard guard(info_);
  const Inside inside(inside_);
  task(argument);
}

}  // namespace phymul::gl

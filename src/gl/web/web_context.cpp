// SPDX-License-Identifier: MIT
#include "web_context.h"

#include <emscripten/em_js.h>
#include <phymul/error.h>

#include "gl/context/gl_functions.h"
#include "gl/context/guard_state.h"
#include "gl/solver/device.h"

// A context on a canvas that is no part of the page; 0 where the browser has no WebGL 2.
EM_JS(int, phymul_own_webgl, (), {
  const attributes = ({majorVersion : 2, minorVersion : 0, alpha : false, antialias : false, depth : false});
  const canvas = typeof OffscreenCanvas != "undefined" ? new OffscreenCanvas(1, 1) : document.createElement("canvas");
  return GL.createContext(canvas, Object.assign(attributes, {enableExtensionsByDefault : true}));
});

// Gives back what it holds at once: browsers keep few contexts, and collect those that nobody uses when they like.
EM_JS(void, phymul_lose_webgl, (int handle), {
  const extension = GL.getContext(handle).GLctx.getExtension("WEBGL_lose_context");
  if (extension) extension.loseContext();
});

namespace phymul::gl {

void load_functions() {
  // Emscripten asks for all extensions but those whose names have "debug" in them.
  emscripten_webgl_enable_extension(emscripten_webgl_get_current_context(), "WEBGL_debug_renderer_info");
}

std::unique_ptr<Device> make_compute_device(FloatTables, const TopologyTextures&, const Scene&, const FloatTools&, bool,
                                            const ShaderLibrary&, std::vector<Index>&) {
  throw Error(ErrorCode::not_supported, "WebGL 2 has no compute shaders; the backend \"gl\" needs none");
}

std::shared_ptr<Context> Context::open(const GlOptions& options, GlBackend backend) {
  return WebContext::open(options, backend);
}

std::shared_ptr<WebContext> WebContext::open(const GlOptions& options, GlBackend backend) {
  const std::shared_ptr<WebContext> made(new WebContext);  // whose constructor is private
  made->is_own_ = options.context == GlContext::own;
  const EMSCRIPTEN_WEBGL_CONTEXT_HANDLE before = emscripten_webgl_get_current_context();
  made->handle_ = made->is_own_ ? phymul_own_webgl() : before;
  if (made->handle_ == 0) {
    throw Error(ErrorCode::device, made->is_own_ ? "this browser gives no WebGL 2 context"
                                                 : "GlContext::current: no WebGL context is current; make one by "
                                                   "emscripten_webgl_create_context() and make it current first");
  }
  emscripten_webgl_make_context_current(made->handle_);
  try {
    load_functions();
    made->info_ = read_context_info();
    require_backend(made->info_, backend);
  } catch (...) {
    emscripten_webgl_make_context_current(before);
    throw;
  }
  made->info_.display = made->is_own_ ? "a canvas of its own" : "the page's context";
  emscripten_webgl_make_context_current(before);
  return made;
}

WebContext::~WebContext() {
  if (!is_own_ || handle_ == 0) return;
  phymul_lose_webgl(handle_);
  emscripten_webgl_destroy_context(handle_);
}

void WebContext::require_there() {
  if (!emscripten_is_webgl_context_lost(handle_)) return;
  mark_lost();
  throw Error(ErrorCode::device, "the browser has taken the WebGL context away");
}

void WebContext::call(Task task, void* argument) {
  if (inside_) return task(argument);
  const EMSCRIPTEN_WEBGL_CONTEXT_HANDLE before = emscripten_webgl_get_current_context();
  if (!is_own_ && before != handle_) {
    throw Unreachable(
        "GlContext::current: the context that was current when the solver was made is not current now; make it "
        "current before every call");
  }
  require_there();
  struct Inside {
    bool& flag;
    EMSCRIPTEN_WEBGL_CONTEXT_HANDLE before;
    Inside(bool& f, EMSCRIPTEN_WEBGL_CONTEXT_HANDLE now, EMSCRIPTEN_WEBGL_CONTEXT_HANDLE then) : flag(f), before(then) {
      emscripten_webgl_make_context_current(now);
      flag = true;
    }
    ~Inside() {
      flag = false;
      emscripten_webgl_make_context_current(before);
    }
  };
  const Inside inside(inside_, handle_, before);
  if (is_own_) return task(argument);
  const StateGuard guard(info_);
  task(argument);
}

}  // namespace phymul::gl

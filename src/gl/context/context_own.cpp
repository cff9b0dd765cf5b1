// SPDX-License-Identifier: MIT
#include "context_own.h"

#include <phymul/error.h>

#include <dlfcn.h>
#include <array>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include "context_info.h"
#include "egl_display.h"
#include "gl_functions.h"
#include "guard_state.h"

namespace phymul::gl {
namespace {

/// GlContext::current: the context that is current when this is made, EGL's or GLX's, and must be at every call.
class CurrentContext : public Context {
 public:
  explicit CurrentContext(GlBackend backend);

 private:
  void call(Task task, void* argument) override;

  void* handle_ = nullptr;  ///< which context
  bool inside_ = false;     ///< a call is running
};

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

constexpr int most_messages = 10;

void GLAPIENTRY receive(GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* text, const void* log) noexcept {
  if (type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) return;
  static_cast<DebugLog*>(const_cast<void*>(log))->add(text);
}

/// What EGL has bound to this thread, to be bound again: context, display, both surfaces and the API. Costs some
/// microseconds.
class EglGuard {
 public:
  EglGuard();
  ~EglGuard();
  EglGuard(const EglGuard&) = delete;
  EglGuard& operator=(const EglGuard&) = delete;

  EGLContext context() const { return context_; }  ///< of the host; EGL_NO_CONTEXT: none

 private:
  EGLenum api_;
  EGLContext context_;
  EGLDisplay display_;
  EGLSurface draw_, read_;
};

EglGuard::EglGuard() : api_(eglQueryAPI()) {
  // The current context is asked for per API; OpenGL and OpenGL ES share one answer, OpenVG has another.
  eglBindAPI(EGL_OPENGL_ES_API);
  context_ = eglGetCurrentContext();
  display_ = eglGetCurrentDisplay();
  draw_ = eglGetCurrentSurface(EGL_DRAW);
  read_ = eglGetCurrentSurface(EGL_READ);
}

EglGuard::~EglGuard() {
  eglBindAPI(EGL_OPENGL_ES_API);
  if (eglGetCurrentContext() != context_) {
    if (context_ != EGL_NO_CONTEXT) {
      eglMakeCurrent(display_, draw_, read_, context_);
    } else {
      eglMakeCurrent(eglGetCurrentDisplay(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
  }
  eglBindAPI(api_);
}

/// One way to ask for a context. Drivers give a later version that holds the one asked for.
struct Request {
  bool es;
  int major, minor;
  std::string name() const {
    return "OpenGL " + std::string(es ? "ES " : "") + std::to_string(major) + "." + std::to_string(minor);
  }
};

constexpr std::array desktop_requests{Request{false, 4, 5}, Request{false, 4, 3}, Request{false, 3, 3}};
constexpr std::array es_requests{Request{true, 3, 2}, Request{true, 3, 1}, Request{true, 3, 0}};

GlDialect wanted_dialect(const GlOptions& options) {
  if (options.dialect != GlDialect::automatic) return options.dialect;
  const char* wish = std::getenv("PHYMUL_GL_DIALECT");
  if (!wish || !*wish) return GlDialect::automatic;
  if (std::string_view(wish) == "desktop") return GlDialect::desktop;
  if (std::string_view(wish) == "es") return GlDialect::es;
  throw Error("PHYMUL_GL_DIALECT: expected \"desktop\" or \"es\", got \"" + std::string(wish) + "\"");
}

std::vector<Request> requests_for(GlDialect dialect, GlBackend backend) {
  std::vector<Request> requests;
  if (dialect != GlDialect::es) requests.insert(requests.end(), desktop_requests.begin(), desktop_requests.end());
  if (dialect != GlDialect::desktop) requests.insert(requests.end(), es_requests.begin(), es_requests.end());
  if (backend == GlBackend::compute) {
    std::erase_if(requests, [](const Request& r) { return r.es ? r.minor < 1 : r.major < 4; });
  }
  return requests;
}

bool wants_debug(const GlOptions& options) {
  const char* wish = std::getenv("PHYMUL_GL_DEBUG");
  return options.debug || (wish && std::string_view(wish) == "1");
}

}  // namespace

void DebugLog::listen(const ContextInfo& info) {
  const bool in_core = info.es ? info.at_least(3, 2) : info.at_least(4, 3);
  if (!in_core && !info.has("GL_KHR_debug")) return;
  const char* name = info.es && !in_core ? "glDebugMessageCallbackKHR" : "glDebugMessageCallback";
  const auto callback = reinterpret_cast<PFNGLDEBUGMESSAGECALLBACKPROC>(eglGetProcAddress(name));
  if (!callback) return;
  callback(receive, this);
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
}

void DebugLog::add(const std::string& message) {
  const std::lock_guard lock(mutex_);
  if (++count_ <= most_messages) messages_ += (messages_.empty() ? "" : "; ") + message;
}

void DebugLog::throw_errors() {
  std::string messages;
  int count = 0;
  {
    const std::lock_guard lock(mutex_);
    messages = std::exchange(messages_, {});
    count = std::exchange(count_, 0);
  }
  if (count == 0) return;
  throw Error(ErrorCode::device,
              "GL reports " + std::to_string(count) + (count == 1 ? " error: " : " errors: ") + messages);
}

/// Makes contexts on one display, and keeps a list of what failed.
class OwnContextMaker {
 public:
  OwnContextMaker(const DisplayChoice& place, bool debug, GlBackend backend)
      : display_(place.display), name_(place.name), debug_(debug), backend_(backend) {}

  /// Null where the request failed; failures() has got a line then.
  std::shared_ptr<OwnContext> make(const Request& request) {
    try {
      return try_make(request);
    } catch (const Error& error) {
      failures_ += "\n  " + name_ + ", " + request.name() + ": " + error.what();
      return nullptr;
    }
  }
  const std::string& failures() const { return failures_; }

 private:
  std::shared_ptr<OwnContext> try_make(const Request& request) {
    std::shared_ptr<OwnContext> made(new OwnContext);  // whose constructor is private
    made->display_ = display_;
    made->api_ = request.es ? EGL_OPENGL_ES_API : EGL_OPENGL_API;
    if (!eglBindAPI(made->api_)) throw Error(ErrorCode::device, "eglBindAPI: " + egl_error_name(eglGetError()));
    create(request, *made);
    made->make_current();
    load_functions();
    made->info_ = read_context_info();
    require_backend(made->info_, backend_);
    made->info_.display = name_;
    if (debug_) made->log_.listen(made->info_);
    return made;
  }

  void create(const Request& request, OwnContext& made) const {
    EGLint error = EGL_SUCCESS;
    for (const EGLConfig config : configs(request)) {
      made.context_ = create_robust_or_not(request, config, error);
      if (made.context_ == EGL_NO_CONTEXT) continue;
      if (!has_egl_extension(display_, "EGL_KHR_surfaceless_context")) made.surface_ = one_pixel(request);
      return;
    }
    throw Error(ErrorCode::device, "eglCreateContext: " + egl_error_name(error));
  }

  /// An old driver knows no lost-context notification.
  EGLContext create_robust_or_not(const Request& request, EGLConfig config, EGLint& error) const {
    for (const bool robust : {true, false}) {
      const std::vector<EGLint> attributes = attributes_of(request, robust);
      const EGLContext context = eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes.data());
      if (context != EGL_NO_CONTEXT) return context;
      error = eglGetError();
    }
    return EGL_NO_CONTEXT;
  }

  bool is_egl_15() const {
    const char* version = eglQueryString(display_, EGL_VERSION);
    return version && std::string_view(version) >= "1.5";
  }

  std::vector<EGLint> attributes_of(const Request& request, bool robust) const {
    std::vector<EGLint> a{EGL_CONTEXT_MAJOR_VERSION, request.major, EGL_CONTEXT_MINOR_VERSION, request.minor};
    const auto add = [&](EGLint name, EGLint value) { a.insert(a.end(), {name, value}); };
    if (!request.es) add(EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT);
    if (is_egl_15()) {
      if (debug_) add(EGL_CONTEXT_OPENGL_DEBUG, EGL_TRUE);
      if (robust) add(EGL_CONTEXT_OPENGL_ROBUST_ACCESS, EGL_TRUE);
      if (robust) add(EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET);
    } else {
      if (debug_) add(EGL_CONTEXT_FLAGS_KHR, EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR);
      if (robust && has_egl_extension(display_, "EGL_EXT_create_context_robustness")) {
        add(EGL_CONTEXT_OPENGL_ROBUST_ACCESS_EXT, EGL_TRUE);
        add(EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT, EGL_LOSE_CONTEXT_ON_RESET_EXT);
      }
    }
    a.push_back(EGL_NONE);
    return a;
  }

  EGLConfig pbuffer_config(const Request& request) const {
    const std::array<EGLint, 5> attributes{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                           request.es ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    const bool found = eglChooseConfig(display_, attributes.data(), &config, 1, &count) && count > 0;
    return found ? config : nullptr;
  }

  /// None where the driver allows it, then one for a pbuffer.
  std::vector<EGLConfig> configs(const Request& request) const {
    std::vector<EGLConfig> all;
    if (has_egl_extension(display_, "EGL_KHR_no_config_context") ||
        has_egl_extension(display_, "EGL_MESA_configless_context")) {
      all.push_back(EGL_NO_CONFIG_KHR);
    }
    if (const EGLConfig config = pbuffer_config(request)) all.push_back(config);
    if (all.empty()) throw Error(ErrorCode::device, "no EGL configuration draws " + request.name());
    return all;
  }

  EGLSurface one_pixel(const Request& request) const {
    constexpr std::array<EGLint, 5> size{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    const EGLSurface surface = eglCreatePbufferSurface(display_, pbuffer_config(request), size.data());
    if (surface == EGL_NO_SURFACE)
      throw Error(ErrorCode::device, "eglCreatePbufferSurface: " + egl_error_name(eglGetError()));
    return surface;
  }

  EGLDisplay display_;
  std::string name_;
  bool debug_;
  GlBackend backend_;
  std::string failures_;
};

std::shared_ptr<OwnContext> OwnContext::open(const GlOptions& options, GlBackend backend) {
  const EglGuard guard;
  const GlDialect dialect = wanted_dialect(options);
  std::string failures;
  for (const DisplayChoice& place : display_choices(options.device)) {
    try {
      initialise(place.display);
    } catch (const Error& error) {
      failures += "\n  " + place.name + ": " + error.what();
      continue;
    }
    OwnContextMaker maker(place, wants_debug(options), backend);
    for (const Request& request : requests_for(dialect, backend)) {
      if (std::shared_ptr<OwnContext> made = maker.make(request)) return made;
    }
    failures += maker.failures();
  }
  if (backend == GlBackend::compute) {
    throw Error(
        ErrorCode::device,
        "no OpenGL 4.3 or OpenGL ES 3.1 context without a window could be made, which compute shaders need; the "
        "backend \"gl\" needs OpenGL 3.3 or OpenGL ES 3.0 only; tried:" +
            failures);
  }
  throw Error(ErrorCode::device,
              "no OpenGL 3.3 or OpenGL ES 3.0 context without a window could be made; tried:" + failures);
}

std::shared_ptr<Context> Context::open(const GlOptions& options, GlBackend backend) {
  if (options.context == GlContext::current) return std::make_shared<CurrentContext>(backend);
  return OwnContext::open(options, backend);
}

OwnContext::~OwnContext() {
  // Marked for deletion only, should it be current on another thread still.
  if (is_current()) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
}

bool OwnContext::is_current() const {
  return context_ != EGL_NO_CONTEXT && eglGetCurrentContext() == context_;
}

void OwnContext::call(Task task, void* argument) {
  if (is_current()) return task(argument);
  const EglGuard guard;
  make_current();
  task(argument);
}

void OwnContext::make_current() {
  eglBindAPI(api_);
  if (eglMakeCurrent(display_, surface_, surface_, context_)) return;
  const EGLint error = eglGetError();
  lost_ = lost_ || error == EGL_CONTEXT_LOST;
  std::string reason = "eglMakeCurrent: " + egl_error_name(error);
  if (error == EGL_BAD_ACCESS) {
    reason +=
        ". Either this context is current on another thread, or a context of GLX is current on this one, and EGL "
        "refuses a second beside it. Beside a host that uses GLX take GlContext::current, which works in the host's "
        "context, or step on a thread of its own";
    throw Unreachable(reason);
  }
  throw Error(ErrorCode::device, reason);
}

}  // namespace phymul::gl

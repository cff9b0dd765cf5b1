// SPDX-License-Identifier: MIT
//
// Beside a host that uses GLX, as freeglut and GLFW on X11 do: it needs an X server, so a program of its own.
#include <gtest/gtest.h>

#include "gl/context/gl_functions.h"
#include "support/gl_fixture.h"
#include "support/host_state.h"
#include "support/message_of.h"

// Last: Xlib's macros spoil other headers.
#include <GL/glx.h>
#include <X11/Xlib.h>

namespace phymul::gl {
namespace {

/// A window's worth of GLX: a pbuffer and a context, current on this thread.
class GlxHost {
 public:
  GlxHost(int major, int minor, int profile) : display_(XOpenDisplay(nullptr)) {
    if (!display_) return;
    const int wish[] = {GLX_DRAWABLE_TYPE, GLX_PBUFFER_BIT, GLX_RENDER_TYPE, GLX_RGBA_BIT, 0};
    int count = 0;
    GLXFBConfig* const configs = glXChooseFBConfig(display_, DefaultScreen(display_), wish, &count);
    if (count > 0) {
      const int size[] = {GLX_PBUFFER_WIDTH, 16, GLX_PBUFFER_HEIGHT, 8, 0};
      drawable_ = glXCreatePbuffer(display_, configs[0], size);
      const auto create = reinterpret_cast<PFNGLXCREATECONTEXTATTRIBSARBPROC>(
          glXGetProcAddress(reinterpret_cast<const GLubyte*>("glXCreateContextAttribsARB")));
      // A profile is for versions from 3.2 on; 0 ends the list.
      const int attributes[] = {GLX_CONTEXT_MAJOR_VERSION_ARB,
                                major,
                                GLX_CONTEXT_MINOR_VERSION_ARB,
                                minor,
                                profile ? GLX_CONTEXT_PROFILE_MASK_ARB : 0,
                                profile,
                                0};
      context_ = create(display_, configs[0], nullptr, True, attributes);
    }
    if (configs) XFree(configs);
    make_current();
  }
  ~GlxHost() {
    if (!display_) return;
    put_away();
    if (context_) glXDestroyContext(display_, context_);
    if (drawable_) glXDestroyPbuffer(display_, drawable_);
    XCloseDisplay(display_);
  }
  GlxHost(const GlxHost&) = delete;
  GlxHost& operator=(const GlxHost&) = delete;

  void make_current() { works_ = context_ && glXMakeContextCurrent(display_, drawable_, drawable_, context_); }
  void put_away() { glXMakeContextCurrent(display_, 0, 0, nullptr); }
  bool works() const { return works_; }

 private:
  Display* display_;
  GLXDrawable drawable_ = 0;
  GLXContext context_ = nullptr;
  bool works_ = false;
};

struct GlxBindings {
  GLXContext context = glXGetCurrentContext();
  GLXDrawable draw = glXGetCurrentDrawable(), read = glXGetCurrentReadDrawable();
  Display* display = glXGetCurrentDisplay();
  bool operator==(const GlxBindings&) const = default;
};

const char* why_no_x_server() {
  if (XDisplayName(nullptr)[0]) return "";
  return "no X server: DISPLAY is not set; give it one, as tests/support/on_x_server.sh does";
}

class GlGlx : public test::GlTest, public testing::WithParamInterface<int> {
 protected:
  void set_up() override {
    PHYMUL_SKIP_OR_FAIL(why_no_x_server());
    host_ = std::make_unique<GlxHost>(3, 3, GetParam());
    PHYMUL_SKIP_OR_FAIL(host_->works() ? "" : "GLX gives no OpenGL 3.3 context on this X server");
    load_functions();
    info_ = read_context_info();
  }
  GlxHost& host() { return *host_; }
  const ContextInfo& info() const { return info_; }

 private:
  std::unique_ptr<GlxHost> host_;
  ContextInfo info_;
};

INSTANTIATE_TEST_SUITE_P(All, GlGlx,
                         testing::Values(GLX_CONTEXT_CORE_PROFILE_BIT_ARB, GLX_CONTEXT_COMPATIBILITY_PROFILE_BIT_ARB),
                         [](const auto& profile) {
                           return profile.param == GLX_CONTEXT_CORE_PROFILE_BIT_ARB ? "core" : "compatibility";
                         });

/// Some drivers allow it; where they do not, the message shows the way out. Either way the host keeps its context.
TEST_P(GlGlx, OwnContextWorksOrIsRefusedWithAWayOut) {
  const GlxBindings before;
  const std::string message = message_of([&] {
    const auto context = Context::open({});
    EXPECT_TRUE(context->run([&] { return test::draws_well(context->info()); }));
  });
  const bool mesa = info().version.find("Mesa") != std::string::npos;  // refuses
  if (mesa || message != "(no error)") {
    EXPECT_TRUE(says(message, "EGL_BAD_ACCESS", "GlContext::current"));
  }
  EXPECT_EQ(GlxBindings(), before);
  host().put_away();
  EXPECT_NO_THROW(Context::open({}));
}

TEST_P(GlGlx, HostsContextIsLeftAsItWas) {
  const test::HostileHost hostile(info());
  const GlxBindings bindings;
  const test::HostState before = test::host_state(info());
  auto context = Context::open({.context = GlContext::current});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(context->run([&] { return test::draws_well(context->info()); }));
    if (i == 2) context->run(test::leave_a_mess);
    EXPECT_EQ(GlxBindings(), bindings);
    EXPECT_EQ(test::differences(before, test::host_state(info())), "");
  }
  context.reset();
  EXPECT_EQ(GlxBindings(), bindings);
  EXPECT_EQ(test::differences(before, test::host_state(info())), "");
}

TEST_P(GlGlx, CurrentMeansTheSameContextAtEveryCall) {
  const auto context = Context::open({.context = GlContext::current});
  host().put_away();
  EXPECT_TRUE(refuses([&] { context->run([] {}); }, "is not current on this thread now"));
  host().make_current();
  EXPECT_NO_THROW(context->run([] {}));
}

/// A run of its own: Mesa reads the version it is to play once in a process (gl_tests.cmake).
class GlGlxBelow33 : public testing::Test {};

TEST_F(GlGlxBelow33, CurrentContextIsRefused) {
  PHYMUL_SKIP_OR_FAIL(why_no_x_server());
  const GlxHost host(3, 0, 0);
  PHYMUL_SKIP_OR_FAIL(host.works() ? "" : "GLX gives no OpenGL 3.0 context on this X server");
  const std::string version = reinterpret_cast<const char*>(glGetString(GL_VERSION));
  if (!version.starts_with("3.1")) GTEST_SKIP() << "NOT TESTED: the context is of version " << version;
  const std::string message = message_of([] { Context::open({.context = GlContext::current}); });
  EXPECT_TRUE(message.starts_with("expected OpenGL 3.3 or OpenGL ES 3.0, or later, got ")) << message;
}

}  // namespace
}  // namespace phymul::gl

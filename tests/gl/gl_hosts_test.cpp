// SPDX-License-Identifier: MIT
//
// Beside a host that has a context of its own through EGL. What the host had bound and set is there afterwards.
#include <gtest/gtest.h>
#include <phymul/error.h>
#include <phymul/phymul.h>

#include <cmath>
#include <thread>

#include "gl/solver/device_solver.h"
#include "support/egl_host.h"
#include "support/gl_fixture.h"
#include "support/host_state.h"
#include "support/message_of.h"

namespace phymul::gl {
namespace {

using test::EglBindings;
using test::EglHost;
using test::HostKind;
using test::HostState;

class GlHosts : public test::GlTest, public testing::WithParamInterface<HostKind> {
 protected:
  void SetUp() override {
    test::GlTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    try {
      host_ = std::make_unique<EglHost>(GetParam());
      info_ = read_context_info();
    } catch (const Error& error) {
      GTEST_SKIP() << "NOT TESTED: " << error.what();
    }
  }
  EglHost& host() { return *host_; }
  const ContextInfo& host_info() const { return info_; }

 private:
  std::unique_ptr<EglHost> host_;
  ContextInfo info_;
};

INSTANTIATE_TEST_SUITE_P(All, GlHosts, testing::Values(HostKind::desktop, HostKind::compatibility, HostKind::es),
                         [](const auto& kind) {
                           switch (kind.param) {
                             case HostKind::desktop:
                               return "desktop";
                             case HostKind::compatibility:
                               return "compatibility";
                             default:
                               return "es";
                           }
                         });

/// Opens a context in this mode, works and makes a mess there, closes it: the host's state and bindings are as before
/// after every call.
void expect_host_untouched(const GlOptions& options, const ContextInfo& host_info) {
  const test::HostileHost hostile(host_info);
  const EglBindings bindings;
  const HostState before = test::host_state(host_info);
  const auto expect_as_before = [&](const char* after) {
    EXPECT_EQ(EglBindings(), bindings) << after;
    EXPECT_EQ(test::differences(before, test::host_state(host_info)), "") << after;
  };
  auto context = Context::open(options);
  expect_as_before("open");
  EXPECT_TRUE(context->run([&] { return test::draws_well(context->info()); }));
  expect_as_before("a step");
  context->run(test::leave_a_mess);
  expect_as_before("a mess");
  EXPECT_THROW(context->run([] {
    test::leave_a_mess();
    throw Error("x");
  }),
               Error);
  expect_as_before("an exception");
  EXPECT_FALSE(context->lost());
  expect_as_before("lost()");
  context.reset();
  expect_as_before("close");
}

TEST_P(GlHosts, OwnContextLeavesTheHostAsItWas) {
  for (const GlDialect dialect : {GlDialect::desktop, GlDialect::es}) {
    for (const EGLenum api : {EGL_OPENGL_API, EGL_OPENGL_ES_API}) {
      eglBindAPI(api);
      expect_host_untouched({.dialect = dialect}, host_info());
    }
  }
}

TEST_P(GlHosts, WorkerLeavesTheHostAsItWas) {
  expect_host_untouched({.context = GlContext::worker}, host_info());
}

TEST_P(GlHosts, SharedContextLeavesTheHostAsItWas) {
  expect_host_untouched({.context = GlContext::shared}, host_info());
}

TEST_P(GlHosts, HostsContextIsLeftAsItWas) {
  expect_host_untouched({.context = GlContext::current}, host_info());
}

/// What only computing touches, by a solver's whole life.
TEST_P(GlHosts, HostsContextIsLeftAsItWasByComputing) {
  if (!host_info().computes()) GTEST_SKIP() << "NOT TESTED: no compute shaders in " << host_info().device();
  const Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  Scene scene(model);
  scene.fix("x0").gravity({0, 0, -9.81});
  SolverOptions options;
  options.gl.context = GlContext::current;
  const test::HostileHost hostile(host_info());
  const HostState before = test::host_state(host_info());
  const auto expect_as_before = [&](const char* after) {
    EXPECT_EQ(test::differences(before, test::host_state(host_info())), "") << after;
  };
  auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
  auto solver = std::make_unique<DeviceSolver>(GlBackend::compute, tables, scene, options);
  expect_as_before("making a solver");
  const StepReport report = solver->step(20, 0.3 * solver->stable_step());
  EXPECT_TRUE(report.ok()) << report.message();
  EXPECT_GT(report.max_speed, 0.0);
  expect_as_before("steps");
  EXPECT_GT(solver->energy().total(), -1.0);
  EXPECT_TRUE(solver->momentum(Vec3::Zero()).linear.allFinite());
  expect_as_before("sums");
  EXPECT_NE(solver->position_buffer().texture, 0u);
  solver->attractor_buffer();
  expect_as_before("buffers");
  State state = solver->read();
  solver->request_read();
  solver->collect(state);
  expect_as_before("copies");
  solver.reset();
  expect_as_before("the solver's end");
}

/// Without the guard the hostile state would spoil the work: so the tests above can fail.
TEST_P(GlHosts, HostileStateIsHostile) {
  const test::HostileHost hostile(host_info());
  const HostState before = test::host_state(host_info());
  EXPECT_THROW(test::draws_well(host_info()), Error);
  test::leave_a_mess();
  EXPECT_NE(test::differences(before, test::host_state(host_info())), "");
}

TEST_P(GlHosts, CurrentMeansTheSameContextAtEveryCall) {
  const auto context = Context::open({.context = GlContext::current});
  EXPECT_EQ(context->info().es, host().is_es());
  EXPECT_EQ(context->run([] { return eglGetCurrentContext(); }), host().context());
  const auto message = [&] { return message_of([&] { context->run([] {}); }); };
  host().put_away();
  EXPECT_NE(message().find("is not current on this thread now"), std::string::npos) << message();
  {
    EglHost other(GetParam());
    EXPECT_NE(message().find("is not current on this thread now"), std::string::npos) << message();
  }
  host().make_current();
  EXPECT_EQ(message(), "(no error)");
}

/// The host draws what is in a texture made in our context.
void expect_texture_seen(EglHost& host, const GlOptions& options) {
  const auto context = Context::open(options);
  const GLuint texture = context->run([] {
    GLuint name = 0;
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    const std::array<float, 4> texel{1e9f, -2.0f, 0.5f, 4.0f};
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 1, 1, 0, GL_RGBA, GL_FLOAT, texel.data());
    glFinish();
    return name;
  });
  host.make_current();
  EXPECT_TRUE(glIsTexture(texture));
  GLuint framebuffer = 0;
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  std::array<float, 4> read{};
  glReadPixels(0, 0, 1, 1, GL_RGBA, GL_FLOAT, read.data());
  EXPECT_EQ(read[0], 1e9f);
  EXPECT_EQ(read[1], -2.0f);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDeleteFramebuffers(1, &framebuffer);
  context->discard([&] { glDeleteTextures(1, &texture); });
  EXPECT_FALSE(glIsTexture(texture));
}

TEST_P(GlHosts, SharedTexturesAreSeenByTheHost) {
  expect_texture_seen(host(), {.context = GlContext::shared});
  host().put_away();
  expect_texture_seen(
      host(), {.context = GlContext::shared, .host_display = host().display(), .host_context = host().context()});
}

TEST_P(GlHosts, OwnTexturesAreNot) {
  const auto context = Context::open({});
  std::array<GLuint, 64> names{};
  context->run([&] {
    glGenTextures(64, names.data());
    glBindTexture(GL_TEXTURE_2D, names[63]);
  });
  EXPECT_FALSE(glIsTexture(names[63]));
}

TEST_P(GlHosts, SharedTakesTheHostsDialect) {
  EXPECT_EQ(Context::open({.context = GlContext::shared})->info().es, host().is_es());
  const GlDialect other = host().is_es() ? GlDialect::desktop : GlDialect::es;
  const std::string message = message_of([&] { Context::open({.context = GlContext::shared, .dialect = other}); });
  EXPECT_NE(message.find("leave GlOptions::dialect automatic"), std::string::npos) << message;
}

class GlNoHost : public test::GlTest {};

TEST_F(GlNoHost, SharedAndCurrentSayThatThereIsNone) {
  const std::string shared = message_of([] { Context::open({.context = GlContext::shared}); });
  EXPECT_TRUE(shared.starts_with("GlContext::shared: no EGL context is current on this thread")) << shared;
  const std::string current = message_of([] { Context::open({.context = GlContext::current}); });
  EXPECT_TRUE(current.starts_with("GlContext::current: no context of EGL or GLX is current")) << current;
  int no_context = 0;
  const std::string half =
      message_of([&] { Context::open({.context = GlContext::shared, .host_context = &no_context}); });
  EXPECT_NE(half.find("expected both, or neither"), std::string::npos) << half;
}

TEST_F(GlNoHost, ContextThatIsCurrentElsewhereIsRefusedWithAWayOut) {
  const auto context = Context::open({});
  context->run([&] {
    std::thread([&] {
      const std::string message = message_of([&] { context->run([] {}); });
      EXPECT_NE(message.find("EGL_BAD_ACCESS"), std::string::npos) << message;
      EXPECT_NE(message.find("current on another thread"), std::string::npos) << message;
    }).join();
  });
}

/// Timer queries of one kind do not nest: while the host times itself, the solver has no times of the device.
TEST_P(GlHosts, AHostThatTimesItselfIsLeftAlone) {
  if (host_info().es && !host_info().has("GL_EXT_disjoint_timer_query")) {
    GTEST_SKIP() << "NOT TESTED: " << host_info().device() << " has no timers";
  }
  GLint bits = 0;
  glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
  ASSERT_GT(bits, 0);
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  SolverOptions options;
  options.profile = true;
  options.gl.context = GlContext::current;
  const auto solver = make_solver("gl", model, scene, {}, options);
  const double dt = 0.1 * solver->stable_step();
  const auto device_seconds = [&] {
    double sum = 0.0;
    for (const PassProfile& pass : solver->profile()) sum += pass.device_seconds;
    return sum;
  };
  ASSERT_EQ(solver->step(600, dt).steps, 600);  // more than may be on their way unseen
  EXPECT_GT(device_seconds(), 0.0);
  solver->clear_profile();

  GLuint query = 0;
  glGenQueries(1, &query);
  glBeginQuery(GL_TIME_ELAPSED, query);
  ASSERT_EQ(solver->step(3, dt).steps, 3);
  EXPECT_EQ(solver->profile().front().runs, 3);
  EXPECT_TRUE(std::isnan(device_seconds()));
  GLint current = 0;
  glGetQueryiv(GL_TIME_ELAPSED, GL_CURRENT_QUERY, &current);
  EXPECT_EQ(current, static_cast<GLint>(query));
  glEndQuery(GL_TIME_ELAPSED);
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  glDeleteQueries(1, &query);

  solver->clear_profile();
  solver->step(3, dt);
  EXPECT_GT(device_seconds(), 0.0);
}

}  // namespace
}  // namespace phymul::gl

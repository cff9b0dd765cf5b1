// SPDX-License-Identifier: MIT
//
// Beside a host that has a context of its own through EGL. What the host had bound and set is there afterwards. A
// solver of the backend "gl" from the outside: copies and textures it hands out, its options, many of them in a row,
// and what becomes of it when its device goes away.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <unistd.h>
#include <cmath>
#include <thread>

#include "gl/solver/device_solver.h"
#include "support/egl_host.h"
#include "support/gl_fixture.h"
#include "support/gl_twins.h"
#include "support/heap_in_use.h"
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
  void set_up() override {
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

TEST_P(GlHosts, HostsContextIsLeftAsItWas) {
  expect_host_untouched({.context = GlContext::current}, host_info());
}

/// What only computing touches, by a solver's whole life.
TEST_P(GlHosts, HostsContextIsLeftAsItWasByComputing) {
  if (!host_info().computes()) GTEST_SKIP() << "NOT TESTED: no compute shaders in " << host_info().device();
  const Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  const SolverOptions options{.gl = {.context = GlContext::current}};
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
  EXPECT_NE(solver->position_buffer().texture, 0u);
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
  EXPECT_FALSE(test::draws_well(host_info()));
  test::leave_a_mess();
  EXPECT_NE(test::differences(before, test::host_state(host_info())), "");
}

TEST_P(GlHosts, CurrentMeansTheSameContextAtEveryCall) {
  const auto context = Context::open({.context = GlContext::current});
  EXPECT_EQ(context->info().es, host().is_es());
  EXPECT_EQ(context->run([] { return eglGetCurrentContext(); }), host().context());
  const auto message = [&] { return message_of([&] { context->run([] {}); }); };
  host().put_away();
  EXPECT_TRUE(says(message(), "is not current on this thread now"));
  {
    EglHost other(GetParam());
    EXPECT_TRUE(says(message(), "is not current on this thread now"));
  }
  host().make_current();
  EXPECT_EQ(message(), "(no error)");
}

class GlNoHost : public test::GlTest {};

TEST_F(GlNoHost, CurrentSaysThatThereIsNone) {
  const std::string message = message_of([] { Context::open({.context = GlContext::current}); });
  EXPECT_TRUE(message.starts_with("GlContext::current: no context of EGL or GLX is current")) << message;
}

TEST_F(GlNoHost, ContextThatIsCurrentElsewhereIsRefusedWithAWayOut) {
  const auto context = Context::open({});
  context->run([&] {
    std::thread([&] {
      EXPECT_TRUE(refuses([&] { context->run([] {}); }, "EGL_BAD_ACCESS", "current on another thread"));
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
  const auto solver = make_solver("gl", model, scene, {}, {.profile = true, .gl = {.context = GlContext::current}});
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

namespace phymul::test {
namespace {

class GlLife : public GlTest {
 protected:
  GlLife() : model_(make_block({0.03, 0.02, 0.02}, 3, 2, 2)) {
    set_material(model_, soft_tissue());
    scene_.emplace(model_);
    scene_->gravity({0, 0, -9.81});
  }
  std::unique_ptr<gl::DeviceSolver> make(const SolverOptions& options = {}) const {
    return std::make_unique<gl::DeviceSolver>(GlBackend::fragment, tables_of(model_, {}), *scene_, options);
  }
  /// Waits as long as a device may take: collect() itself never does.
  static bool collected(Solver& solver, State& state) {
    for (int tries = 0; tries < 2000; ++tries) {
      if (solver.collect(state)) return true;
      usleep(1000);
    }
    return false;
  }
  Model model_;
  std::optional<Scene> scene_;
};

TEST_F(GlLife, CopiesComeInOrderAndTheFourthTakesTheThirdsPlace) {
  const auto solver = make();
  const double dt = 0.3 * solver->stable_step();
  State copy;
  EXPECT_FALSE(solver->collect(copy));
  std::vector<State> expected;
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE(solver->step(2, dt).ok());
    solver->request_read();
    expected.push_back(solver->read());
  }
  ASSERT_TRUE(solver->step(2, dt).ok());
  for (const int k : {0, 1, 3}) {
    ASSERT_TRUE(collected(*solver, copy)) << k;
    EXPECT_EQ(copy, expected[k]) << k;
  }
  EXPECT_FALSE(solver->collect(copy));
  solver->request_read();
  solver->reset();
  EXPECT_FALSE(solver->collect(copy)) << "reset() drops copies on their way";
  solver->request_read();
  ASSERT_TRUE(collected(*solver, copy));
  EXPECT_EQ(copy, rest_state(model_));
}

TEST_F(GlLife, TexturesHoldDisplacements) {
  const auto solver = make();
  const State start = random_state(model_, 0.1, 0.0, 8);
  solver->reset(start);
  const std::vector<Float4> u = texels_of(*solver->context(), solver->position_buffer());
  for (std::size_t i = 0; i < model_.rest.size(); ++i) {
    const Vec3 place = model_.rest[i] + Vec3(u[i][0], u[i][1], u[i][2]);
    EXPECT_LE((place - start.position[i]).norm(), 1e-7 * body_size(model_)) << i;
  }
}

TEST_F(GlLife, ShadersMayComeFromAFolder) {
  const Environment folder("PHYMUL_GLSL", "/nonexistent");
  EXPECT_TRUE(refuses([&] { make(); }, "/nonexistent/"));
}

TEST_F(GlLife, StatesBeyondSinglePrecisionAreRefused) {
  const auto solver = make();
  State far = rest_state(model_);
  far.velocity[7].y() = 1e200;
  EXPECT_TRUE(refuses([&] { solver->reset(far); }, "particle 7 has a displacement or velocity beyond single"));
  EXPECT_EQ(solver->read(), rest_state(model_));
}

TEST_F(GlLife, AHundredSolversComeAndGo) {
  const SolverOptions options{.spectrum = estimate_spectrum(*tables_of(model_, {}), model_.rest),
                              .gl = {.debug = true}};
  double before = 0.0;
  for (int k = 0; k < 100; ++k) {
    std::shared_ptr<gl::Context> context;
    {
      const auto solver = make(options);
      context = solver->context();
      ASSERT_TRUE(solver->step(3, 0.3 * solver->stable_step()).ok());
      solver->position_buffer();
      solver->request_read();
      solver->read();
    }
    ASSERT_EQ(message_of([&] { context->throw_debug_errors(); }), "(no error)") << k;
    if (k == 30) before = heap_in_use();
  }
  const double grown = heap_in_use() - before;
  std::printf("[  MEMORY  ] grew by %.0f KiB over the last 70 solvers\n", grown / 1024.0);
  EXPECT_LT(grown, 8e6);
}

TEST_F(GlLife, ALostDeviceIsReportedAndTheSolverGoesOnFromTheNewestState) {
  const auto solver = make(), untouched = make();
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(20, dt).ok());
  const State kept = solver->read();
  ASSERT_TRUE(solver->step(20, dt).ok());
  solver->context()->mark_lost();
  const StepReport lost = solver->step(5, dt);
  EXPECT_EQ(lost.status, StepStatus::device_lost);
  EXPECT_EQ(lost.steps, 0);
  EXPECT_EQ(lost.time, kept.time);
  EXPECT_EQ(solver->read(), kept);
  ASSERT_TRUE(solver->step(20, dt).ok());
  ASSERT_TRUE(untouched->step(40, dt).ok());
  EXPECT_EQ(solver->read(), untouched->read()) << "twenty steps, the loss, and twenty from there";
}

TEST_F(GlLife, ADeviceThatDoesNotComeBackStaysLostUntilAResetFindsOne) {
  const auto solver = make();
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(5, dt).ok());
  const State kept = solver->read();
  {
    const Environment none("PHYMUL_EGL", "device:999");
    solver->context()->mark_lost();
    EXPECT_EQ(solver->step(5, dt).status, StepStatus::device_lost);
    EXPECT_EQ(solver->step(5, dt).status, StepStatus::device_lost);
    EXPECT_EQ(solver->read(), kept);
    EXPECT_EQ(solver->position_buffer().texture, 0u);
    EXPECT_NE(message_of([&] { solver->reset(); }), "(no error)");
  }
  solver->reset(kept);
  EXPECT_TRUE(solver->step(5, dt).ok());
}

}  // namespace
}  // namespace phymul::test

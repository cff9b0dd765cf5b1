// SPDX-License-Identifier: MIT
//
// The backend "gl" by itself: its textures' padding, what it tells of its steps, and what
// it hands out.

#include "support/gl_twins.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

using GlFragment = GlTest;

std::unique_ptr<gl::DeviceSolver> solver_of(const Model& model, const Scene& scene, const GlOptions& gl = {},
                                            const TopologyOptions& topology = {}) {
  const SolverOptions options{.damping = {.factor = 0.99}, .on_unstable = UnstableStep::allow, .gl = gl};
  return std::make_unique<gl::DeviceSolver>(GlBackend::fragment, tables_of(model, topology), scene, options);
}

TEST_F(GlFragment, EnumeratedBasesMoveAsTheTableOfBasesDoes) {
  for (const int valence : {6, 26}) {
    const Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2, valence);
    const Scene scene(model);
    const TopologyOptions all{.reaction = Reaction::barycentric, .bases = BaseSelection::all};
    const auto a = solver_of(model, scene, {}, all);
    const auto b = solver_of(model, scene, {.layout = BaseLayout::table}, all);
    EXPECT_TRUE(a->enumerated()) << "it is smaller";
    EXPECT_FALSE(b->enumerated());
    const State start = random_state(model, 0.05, 0.0, 3);
    const double dt = 0.2 * a->stable_step();
    for (const auto* solver : {&a, &b}) {
      (*solver)->reset(start);
      ASSERT_TRUE((*solver)->step(100, dt).ok());
    }
    EXPECT_LE(largest_distance(a->read().position, b->read().position), 1e-6 * body_size(model));
    EXPECT_GE(largest_distance(a->read().position, start.position), 1e-3 * body_size(model));
    const GlOptions enumerated{.layout = BaseLayout::enumerated};
    EXPECT_TRUE(refuses([&] { solver_of(model, scene, enumerated); }, "bases can be enumerated"));
  }
}

/// Attachments of a framebuffer: all our targets are drawn into through one.
int attachments_of(GLuint framebuffer) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  int count = 0;
  for (GLint type = GL_TEXTURE; type == GL_TEXTURE; ++count) {
    glGetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + count + 1),
                                          GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &type);
  }
  return count;
}

bool holds_integers(int attachment) {
  GLint type = 0;
  glGetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + attachment),
                                        GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE, &type);
  return type == GL_INT;
}

constexpr GLint sentinel = -77777;

void fill_with_sentinels(GLuint framebuffer) {
  const int count = attachments_of(framebuffer);
  for (int k = 0; k < count; ++k) {
    const std::array<GLint, 4> integers{sentinel, sentinel, sentinel, sentinel};
    std::array<GLfloat, 4> floats{};
    floats.fill(static_cast<GLfloat>(sentinel));
    if (holds_integers(k)) glClearBufferiv(GL_COLOR, k, integers.data());
    if (!holds_integers(k)) glClearBufferfv(GL_COLOR, k, floats.data());
  }
}

/// Number of texels from the first on that are no sentinels; -1 where sentinels and others are mixed.
int written_rows(int attachment, int width, int height) {
  glReadBuffer(static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + attachment));
  std::vector<Int4> texels(static_cast<std::size_t>(width) * height);
  std::vector<Float4> floats(texels.size());
  if (holds_integers(attachment)) {
    glReadPixels(0, 0, width, height, GL_RGBA_INTEGER, GL_INT, texels.data());
  } else {
    glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, floats.data());
    for (std::size_t i = 0; i < texels.size(); ++i) {
      const bool untouched = std::all_of(floats[i].begin(), floats[i].end(), [](float f) { return f == sentinel; });
      texels[i].fill(untouched ? sentinel : 0);
    }
  }
  const auto is_sentinel = [](const Int4& t) { return t == Int4{sentinel, sentinel, sentinel, sentinel}; };
  const auto first = std::find_if(texels.begin(), texels.end(), is_sentinel);
  return std::all_of(first, texels.end(), is_sentinel) ? static_cast<int>(first - texels.begin()) : -1;
}

TEST_F(GlFragment, PaddingOfEveryTargetIsUntouchedAndUnread) {
  const Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2, 18);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  const GlTwins twins(tables_of(model, {.volume_stiffness = 50.0}), scene, {});
  const TopologyTextures& tables = twins.gl->topology();
  std::vector<int> rows{model.particle_count(), tables.base_count, static_cast<int>(tables.volumes.size())};
  for (int n = model.particle_count(); n > 1; rows.push_back(n)) n = (n + 15) / 16;
  gl::Context& context = *twins.gl->context();
  constexpr GLuint most_names = 200;
  context.run([] {
    for (GLuint name = 1; name < most_names; ++name) {
      if (glIsFramebuffer(name)) fill_with_sentinels(name);
    }
  });
  twins.reset(random_state(model, 0.05, 0.1, 9));
  const double dt = 0.3 * twins.gl->stable_step();
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE(all_step(3, dt, twins.gl, twins.mirror));
  }
  EXPECT_LE(largest_distance(twins.gl->read().position, twins.mirror->read().position), 1e-6 * body_size(model));
  twins.expect_same_bits("with sentinels in the padding");
  int targets = 0, padded = 0;
  context.run([&] {
    for (GLuint name = 1; name < most_names; ++name) {
      if (!glIsFramebuffer(name)) continue;
      const int count = attachments_of(name);
      for (int k = 0; k < count; ++k, ++targets) {
        int found = 0;
        for (const int n : rows) {
          // Rectangles that a table of another number of rows has, too, are read as that table; its rows decide.
          const TextureShape shape = fit_texture(n, 16384, "a target");
          if (written_rows(k, shape.width, shape.height) != n) continue;
          found = n;
          if (shape.texels() > n) ++padded;
          break;
        }
        EXPECT_GT(found, 0) << "framebuffer " << name << ", attachment " << k;
      }
    }
  });
  EXPECT_GE(targets, 20);
  EXPECT_GE(padded, 10) << "nothing had padding to be untouched";
}

TEST_F(GlFragment, TellsOfItsStepsWhatTheMirrorTells) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
  Scene scene(model);
  const GlTwins twins(tables_of(model, {}), scene);
  for (const double amount : {0.05, 0.2}) {
    for (const double beyond : {1.5, 3.0, 10.0}) {
      SCOPED_TRACE(beyond);
      twins.reset(random_state(model, amount, 0.0, 3));
      const double dt = beyond * twins.gl->stable_step();
      const StepReport a = twins.gl->step(100000, dt), b = twins.mirror->step(100000, dt);
      EXPECT_EQ(a.status, StepStatus::not_finite);
      EXPECT_EQ(a.steps, b.steps);
      EXPECT_EQ(a.particle, b.particle);
      EXPECT_EQ(a.time, b.time);
      const State last = twins.gl->read();
      EXPECT_TRUE(is_finite(last));
      twins.expect_same_bits("the last good state");
      EXPECT_NEAR(a.max_speed, largest_norm(last.velocity), 1e-6 * a.max_speed);
      // Minors of a body stretched a hundred-thousandfold cancel: an NVIDIA H100 was off by 17 %.
      EXPECT_NEAR(a.residual, b.residual, (twins.same_bits_expected() ? 1e-4 : 0.5) * b.residual);
    }
  }
}

TEST_F(GlFragment, RestsAtTheMirrorsStep) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
  Scene scene = Scene(model).fix("z1").gravity({0, 0, -9.81});
  for (const int rest_steps : {1, 3, 16, 100}) {
    const SolverOptions options{.damping = {.rate = 60.0}, .rest_tolerance = 1e-4, .rest_steps = rest_steps};
    const GlTwins twins(tables_of(model, {}), scene, options);
    const double dt = 0.5 * twins.gl->stable_step();
    for (int again = 0; again < 2; ++again) {
      const RestResult a = twins.gl->run_to_rest(20000, dt), b = twins.mirror->run_to_rest(20000, dt);
      EXPECT_TRUE(a.converged());
      EXPECT_NEAR(a.report.steps, b.report.steps, 0.001 * b.report.steps) << rest_steps;
      EXPECT_TRUE(a.report.steps == b.report.steps || !twins.same_bits_expected()) << rest_steps;
      twins.expect_same_bits("at rest");
    }
  }
}

TEST_F(GlFragment, PulledCylinderRestsWithinAThousandthOfTheReferencesSteps) {
  const Model model = with_material(cylinder_275());
  Scene scene = Scene(model).fix("bottom");
  scene.add(
      {.type = LoadType::force, .particles = model.group("top"), .events = {{0.0, 0.002}}, .direction = {0, 0, 1}});
  const GlTwins twins(tables_of(model, {}), scene, {.damping = {.rate = 60.0}, .rest_tolerance = 1e-6});
  const auto reference = make_solver("reference", model, scene, {}, twins.options());
  const double dt = 0.25 * reference->stable_step();
  const RestResult a = twins.gl->run_to_rest(50000, dt), b = reference->run_to_rest(50000, dt);
  ASSERT_TRUE(a.converged() && b.converged()) << a.message() << "; " << b.message();
  std::printf("[   REST   ] gl after %d steps, reference after %d\n", a.report.steps, b.report.steps);
  EXPECT_NEAR(a.report.steps, b.report.steps, 0.001 * b.report.steps);
  EXPECT_LE(largest_distance(twins.gl->read().position, reference->read().position), 1e-5 * body_size(model));
}

}  // namespace
}  // namespace phymul::test

// SPDX-License-Identifier: MIT
//
// Displays beside a host's context. Display::draw draws into the host's framebuffer, and changes nothing else of it.
#include <phymul/phymul.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "gl/context/gl_api.h"
#include "support/egl_host.h"
#include "support/every_backend.h"
#include "support/gl_fixture.h"
#include "support/host_state.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr int pixels = 128;

/// Largest difference of a channel.
int largest_difference(const Image& a, const Image& b) {
  int most = 0;
  for (std::size_t k = 0; k < a.rgba.size(); ++k) most = std::max(most, std::abs(a.rgba[k] - b.rgba[k]));
  return most;
}

class GlDisplayTest : public GlTest {};

TEST_F(GlDisplayTest, OpacitiesThatThereAreNotAreRefused) {
  const Model model = make_tetrahedron(0.01);
  const auto display = make_display(model);
  const Camera camera = framing(model.rest, {0.4, -1, 0.35}, 1.0);
  for (const double opacity : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(says(message_of([&] { display->render(camera, {.surface_opacity = opacity}, 8, 8); }), "from 0 to 1"));
  }
  EXPECT_NO_THROW(display->render(camera, {.surface_opacity = 0.0}, 8, 8));
}

TEST_F(GlDisplayTest, DrawsIntoTheHostsFramebufferAndLeavesTheRestAlone) {
  const auto host = gl::Context::open({});
  const Model model = make_tetrahedron(0.01);
  DisplayOptions options{.surface_opacity = 0.5};
  options.particles = options.links = options.rest_shape = true;
  constexpr int x = 16, y = 32, width = 80, height = 64;
  const Camera camera = framing(model.rest, {0.4, -1, 0.35}, 1.25);
  const Image image = make_display(model)->render(camera, options, width, height);  // in a context without such a host
  host->run([&] {
    GLuint buffers[2], framebuffer = 0, array = 0;
    glGenRenderbuffers(2, buffers);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers[0]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, pixels, pixels);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers[1]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, pixels, pixels);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers[0]);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers[1]);
    glClearColor(0.0f, 0.0f, 1.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glBlendFuncSeparate(GL_ONE, GL_DST_COLOR, GL_ZERO, GL_SRC_ALPHA);
    glBlendEquationSeparate(GL_FUNC_SUBTRACT, GL_MAX);
    glEnable(GL_BLEND);
    glCullFace(GL_FRONT_AND_BACK);
    glEnable(GL_CULL_FACE);
    glFrontFace(GL_CW);
    glDepthFunc(GL_NEVER);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glScissor(1, 2, 3, 4);
    glEnable(GL_SCISSOR_TEST);
    glViewport(5, 6, 7, 8);
    glActiveTexture(GL_TEXTURE3);
    glDepthRangef(1.0f, 0.25f);
    const gl::ContextInfo& info = host->info();
    if (info.has(info.es ? "GL_EXT_clip_control" : "GL_ARB_clip_control")) {
      (info.es ? glClipControlEXT : glClipControl)(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    }

    const auto display = make_display(model, {.context = GlContext::current});
    const HostState before = host_state(info);
    display->draw(camera, options, x, y, width, height);
    EXPECT_EQ(differences(before, host_state(info)), "");

    std::vector<std::uint8_t> rgba(4 * pixels * pixels);
    glReadPixels(0, 0, pixels, pixels, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    const auto pixel = [&](int column, int row) { return &rgba[4 * static_cast<std::size_t>(row * pixels + column)]; };
    int body = 0;
    for (int row = 0; row < pixels; ++row) {
      for (int column = 0; column < pixels; ++column) {
        const std::uint8_t* p = pixel(column, row);
        const bool untouched = p[0] == 0 && p[1] == 0 && p[2] == 255;
        const bool inside = column >= x && column < x + width && row >= y && row < y + height;
        ASSERT_EQ(untouched, !inside) << column << ' ' << row;
        body += inside && p[0] < 240;
      }
    }
    EXPECT_GT(body, width * height / 6);
    // The same as the picture, whose rows run downward, but for its smoothed edges.
    int different = 0;
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        const std::uint8_t *drawn = pixel(x + column, y + height - 1 - row), *expected = image.pixel(column, row);
        for (int c = 0; c < 3; ++c) different += std::abs(drawn[c] - expected[c]) > 60;
      }
    }
    EXPECT_LT(different, width * height / 20);
    EXPECT_LE(largest_difference(display->render(camera, options, width, height), image), 2);
    EXPECT_EQ(differences(before, host_state(info)), "");
    glDeleteVertexArrays(1, &array);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteRenderbuffers(2, buffers);
  });
}

/// A small picture in the solver's own context leaves nothing behind that clips or blends the larger targets of steps.
TEST_F(GlDisplayTest, StepsAfterAPictureAreThoseWithoutOne) {
  const Model model = make_block({0.17, 0.17, 0.17}, 17, 17, 17, 6);
  const TopologyOptions springs{.law = Law::springs};
  Scene scene = Scene(model).gravity({0, 0, -9.81}).fix("z1");
  const auto drawn = make_solver("gl", model, scene, springs), plain = make_solver("gl", model, scene, springs);
  const auto display = make_display(*drawn);
  const Camera camera = framing(model.rest, {1.0, -1.0, 0.5}, 1.0);
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(display->render(camera, {.links = true}, 8, 8).width, 8);
    ASSERT_TRUE(drawn->step(4, 0.3 * drawn->stable_step()).ok());
    ASSERT_TRUE(plain->step(4, 0.3 * plain->stable_step()).ok());
  }
  EXPECT_TRUE(drawn->read() == plain->read());
}

struct DrawnSkin {
  DrawnSkin() {
    for (Vec3& p : ball.rest) p = Vec3(0.002 + p.z(), 0.01 + p.x(), 0.01 + p.y());
  }

  Model body = make_block({0.04, 0.02, 0.02}, 4, 2, 2);
  Scene scene = Scene(body).fix("x0").gravity({0, 0, -9.81});
  Model ball = make_cylinder(0.009, 0.036, 3, 12, 10);  // lies in the block, its axis along x
  std::vector<std::array<Index, 3>> triangles = surface_triangles(ball);
};

class GlSkinDisplay : public GlTest, public testing::WithParamInterface<std::string> {
 protected:
  std::string needs() const override { return GetParam(); }
};

/// A skin is where Skin::deform() puts it, on every backend: drawn as a body of its own, it makes the same picture.
TEST_P(GlSkinDisplay, DrawsASkinWhereItsBodyCarriesIt) {
  const DrawnSkin drawn_skin;
  const auto& [body, scene, ball, triangles] = drawn_skin;
  const Skin skin(body, ball.rest);
  const Camera camera = framing(body.rest, {0.4, -1, 0.35}, 1.25);
  const DisplayOptions options{.particles = true, .rest_shape = true, .full_scale = 0.002};
  const auto solver = make_solver(GetParam(), body, scene, {});
  const auto display = make_display(*solver, skin, triangles);
  EXPECT_EQ(display->zero_copy(), GetParam() != "cpu");
  ASSERT_TRUE(solver->step(60, 0.5 * solver->stable_step()).ok());
  Model shown = ball;
  shown.cells.clear();
  for (const auto& triangle : triangles) {
    shown.cells.push_back({.type = CellType::triangle, .particles = {triangle.begin(), triangle.end()}});
  }
  shown.neighbours = neighbours_from_cells(shown.cells, shown.particle_count());
  const auto expected = make_display(shown);
  const Image at_rest = expected->render(camera, options, 200, 160);
  expected->show(skin.deform(solver->read().position));
  const Image moved = expected->render(camera, options, 200, 160), drawn = display->render(camera, options, 200, 160);
  int different = 0;
  for (std::size_t k = 0; k < moved.rgba.size(); ++k) different += std::abs(moved.rgba[k] - drawn.rgba[k]) > 2;
  EXPECT_LT(different, 20);  // rounding moves an edge over a pixel
  EXPECT_GT(largest_difference(at_rest, moved), 100);
}
PHYMUL_ON_BACKENDS(GlSkinDisplay, (std::vector<std::string>{"gl", "gl-compute", "cpu"}));

TEST_F(GlDisplayTest, RefusesASkinOfAnotherBodyAndTrianglesBeyondIt) {
  const DrawnSkin drawn_skin;
  const auto& [model, scene, ball, triangles] = drawn_skin;
  const Skin skin(model, ball.rest);
  EXPECT_EQ(message_of([&] {
              make_display(*make_solver("cpu", model, scene, {}), skin,
                           std::vector<std::array<Index, 3>>{{0, 1, static_cast<Index>(skin.size())}});
            }),
            "make_display: a triangle of point " + std::to_string(skin.size()) + " of a skin of " +
                std::to_string(skin.size()) + " points");
  const Model longer = make_block({0.05, 0.02, 0.02}, 4, 2, 2);  // of as many particles
  const Scene other(longer);
  EXPECT_TRUE(refuses([&] { make_display(*make_solver("cpu", longer, other, {}), skin, triangles); },
                      "expected a skin bound to the solver's body"));
}

TEST_F(GlDisplayTest, ASolverIsDrawnWhateverContextItRunsInAndTheDisplayDrawsIn) {
  for (const HostKind host_kind : {HostKind::desktop, HostKind::es}) {
    const EglHost host(host_kind);
    const EglBindings bindings;
    const Model model = make_tetrahedron(0.01);
    Scene scene = Scene(model).fix("base");
    State start = rest_state(model);
    start.position[3] += Vec3(0.003, 0.002, 0.0);  // swings
    const Camera camera = framing(model.rest, {0.4, -1, 0.35}, 1.25);
    const DisplayOptions layers{.links = true, .particles = true, .full_scale = 0.002};
    const auto given = make_display(model);
    for (const GlContext kind : {GlContext::own, GlContext::current}) {
      SolverOptions options{.gl = {.context = kind}};
      if (host.is_es()) options.gl.dialect = GlDialect::es;
      const auto solver = make_solver("gl", model, scene, {}, options);
      const auto in_solvers = make_display(*solver), in_hosts = make_display(*solver, {.context = GlContext::current});
      EXPECT_TRUE(in_solvers->zero_copy());
      EXPECT_EQ(in_hosts->zero_copy(), kind == GlContext::current) << static_cast<int>(kind);
      solver->reset(start);
      std::optional<Image> before;
      for (int frame = 0; frame < 3; ++frame) {
        ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
        // The pictures first: what has been read has arrived, which would hide a missing wait.
        const Image hosts = in_hosts->render(camera, layers, 100, 80);
        const Image solvers = in_solvers->render(camera, layers, 100, 80);
        given->show(solver->read().position);
        const Image expected = given->render(camera, layers, 100, 80);
        EXPECT_LE(largest_difference(hosts, expected), 2) << static_cast<int>(kind);
        EXPECT_LE(largest_difference(solvers, expected), 2) << static_cast<int>(kind);
        if (before) {
          EXPECT_GT(largest_difference(expected, *before), 20);
        }
        before = expected;
        EXPECT_EQ(EglBindings(), bindings);
        EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
      }
    }
  }
}

}  // namespace
}  // namespace phymul::test

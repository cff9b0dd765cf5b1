// SPDX-License-Identifier: MIT
//
// What is in the pictures, pixel by pixel, through the public interface.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr int width = 240, height = 200;
constexpr double ball = 0.0008;  // m

class GlPictureTest : public testing::Test {
 protected:
  void SetUp() override { PHYMUL_SKIP_OR_FAIL(why_no_display()); }

  static std::string why_no_display() {
    static const Model model = make_tetrahedron(0.01);
    try {
      make_display(model);
      return {};
    } catch (const Error& error) {
      return error.what();
    }
  }
};

DisplayOptions nothing() {
  return {.surface = false, .edges = false};
}

DisplayOptions particles_only() {
  DisplayOptions options = nothing();
  options.particles = true;
  options.particle_radius = ball;
  return options;
}

Camera camera_for(const Model& model, double angle = 0.0) {
  Camera camera = framing(model.rest, {0.4, -1.0, 0.35}, static_cast<double>(width) / height, angle);
  camera.view_height *= 1.5;  // room for what moves
  camera.eye += 0.5 * (camera.eye - camera.target);
  return camera;
}

bool is_painted(const std::uint8_t* pixel) {
  return pixel[0] < 250 || pixel[1] < 250 || pixel[2] < 250;
}

int painted(const Image& image) {
  int count = 0;
  for (std::size_t k = 0; k < image.rgba.size(); k += 4) count += is_painted(&image.rgba[k]);
  return count;
}

Vec3 colour_at(const Image& image, const Camera& camera, const Vec3& place) {
  const Vec3 pixel = to_pixel(camera, place, width, height);
  const std::uint8_t* rgba = image.pixel(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  return Vec3(rgba[0], rgba[1], rgba[2]) / 255.0;
}

/// Share of pixels that differ by more than 8 of 255 in a channel.
double difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  int count = 0;
  for (std::size_t k = 0; k < a.rgba.size(); k += 4) {
    int most = 0;
    for (std::size_t c = 0; c < 4; ++c) most = std::max(most, std::abs(a.rgba[k + c] - b.rgba[k + c]));
    count += most > 8;
  }
  return 4.0 * count / static_cast<double>(a.rgba.size());
}

TEST_F(GlPictureTest, BallsAreJustWhereTheProjectionSays) {
  const Model model = make_tetrahedron(0.01);
  const auto display = make_display(model);
  for (const double angle : {0.0, 0.3}) {
    const Camera camera = camera_for(model, angle);
    const Image image = display->render(camera, particles_only(), width, height);
    ASSERT_EQ(image.width, width);
    ASSERT_EQ(image.height, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        double depth = -1e9;  // inside the nearest disc, pixels
        for (const Vec3& particle : model.rest) {
          const Vec3 seen = to_pixel(camera, particle, width, height);
          const double radius = ball * pixels_per_metre(camera, particle, height);
          depth = std::max(depth, radius - std::hypot(x + 0.5 - seen.x(), y + 0.5 - seen.y()));
        }
        if (std::abs(depth) < 1.2) continue;  // the rim
        ASSERT_EQ(is_painted(image.pixel(x, y)), depth > 0.0) << x << ' ' << y << " angle " << angle;
      }
    }
    EXPECT_EQ(image.pixel(0, 0)[3], 255);
  }
}

/// In perspective with the near plane in the eye all depths are equal, and what is drawn last would hide what is
/// nearer.
TEST_F(GlPictureTest, CamerasThatSeeNothingRightAreRefused) {
  const Model model = make_tetrahedron(0.01);
  const auto display = make_display(model);
  for (const double angle : {0.0, 0.3}) {
    Camera camera = camera_for(model, angle);
    const double distance = (camera.eye - camera.target).norm();
    const auto draw = [&](double near, double far) {
      camera.near_plane = near, camera.far_plane = far;
      return painted(display->render(camera, particles_only(), width, height));
    };
    EXPECT_GT(draw(0.1 * distance, 3.0 * distance), 200);
    EXPECT_THROW(draw(distance, distance), Error);
    EXPECT_THROW(draw(3.0 * distance, distance), Error);
    if (angle > 0.0) {
      EXPECT_THROW(draw(0.0, 3.0 * distance), Error);
      for (const double wrong : {-angle, 3.2}) {
        camera.view_angle = wrong;
        EXPECT_THROW(draw(0.1 * distance, 3.0 * distance), Error) << wrong;
      }
    } else {
      EXPECT_GT(draw(0.0, 3.0 * distance), 200);
      camera.view_height = 0.0;
      EXPECT_THROW(draw(0.0, 3.0 * distance), Error);
    }
  }
}

TEST_F(GlPictureTest, WhatMovesMovesInThePicture) {
  const Model model = make_tetrahedron(0.01);
  const auto display = make_display(model);
  const Camera camera = camera_for(model);
  const Image before = display->render(camera, particles_only(), width, height);
  const CameraAxes axes = axes_of(camera);
  const double pixel = 1.0 / pixels_per_metre(camera, camera.target, height);
  VecList moved = model.rest;
  for (Vec3& x : moved) x += pixel * (20.0 * axes.right - 10.0 * axes.up);
  display->show(moved);
  const Image after = display->render(camera, particles_only(), width, height);
  int different = 0;
  for (int y = 0; y + 10 < height; ++y) {
    for (int x = 0; x + 20 < width; ++x) {
      for (int c = 0; c < 3; ++c) different += std::abs(before.pixel(x, y)[c] - after.pixel(x + 20, y + 10)[c]) > 40;
    }
  }
  EXPECT_GT(painted(before), 200);
  EXPECT_LT(different, 0.02 * painted(before));
  EXPECT_GT(difference(before, after), 0.01);
}

TEST_F(GlPictureTest, WhatIsCutOrRemovedIsDrawnSo) {
  Model model = make_tetrahedral_block({0.04, 0.02, 0.02}, 6, 3, 3, 0.1, 1);
  set_material(model, {1e4, 0.3, 1000.0});
  Simulation sim(with_spare_particles(model, 60), {.backend = "cpu"});
  const auto display = make_display(sim.solver());
  const Camera camera = camera_for(model);
  const auto differs = [&](const Image& image) {
    return difference(image, make_display(sim.solver())->render(camera, {}, width, height));
  };
  Image image = display->render(camera, {}, width, height);
  EXPECT_EQ(differs(image), 0.0);
  sim.remove_cells(sim.model().cells_in([](const Vec3& x) { return x.x() > 0.03; }));
  EXPECT_GT(differs(image), 0.05);
  image = display->render(camera, {}, width, height);
  EXPECT_EQ(differs(image), 0.0);
  ASSERT_TRUE(sim.cut(cut_plane({0.015, 0, 0}, {1.0, 0.2, 0.1})));
  EXPECT_EQ(differs(display->render(camera, {}, width, height)), 0.0);
}

TEST_F(GlPictureTest, FacesAreLitByTheirNormalsAndColouredByDisplacement) {
  const Model model = make_tetrahedron(0.01);
  const auto display = make_display(model);
  DisplayOptions options = nothing();
  options.surface = true;
  options.full_scale = 0.004;
  VecList moved = model.rest;
  for (Vec3& x : moved) x += Vec3(0.0, 0.0, 0.001);  // a quarter of the scale, all of them
  display->show(moved);
  int seen = 0;
  for (const Vec3& towards_eye : {Vec3(0.4, -1.0, 0.35), Vec3(-1.0, 0.5, -0.6), Vec3(0.2, 0.3, 1.0)}) {
    const Camera camera = framing(moved, towards_eye, static_cast<double>(width) / height);
    const CameraAxes axes = axes_of(camera);
    const Vec3 light = (-0.5 * axes.right + 0.6 * axes.up + axes.towards_eye).normalized();
    const Image image = display->render(camera, options, width, height);
    const Vec3 centre = sum(moved) / 4.0;
    for (int left_out = 0; left_out < 4; ++left_out) {
      Vec3 middle = Vec3::Zero();
      for (int i = 0; i < 4; ++i) middle += i == left_out ? Vec3(Vec3::Zero()) : Vec3(moved[i] / 3.0);
      const Vec3 normal = (middle - centre).normalized();  // regular: towards the face's middle
      if (normal.dot(axes.towards_eye) < 0.1) continue;
      const Colour scale = displacement_colour(0.25);
      const Vec3 expected = Vec3(scale[0], scale[1], scale[2]) * (0.66 + 0.38 * std::max(0.0, normal.dot(light)));
      EXPECT_LT((colour_at(image, camera, middle) - expected.cwiseMin(1.0)).cwiseAbs().maxCoeff(), 0.012);
      ++seen;
    }
  }
  EXPECT_GE(seen, 5);
}

/// Whichever way its cells are wound, a plane body is as bright from behind as from the front.
TEST_F(GlPictureTest, BothSidesOfAPlaneBodyAreLit) {
  const Model model = make_strip(0.02, 0.01, 4, 2);
  const auto display = make_display(model);
  DisplayOptions options = nothing();
  options.surface = true;
  options.full_scale = 0.004;
  const double facing = 1.0 / Vec3(-0.5, 0.6, 1.0).norm();
  const Colour rest = displacement_colour(0.0);
  const Vec3 expected = Vec3(rest[0], rest[1], rest[2]) * (0.66 + 0.38 * facing);
  for (const double side : {1.0, -1.0}) {
    const Camera camera = framing(model.rest, {0, 0, side}, static_cast<double>(width) / height);
    const Vec3 colour = colour_at(display->render(camera, options, width, height), camera, {0.0125, 0.0062, 0});
    EXPECT_LT((colour - expected.cwiseMin(1.0)).cwiseAbs().maxCoeff(), 0.012) << side;
  }
}

TEST_F(GlPictureTest, LinksMarksAndAttractorsAreDrawn) {
  const Model model = make_tetrahedron(0.01);
  const auto display = make_display(model);
  const Camera camera = camera_for(model);
  VecList attractor = model.rest;
  attractor[0] += 0.003 * axes_of(camera).right;
  display->show(model.rest, attractor);

  DisplayOptions options = nothing();
  EXPECT_EQ(painted(display->render(camera, options, width, height)), 0);
  options.links = true;
  const Image links = display->render(camera, options, width, height);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      const Vec3 pixel = to_pixel(camera, 0.5 * (model.rest[i] + model.rest[j]), width, height);
      EXPECT_TRUE(is_painted(links.pixel(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))));
    }
  }
  options.links = false;
  options.attractors = true;
  const Image attractors = display->render(camera, options, width, height);
  for (const Vec3& place : {attractor[0], Vec3(0.5 * (attractor[0] + model.rest[0]))}) {
    const Vec3 colour = colour_at(attractors, camera, place);
    EXPECT_GT(colour.x() - colour.y(), 0.3);  // their own colour
  }
  options.attractors = false;
  options.marks = {{{2}, {0.0, 0.8, 0.0, 1.0}}};
  const Image marks = display->render(camera, options, width, height);
  EXPECT_GT(colour_at(marks, camera, model.rest[2]).y(), 0.5);
  EXPECT_LT(colour_at(marks, camera, model.rest[2]).x(), 0.1);
  EXPECT_GT(colour_at(marks, camera, model.rest[1]).x(), 0.99);
}

TEST_F(GlPictureTest, TheRestShapeIsSeenBehindABodyThatLeftIt) {
  const Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  const auto display = make_display(model);
  const Camera camera = camera_for(model);
  VecList gone = model.rest;
  for (Vec3& x : gone) x += 10.0 * axes_of(camera).right;
  display->show(gone);
  DisplayOptions options;
  EXPECT_EQ(painted(display->render(camera, options, width, height)), 0);
  options.rest_shape = true;
  const Image image = display->render(camera, options, width, height);
  EXPECT_GT(painted(image), 200);
  // Its twelve edges alone, dashed, and neither its faces nor the lines on them.
  std::vector<std::array<Vec3, 2>> edges;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 4; ++k) {
      Vec3 corner = Vec3::Zero();
      corner[(axis + 1) % 3] = k & 1 ? 0.02 : 0.0;
      corner[(axis + 2) % 3] = k & 2 ? 0.02 : 0.0;
      const Vec3 other = corner + 0.02 * Vec3::Unit(axis);
      edges.push_back({to_pixel(camera, corner, width, height), to_pixel(camera, other, width, height)});
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!is_painted(image.pixel(x, y))) continue;
      double nearest = 1e9;
      for (const auto& [a, b] : edges) {
        const Eigen::Vector2d way = (b - a).head<2>(), from(x + 0.5 - a.x(), y + 0.5 - a.y());
        const double share = std::clamp(from.dot(way) / way.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (from - share * way).norm());
      }
      ASSERT_LT(nearest, 2.0) << x << ' ' << y;
    }
  }
}

TEST_F(GlPictureTest, WhatIsInsideShowsThroughASurfaceThatLetsThrough) {
  const Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  const auto display = make_display(model);
  const Camera camera = camera_for(model);
  DisplayOptions options{.edges = false};
  options.marks = {{{13}, {0.9, 0.0, 0.0, 1.0}}};  // the middle one
  const auto redness = [&](const Image& image) {
    const Vec3 colour = colour_at(image, camera, model.rest[13]);
    return colour.x() - colour.z();
  };
  EXPECT_LT(redness(display->render(camera, options, width, height)), 0.0);
  options.surface_opacity = 0.3;
  EXPECT_GT(redness(display->render(camera, options, width, height)), 0.1);
}

TEST_F(GlPictureTest, ABodyFarFromTheOriginLooksTheSame) {
  const Model here = jittered_block();
  Model there = here;
  const Vec3 far(1000.0, -2000.0, 500.0);
  for (Vec3& x : there.rest) x += far;
  Camera camera = camera_for(here);
  const DisplayOptions options = particles_only();
  const Image first = make_display(here)->render(camera, options, width, height);
  camera.eye += far;
  camera.target += far;
  EXPECT_LT(difference(first, make_display(there)->render(camera, options, width, height)), 1e-3);
}

TEST_F(GlPictureTest, ACpuSolverIsFollowed) {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  const auto solver = make_solver("reference", model, scene);
  const auto followed = make_display(*solver), given = make_display(model);
  EXPECT_FALSE(followed->zero_copy());
  State state = rest_state(model);
  state.position[3] += Vec3(0.002, 0.001, 0.0);
  solver->reset(state);
  DisplayOptions options{.full_scale = 0.002};
  options.links = options.particles = options.attractors = true;
  options.surface_opacity = 0.5;
  const Camera camera = camera_for(model);
  VecList attractor(4);
  attractors(solver->topology(), state.position, attractor);
  given->show(state.position, attractor);
  EXPECT_EQ(followed->render(camera, options, width, height).rgba, given->render(camera, options, width, height).rgba);
  const Image before = followed->render(camera, options, width, height);
  solver->reset();
  EXPECT_GT(difference(before, followed->render(camera, options, width, height)), 0.02);
}

/// The particles drawn from the texture that the solver wrote are those that read() gives.
TEST_F(GlPictureTest, AGlSolverIsDrawnFromItsOwnTexture) {
  PHYMUL_SKIP_OR_FAIL(why_not_here("gl"));
  for (const bool with_attractors : {false, true}) {
    Model model = cylinder_275();
    Scene scene = Scene(model).fix("bottom").gravity({40.0, 0.0, 0.0});
    TopologyOptions topology;
    if (with_attractors) topology.reaction = Reaction::averaged;
    const auto solver = make_solver("gl", model, scene, topology, {.damping = {.factor = 0.99}});
    const auto followed = make_display(*solver), given = make_display(model);
    EXPECT_TRUE(followed->zero_copy());
    const Camera camera = camera_for(model);
    const DisplayOptions options{
        .surface_opacity = 0.5, .particles = true, .attractors = with_attractors, .full_scale = 0.002};
    std::optional<Image> before;
    for (int frame = 0; frame < 3; ++frame) {
      ASSERT_TRUE(solver->step(40, 0.5 * solver->stable_step()).ok());
      const Image image = followed->render(camera, options, width, height);
      const State state = solver->read();
      ASSERT_GT(displacement_norms(model, state).max, 0.0);
      VecList attractor(with_attractors ? state.position.size() : 0);
      if (with_attractors) attractors(solver->topology(), state.position, attractor);
      given->show(state.position, attractor);
      EXPECT_LT(difference(image, given->render(camera, options, width, height)), 1e-3) << "frame " << frame;
      if (before) {
        EXPECT_GT(difference(image, *before), 1e-3);
      }
      before = image;
    }
  }
}

TEST_F(GlPictureTest, PlaneBodiesAndSinglePixelsHavePictures) {
  const Model strip = make_strip(0.04, 0.02, 4, 2);
  const auto display = make_display(strip);
  const Camera camera = framing(strip.rest, Vec3::UnitZ(), static_cast<double>(width) / height);
  EXPECT_GT(painted(display->render(camera, {}, width, height)), width * height / 3);
  EXPECT_EQ(display->render(camera, {}, 1, 1).rgba.size(), 4u);
  EXPECT_EQ(display->render(camera, {}, 33, 17).rgba.size(), 4u * 33u * 17u);
}

TEST_F(GlPictureTest, WrongUseIsRefusedInASentence) {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  const auto solver = make_solver("reference", model, scene);
  const auto followed = make_display(*solver), given = make_display(model);
  const Camera camera = camera_for(model);
  EXPECT_TRUE(refuses([&] { given->show(VecList(3)); }, "expected 4 positions"));
  EXPECT_TRUE(refuses([&] { followed->show(model.rest); }, "make one from the model"));
  EXPECT_TRUE(refuses([&] { given->render(camera, {}, 0, 10); }, "got 0 x 10"));
  EXPECT_TRUE(refuses([&] { given->render(camera, {}, 1'000'000, 10); }, "at most"));
  EXPECT_TRUE(refuses([&] { given->draw(camera, {}, 0, 0, 10, 10); }, "GlContext::current"));
  EXPECT_GT(painted(given->render(camera, {}, width, height)), 0);  // still works
}

}  // namespace
}  // namespace phymul::test

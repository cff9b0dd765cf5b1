// SPDX-License-Identifier: MIT
//
// Filling: shape of the cells, volume, what is refused, and a body that comes to rest.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "body/lattice.h"
#include "body_shapes.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

TEST(MakeBody, TenShapesHaveGoodCellsAndTheirVolume) {
  for (const FilledShape& shape : filled_shapes()) {
    SCOPED_TRACE(shape.name);
    const auto [model, report] = sound_body(shape.solid, {.spacing = shape.spacing});
    EXPECT_GT(report.particles, 1700);
    EXPECT_LT(report.particles, 3200);
    EXPECT_NEAR(report.volume, report.wanted_volume, 1e-3 * report.wanted_volume);
    EXPECT_LE(std::abs(report.moved), 0.05 * shape.spacing);
    if (shape.volume > 0.0) {
      EXPECT_NEAR(report.volume / shape.volume, 1.0, 0.005);
    }
    EXPECT_EQ(report.parts, 1);
  }
}

/// No few light particles set it: in steps in which a wave of pressure crosses the spacing of the particles' volume.
TEST(MakeBody, TenShapesHaveALongStep) {
  const Material tissue{.young = 5e3, .poisson = 0.45, .density = 1000};
  const double wave = std::sqrt(tissue.young * 0.55 / (1.45 * 0.1) / tissue.density);
  for (const FilledShape& shape : filled_shapes()) {
    SCOPED_TRACE(shape.name);
    BodyReport report;
    Model model = make_body(shape.solid, {.spacing = shape.spacing}, &report);
    set_material(model, tissue);
    const TopologyTextures tables = build_topology(model, {});
    const double step = stable_step(tables, estimate_spectrum(tables, model.rest), 1.0);
    EXPECT_GT(step * wave / std::cbrt(report.volume / report.particles), 0.87);
    EXPECT_GT(*std::ranges::min_element(model.mass), 0.04 * tissue.density * report.volume / report.particles);
  }
}

/// The surface that an organ was filled from shows it: no vertex is far outside of the coarser body.
TEST(MakeBody, AFinerSurfaceIsASkinOfIt) {
  const Model fine = make_body(bean(), {.spacing = 0.005}), organ = make_body(bean(), {.spacing = 0.012});
  const Skin skin(organ, fine.rest);
  EXPECT_GT(skin.farthest_outside(), 0.0);
  EXPECT_LT(skin.farthest_outside(), 0.6);
}

TEST(MakeBody, RandomSmoothShapesHaveGoodCells) {
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    sound_body(random_solid(seed), {.spacing = 0.009});
  }
}

TEST(MakeBodyOfManyShapes, NoCellIsInverted) {
  double smallest = 180.0, largest = 0.0;
  for (std::uint32_t seed = 100; seed < 1100; ++seed) {
    SCOPED_TRACE(seed);
    const auto [model, report] = sound_body(random_solid(seed), {.spacing = 0.008 + 0.004 * (seed % 10) / 10.0});
    smallest = std::min(smallest, report.smallest_angle);
    largest = std::max(largest, report.largest_angle);
  }
  RecordProperty("smallest_angle", std::to_string(smallest));
  RecordProperty("largest_angle", std::to_string(largest));
}

TEST(MakeBody, InnerParticlesShareALattice) {
  BodyReport report;
  const Model model = make_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.006}, &report);
  std::vector<char> at_surface(model.rest.size(), 0);
  for (const Index i : model.group("surface")) {
    at_surface[i] = 1;
    EXPECT_NEAR(model.rest[i].norm(), 0.05, 0.03 * 0.006);
  }
  int inner = 0;
  double sum = 0.0;
  for (Index i = 0; i < model.particle_count(); ++i) {
    const Index *begin = model.neighbours.begin(i), *end = model.neighbours.end(i);
    if (at_surface[i] || std::any_of(begin, end, [&](Index j) { return at_surface[j] != 0; })) continue;
    ASSERT_EQ(end - begin, 14);
    for (const Index* j = begin; j < end; ++j) sum += (model.rest[*j] - model.rest[i]).norm() / 14.0;
    ++inner;
  }
  ASSERT_GT(inner, 1000);
  EXPECT_NEAR(sum / inner, 0.006, 1e-9);
}

TEST(MakeBody, SurfacesFillAsTheSolidsDo) {
  const BodyReport of_surface = sound_body(ball_surface(0.05, 40), {.spacing = 0.0075}).report,
                   of_solid = sound_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.0075}).report;
  EXPECT_NEAR(of_surface.particles, of_solid.particles, 0.01 * of_solid.particles);
  EXPECT_NEAR(of_surface.volume / ball_volume(0.05), 1.0, 0.005);
  EXPECT_NEAR(of_surface.volume, of_surface.wanted_volume, 1e-6 * of_surface.wanted_volume);
}

/// Lattice points on faces, edges and corners of the surface: every tie there is.
TEST(MakeBody, LatticePointsOnTheSurfaceDoNoHarm) {
  const double edge = 0.01, spacing = edge * (8.0 * std::sqrt(0.75) + 6.0) / 14.0;
  for (const Vec3& sides : {Vec3(6, 5.5, 4.5), Vec3(6, 6, 6), Vec3(5.5, 5.5, 5.5)}) {
    for (const double shift : {0.0, 0.25, 1.0 / 3.0, 0.5, 0.75}) {
      SCOPED_TRACE(shift);
      const Vec3 low = shift * edge * Vec3::Ones();
      const auto [model, report] = sound_body(box_surface(low, low + edge * sides), {.spacing = spacing});
      EXPECT_EQ(report.parts, 1);
    }
  }
}

TEST(MakeBody, ShellsOfASurface) {
  // A cavity, whose triangles run the wrong way round: mended.
  BodyReport report;
  const Surface shell = both(ball_surface(0.05, 20), ball_surface(0.02, 12));
  const Model hollow = make_body(shell, {.spacing = 0.006}, &report);
  expect_sound(hollow, report);
  EXPECT_NEAR(report.volume / (ball_volume(0.05) - ball_volume(0.02)), 1.0, 0.01);
  EXPECT_TRUE(says(hollow.notes.front(), "1728 of 6528 triangles were clockwise"));
  // Two balls apart, and two that touch in one vertex.
  const Model apart =
      make_body(both(ball_surface(0.02, 12), ball_surface(0.02, 12, {0.05, 0, 0})), {.spacing = 0.004}, &report);
  expect_sound(apart, report);
  EXPECT_EQ(report.parts, 2);
  EXPECT_TRUE(says(apart.notes.back(), "2 parts"));
  const Model touching =
      make_body(both(ball_surface(0.02, 12), ball_surface(0.02, 12, {0.04, 0, 0})), {.spacing = 0.004}, &report);
  EXPECT_GT(report.smallest_angle, 10.0);
  EXPECT_NEAR(report.volume / (2.0 * ball_volume(0.02)), 1.0, 0.02);
}

/// Shells of one section that overlap along their length: no edge of one passes through a triangle of the other.
TEST(MakeBody, RefusesShellsThatOverlap) {
  const Surface left = box_surface({0, 0, 0}, {0.1, 0.05, 0.05}),
                right = box_surface({0.096, 0, 0}, {0.196, 0.05, 0.05});
  const auto filling = [](const Surface& surface) {
    return message_of([&] { make_body(surface, {.spacing = 0.003}); });
  };
  EXPECT_TRUE(says(filling(both(left, right)), "shells overlap at (0.098, "));
  EXPECT_TRUE(refuses([&] { solid_within(both(left, right)); }, "shells overlap at (0.098, "));
  // The triangle that says whether the second lies in the first does lie in it.
  Surface from_end = right;
  std::swap(from_end.triangles[0], from_end.triangles[6]);
  EXPECT_TRUE(says(filling(both(left, from_end)), "shells overlap at ("));
  // Those that touch along a whole face do not overlap.
  BodyReport report;
  make_body(both(left, box_surface({0.1, 0, 0}, {0.196, 0.05, 0.05})), {.spacing = 0.003}, &report);
  EXPECT_EQ(report.parts, 1);
  EXPECT_NEAR(report.volume / (0.196 * 0.05 * 0.05), 1.0, 0.01);
}

TEST(MakeBody, ASolidEndsAtItsBox) {
  const Vec3 low(-0.05, -0.05, -0.05), high(0.05, 0.05, 0.05);
  const Solid below{[](const Vec3&x) { return x.z(); }, low, high}, all{[](const Vec3&) { return -1.0; }, low, high};
  BodyReport report;
  expect_sound(make_body(below, {.spacing = 0.01}, &report), report);
  EXPECT_NEAR(report.wanted_volume, 0.5e-3, 0.005e-3);
  EXPECT_NEAR(report.volume, 0.5e-3, 0.005e-3);
  // As a part of others too.
  const Solid wide = solid_box({-0.1, -0.05, -0.05}, {0.1, 0.05, 0.05});
  make_body(solid_union({below, solid_ball({0.1, 0, 0}, 0.03)}), {.spacing = 0.01}, &report);
  EXPECT_NEAR(report.wanted_volume, 0.5e-3 + ball_volume(0.03), 0.006e-3);
  make_body(solid_difference(wide, all), {.spacing = 0.01}, &report);
  EXPECT_NEAR(report.wanted_volume, 1e-3, 0.01e-3);
}

TEST(MakeBody, ASurfaceEntersSolids) {
  BodyReport ball, hollow;
  make_body(ball_surface(0.05, 10), {.spacing = 0.01}, &ball);
  const Solid box = solid_box({-0.06, -0.06, -0.06}, {0.06, 0.06, 0.06}), within = solid_within(ball_surface(0.05, 10));
  make_body(solid_difference(box, within), {.spacing = 0.01}, &hollow);
  EXPECT_NEAR(hollow.wanted_volume, 0.12 * 0.12 * 0.12 - ball.wanted_volume, 1e-3 * ball.wanted_volume);
  EXPECT_NEAR(within.distance({0, 0, 0.01}), -0.04, 2e-3);
  const Surface twice = both(box_surface({0, 0, 0}, {1, 1, 1}), box_surface({1, 1, 0}, {2, 2, 1}));
  EXPECT_TRUE(refuses([&] { solid_within(twice); }, "solid_within: shells touch along the edge from (1"));
}

/// A triangle whose corners lie on one line up to rounding has a normal at random.
TEST(MakeBody, ASliverEntersNoSolid) {
  for (int k = 0; k < 30; ++k) {
    Surface box = box_surface({0, 0, 0}, {0.06, 0.05, 0.04});
    const auto [a, b, c] = box.triangles[0];
    const auto middle = static_cast<Index>(box.vertices.size());
    box.vertices.push_back(box.vertices[a] + 0.37 * (box.vertices[b] - box.vertices[a]));
    box.triangles[0] = {a, middle, c};
    box.triangles.insert(box.triangles.end(), {{middle, b, c}, {a, b, middle}});
    for (Vec3& x : box.vertices) x = Eigen::AngleAxisd(0.1 * k + 0.1, Vec3(1, 2, 3).normalized()) * x;
    EXPECT_TRUE(refuses([&] { solid_within(box); }, "has no area"));
  }
}

TEST(MakeBody, RefusesWhatCannotBeFilled) {
  const Solid ball = solid_ball({0, 0, 0}, 0.05);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto filling = [](const auto& shape, double spacing) {
    return message_of([&] { make_body(shape, {.spacing = spacing}); });
  };
  for (const double spacing : {0.0, -0.01, nan}) {
    EXPECT_TRUE(says(filling(ball, spacing), "expected a spacing above 0 m, got"));
  }
  EXPECT_TRUE(says(filling(ball, 1e-5), "take a larger spacing, or check the unit"));
  EXPECT_TRUE(refuses([&] { make_body(ball, {.spacing = 0.006, .most_particles = 4000}); }, "needs 4"));
  EXPECT_TRUE(says(filling(ball, 0.3), "no point of a lattice"));
  // A sheet of 1 mm beside a ball: the lattice of 8 mm misses it.
  const Surface sheet = box_surface({0.06, -0.1, -0.1}, {0.061, 0.1, 0.1});
  const std::string thin = filling(both(ball_surface(0.05, 10), sheet), 0.008);
  EXPECT_TRUE(says(thin, "thinner than the spacing are lost: 0.28", "m around (0.06"));
  Solid broken = ball;
  broken.distance = [=](const Vec3& x) { return x.x() > 0.02 ? nan : x.norm() - 0.05; };
  EXPECT_TRUE(says(filling(broken, 0.01), "not a number at (0.02"));
  EXPECT_TRUE(says(filling(Solid{}, 0.01), "no distance function"));
  Solid boxless = ball;
  boxless.high = boxless.low;
  EXPECT_TRUE(says(filling(boxless, 0.01), "low below high"));
  EXPECT_TRUE(refuses([&] { solid_union({ball, boxless}); }, "solid_union: expected a box"));
  EXPECT_TRUE(refuses([&] { solid_difference(ball, Solid{}); }, "solid_difference: a solid has no distance"));
  EXPECT_TRUE(refuses([&] { solid_difference(Solid{}, ball); }, "solid_difference: a solid has no distance"));
  EXPECT_TRUE(refuses([] { solid_ball({0, 0, 0}, 0.0); }, "radius above 0"));
  EXPECT_TRUE(refuses([] { solid_union({}); }, "at least one"));
}

/// However many particles are allowed. Refused before the solid is asked anything.
TEST(MakeBody, RefusesALatticeBeyondItsNumbers) {
  Solid ball = solid_ball({0, 0, 0}, 0.05);
  ball.distance = [](const Vec3&) -> double { throw Error("asked"); };
  const auto filling = [&](double spacing) {
    return message_of(
        [&] { make_body(ball, {.spacing = spacing, .most_particles = std::numeric_limits<Index>::max()}); });
  };
  EXPECT_TRUE(says(filling(5e-5), "the most that can be counted"));
  EXPECT_EQ(filling(5e-3), "asked");
}

/// Spikes from a point of the lattice towards its neighbours, between the lines that the volume is measured along.
TEST(MakeBody, RefusesAPartThatIsNotANumber) {
  const Solid ball = solid_ball({0, 0, 0}, 0.01), none{[](const Vec3&) { return std::nan(""); }, ball.low, ball.high};
  for (const Solid& solid : {solid_union({ball, none}), solid_intersection({ball, none}), solid_union({none, ball}),
                             solid_difference(ball, none)}) {
    EXPECT_TRUE(refuses([&] { make_body(solid, {.spacing = 0.004}); }, "distance is not a number at"));
  }
}

TEST(MakeBody, RefusesAVolumeOfNothing) {
  const double edge = 0.01, spacing = edge * CentredLattice::mean_length;
  const Vec3 point = Vec3::Constant(-0.25 * edge);
  std::vector<Solid> spikes;
  for (const Vec3& way :
       {Vec3(2, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 2), Vec3(1, 1, 1), Vec3(-1, 1, 1), Vec3(1, -1, 1), Vec3(1, 1, -1)}) {
    spikes.push_back(solid_capsule(point - 0.25 * edge * way, point + 0.25 * edge * way, 1e-6));
  }
  Solid star = solid_union(spikes);
  star.low = Vec3::Constant(-0.048);
  star.high = Vec3::Constant(0.048);
  EXPECT_TRUE(
      refuses([&] { make_body(star, {.spacing = spacing}); }, "expected a shape with a volume above 0, got 0 ml"));
}

TEST(MakeBody, ABallHeldAtAPatchComesToRest) {
  Model model = make_body(ball_surface(0.05, 16), {.spacing = 0.012});
  std::vector<Index> top;
  for (const Index i : model.group("surface")) {
    if (model.rest[i].z() > 0.035) top.push_back(i);
  }
  ASSERT_GT(top.size(), 10u);
  model.add_group("top", top);
  Simulation sim(model, {.material = {.young = 5e3, .poisson = 0.45, .density = 1000}, .backend = "cpu"});
  sim.scene().fix("top").gravity({0, 0, -9.81});
  const RestResult rest = sim.run_to_rest();
  EXPECT_TRUE(rest.converged()) << rest.message();
  EXPECT_LT(rest.folded, 0) << rest.message();
  // Its weight on a rod of its height and middle section would stretch it by rho g L^2 / 2 E.
  const double rod = 1000 * 9.81 * 0.1 * 0.1 / (2 * 5e3);
  EXPECT_GT(sim.max_displacement(), 0.2 * rod);
  EXPECT_LT(sim.max_displacement(), 2.0 * rod);
}

// What a body lacks of the shape that it was filled from, and which of its shells are one, is said.

/// A ball of 5 cm with a horn of 3 cm on top, less than 3 mm wide.
Surface horned_ball() {
  return cube_surface(60, [](const Vec3& x) {
    const Vec3 way = x.normalized();
    const double angle = std::acos(std::min(1.0, way.z())) / 0.02;
    return Vec3(way * (0.05 + 0.03 * std::exp(-angle * angle)));
  });
}

TEST(LostParts, AThinHornIsNamedWithPlaceAndLength) {
  // Of the 30 mm, without a spacing beside the ball. Where it is fine, only the tip is lost.
  const auto field = fine_near({0, 0, 0.07}, 0.02, 0.001, 0.008);
  const Model coarse = make_body(horned_ball(), {.spacing = 0.008}),
              fine = make_body(horned_ball(), {.spacing = 0.008, .spacing_at = field});
  EXPECT_TRUE(says(coarse.notes.at(0), "it: 0.018", " m around (0, 0, 0.0685", "than 0.008 m", "spacing_at"));
  EXPECT_TRUE(says(fine.notes.at(0), "it: 0.003", " m around (0, 0, 0.0757"));
  BodyReport report;
  for (const double spacing : {0.005, 0.008, 0.015}) {
    EXPECT_TRUE(make_body(ball_surface(0.05, 20), {.spacing = spacing}, &report).notes.empty());
    const double added = 4.0 * std::numbers::pi * 0.05 * 0.05 * report.moved;
    EXPECT_NEAR(report.volume - report.unmoved_volume, added, 0.1 * std::abs(added));
    EXPECT_TRUE(make_body(box_surface({0, 0, 0}, {0.1, 0.06, 0.08}), {.spacing = spacing}).notes.empty());
  }
}

/// A triangle of a drawn tube is as long as the tube and as wide as one of its many sides.
TEST(SampleSurface, OfAThinTriangleTakesFewSamples) {
  for (const int turn : {0, 1, 2}) {
    Surface thin{{Vec3(0.0, 0, 0), Vec3(1.0, 1e-3, 0.2), Vec3(1.0, -1e-3, 0.2)}, {{0, 1, 2}}, {}};
    std::ranges::rotate(thin.triangles[0], thin.triangles[0].begin() + turn);
    int samples = 0;
    const SurfacePatch patch = sample_surface(thin, 0.006, [&](const Vec3&) { return ++samples > 0; });
    EXPECT_LT(samples, 300);
    double area = 0.0;
    Vec3 moment = Vec3::Zero();
    for (std::size_t k = 0; k < patch.points.size(); ++k) {
      area += patch.areas[k];
      moment += patch.areas[k] * patch.points[k];
    }
    EXPECT_NEAR(area, 1e-3 * std::sqrt(1.04), 1e-12);
    EXPECT_LT((moment / area - Vec3(2.0, 0, 0.4) / 3.0).norm(), 1e-9);
    EXPECT_GT(patch.points.size(), 150u);
    EXPECT_TRUE(refuses([&] { sample_surface(thin, 1e-25, [](const Vec3&) { return true; }); }, "within 1e15 spac"));
  }
}

TEST(LostParts, ARefusalNamesTheCause) {
  const auto filling = [](const auto& shape, double spacing) {
    return message_of([&] { make_body(shape, {.spacing = spacing}); });
  };
  const LabelImage cube = painted(60, [](const Vec3& x) { return x.cwiseAbs().maxCoeff() < 0.028; });
  EXPECT_TRUE(
      says(filling(cube, 0.018), "12.", "(18.", " % less before its surface was moved)", "m edges and corners"));
  const LabelImage far = painted(60, [](const Vec3& x) { return x.norm() < 0.03 || x.x() > 0.056; });
  EXPECT_TRUE(says(filling(far, 0.018), "parts thinner than the spacing are lost: 0.16", "m around (0.057"));
  EXPECT_TRUE(says(filling(box_surface({0, 0, 0}, {0.03, 0.03, 0.03}), 0.01), "m edges and corners"));
  EXPECT_TRUE(says(filling(solid_box({0, 0, 0}, {0.03, 0.03, 0.03}), 0.01), "are lost, or edges and corners"));
}

/// A bag with walls of 2 mm.
TEST(LostParts, ShellsThatAreFusedAreNoted) {
  const Surface bag = both(ball_surface(0.02, 40), inside_out(ball_surface(0.018, 40)));
  EXPECT_TRUE(make_body(bag, {.spacing = 0.0008}).notes.empty());
  EXPECT_TRUE(says(make_body(bag, {.spacing = 0.0015}).notes.at(1), "fused",
                   "body's surface has shells: 1, Euler number: -74, edges of more than two faces: 78;",
                   "it fills has shells: 2, Euler number: 4, edges of more than two faces: 0"));
  EXPECT_TRUE(refuses([&] { make_body(bag, {.spacing = 0.0018}); }, "are lost: walls, gaps or holes"));
}

}  // namespace
}  // namespace phymul::test

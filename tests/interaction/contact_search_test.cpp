// SPDX-License-Identifier: MIT
//
// Which triangle of another body a particle meets, and on which side of it the particle is.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "interaction/contact_points.h"
#include "support/run_scenes.h"
#include "support/tool_backends.h"

namespace phymul {
namespace {

using namespace test;

Vec3 middle_of(const State& state, const std::vector<Index>& particles) {
  Vec3 sum = Vec3::Zero();
  for (const Index i : particles) sum += state.position[i];
  return sum / static_cast<double>(particles.size());
}

/// A cube of one cell, inside another body: its low corner, and its edge, m.
Model small_cube(const Vec3& at, double edge) {
  return moved(make_block(Vec3::Constant(edge), 1, 1, 1), at);
}

/// What contacts do to two bodies in a step from rest.
struct Effect {
  Vec3 way{0, 0, 0};  // m, of the middle of the small one
  bool none = false;  // no bit of any particle
};

/// Beside them is a body with edges of 6 cm, which touches neither.
Effect effect_of_contacts(const Model& big, const Model& small, const char* backend) {
  const Model coarse = small_cube({0, 0, 0.5}, 0.06);
  const Model model = merged({{"big", &big}, {"small", &small}, {"coarse", &coarse}});
  Scene scene(model);
  const auto solver = make_solver(backend, model, scene, {}, options_for({backend, 1}));
  State end[2];
  for (const bool touching : {false, true}) {
    if (touching) scene.contacts({.margin = 1e-4});
    solver->reset();
    EXPECT_TRUE(solver->step(1, 0.4 * solver->stable_step()).ok());
    end[touching] = solver->read();
  }
  const std::vector<Index> own = model.group("small");
  return {middle_of(end[1], own) - middle_of(end[0], own), end[0] == end[1]};
}

/// Inside is what has got no deeper than the longer edge of the two that meet, however coarse another body is.
TEST(ContactSearch, InsideIsAsDeepAsTheLongerEdgeOfTheTwo) {
  struct Case {
    int cells;           // of 3 cm along each axis
    double edge, depth;  // m; of the small cube, and of its top below the side
    bool inside;
  };
  const Case cases[] = {
      {6, 0.002, 0.0055, false}, {6, 0.002, 0.0045, true}, {5, 0.002, 0.0055, true}, {6, 0.006, 0.0055, true}};
  for (const char* backend : {"reference", "cpu"}) {
    for (const Case& c : cases) {
      const Model big = make_block({0.03, 0.03, 0.03}, c.cells, c.cells, c.cells);
      const double low = 0.015 - 0.5 * c.edge;
      const Effect effect = effect_of_contacts(big, small_cube({low, low, 0.03 - c.depth - c.edge}, c.edge), backend);
      SCOPED_TRACE(testing::Message() << backend << ", " << c.cells << " cells, " << c.edge << " m");
      EXPECT_EQ(effect.none, !c.inside);
      EXPECT_EQ(effect.way.z() > 1e-7, c.inside) << effect.way.transpose();
    }
  }
}

/// Two cells along x: sides across it have edges of 5 mm, the others of 20 mm.
TEST(ContactSearch, DeepBelowAFineSideNoCoarseOneLeadsOut) {
  const Model big = make_block({0.04, 0.02, 0.02}, 2, 4, 4);
  for (const char* backend : {"reference", "cpu"}) {
    const auto effect = [&](double below) {
      return effect_of_contacts(big, small_cube({0.039 - below, 0.011, 0.0095}, 0.001), backend);
    };
    EXPECT_GT(effect(0.003).way.x(), 1e-7) << backend;  // it came in there
    EXPECT_TRUE(effect(0.0065).none) << backend;        // 8 mm below a coarse side
    EXPECT_GT(effect(0.012).way.y(), 1e-7) << backend;  // the coarse side is the nearest
  }
}

/// A strip squashed to two fifths and folded over itself, its upper half on the way down: of its own body the far side
/// is nearer to each particle than what comes. Beside it is a coarse body.
TEST(ContactSearch, TheFarSideOfOnesOwnBodyHidesNoFold) {
  const Model strip = make_block({0.12, 0.01, 0.015}, 24, 2, 3), coarse = small_cube({0, 0, 0.5}, 0.06);
  const Model model = merged({{"strip", &strip}, {"coarse", &coarse}});
  constexpr double squash = 0.4, gap = 0.0075;  // gap: m, between 6 mm of either half
  std::vector<Index> low, high;                 // particles that face each other, along the middles of the halves
  State folded = rest_state(model);
  for (const Index i : model.group("strip")) {
    const Vec3& X = model.rest[i];
    Vec3& x = folded.position[i];
    x.z() = squash * X.z();
    if (X.x() > 0.0575) x = {0.1163 - X.x(), X.y() + 0.0003, 2.0 * squash * 0.015 + gap - x.z()};
    const bool facing = X.z() > 0.0149 && std::abs(X.y() - 0.005) < 0.001;
    if (facing && X.x() < 0.041) low.push_back(i);
    if (facing && X.x() > 0.079) high.push_back(i);
  }
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene(model);
    const auto solver = make_solver(backend, model, scene, {}, options_for({backend, 1}));
    double apart[2] = {0.0, 0.0};
    for (const bool touching : {false, true}) {
      if (touching) scene.contacts({.friction = 0.0});
      const double dt = 0.01 * solver->stable_step();  // short, so that they hardly spring back
      State state = folded;
      for (const Index i : model.group("strip")) {
        if (model.rest[i].x() > 0.0575) state.velocity[i].z() = -(gap + 0.003) / dt;
      }
      solver->reset(state);
      EXPECT_TRUE(is_ok(solver->step(1, dt))) << backend;
      const State end = solver->read();
      apart[touching] = middle_of(end, high).z() - middle_of(end, low).z();
    }
    EXPECT_LT(apart[0], -0.002) << backend;
    EXPECT_GT(apart[1], 0.0005) << backend;
  }
}

/// A body all in one point, a particle of another one on it: no triangle has a normal, and the point gives no
/// direction.
TEST(ContactSearch, TrianglesWithoutAreaGiveNoDirection) {
  const double size = 0x1p-6;  // m; places are exact in floats too
  const Model low = small_cube({0, 0, 0}, size), high = small_cube({0, 0, 2 * size}, size);
  const Model model = merged({{"low", &low}, {"high", &high}});
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = Scene(model).contacts({});
    const auto solver = make_solver(backend, model, scene, {}, options_for({backend, 1}));
    State state = rest_state(model);
    for (const Index i : model.group("high")) state.position[i] = model.rest[model.group("low").front()];
    solver->reset(state);
    EXPECT_TRUE(is_ok(solver->step(20, 0.4 * solver->stable_step()))) << backend;
    for (const Vec3& x : solver->read().position) EXPECT_LT(x.norm(), 10 * size) << backend;
  }
}

/// A particle above three triangles, each of which is nearest with a corner, by `step` edges further than the one
/// before and facing the particle more. In any `order` of their rows and sides; they hang on a fourth one far below.
struct NearTriangles {
  NearTriangles(double step, const std::array<int, 3>& order) {
    constexpr double facing[] = {0.3, 0.6, 0.9};
    Model low;
    for (int k = 0; k < 3; ++k) {
      const double around = 2.0 * order[k];  // rad
      const Vec3 down = Vec3(0.3 * std::cos(around), 0.3 * std::sin(around), -1.0).normalized();
      const Vec3 across = down.cross(Vec3::UnitZ()).normalized(), aside = across.cross(down);
      const Vec3 along = std::sqrt(1.0 - facing[k] * facing[k]) * down - facing[k] * aside;
      const Vec3 corner = place + (distance + k * step * edge) * down;
      low.rest.insert(low.rest.end(), {corner, corner + edge * (0.8 * along + 0.5 * across),
                                       corner + edge * (0.8 * along - 0.5 * across)});
    }
    for (const int k : order) add(low, CellType::triangle, {3 * k, 3 * k + 1, 3 * k + 2});
    add(low, CellType::triangle, {1, 4, 7});
    Model high;
    high.rest = {place, place + Vec3(0, 0, edge)};
    add(high, CellType::line, {0, 1});
    finish(low);
    finish(high);
    model = merged({{"low", &low}, {"high", &high}});
  }

  static void add(Model& model, CellType type, std::vector<Index> particles) {
    model.cells.push_back({.type = type, .particles = std::move(particles)});
  }

  /// Masses, stiffnesses and neighbours for its cells.
  static void finish(Model& model) {
    model.mass.assign(model.rest.size(), 1e-3);
    model.stiffness.assign(model.rest.size(), 1.0);
    model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  }

  /// Which of the three the particle pushes when it comes down.
  std::vector<int> pushed(const std::string& backend) const {
    Scene scene = Scene(model).contacts({.friction = 0.0, .rounds = 1});
    const auto solver = make_solver(backend, model, scene, {.on_sparse = SparseParticle::springs}, {});
    State state = rest_state(model);
    state.velocity[model.group("high").front()] = {0, 0, -1e-3};
    solver->reset(state);
    EXPECT_TRUE(solver->step(1, 1e-3 * solver->stable_step()).ok());
    std::vector<int> who;
    for (int k = 0; k < 3; ++k) {
      if (solver->read().velocity[model.group("low")[3 * k]].norm() > 1e-5) who.push_back(k);
    }
    return who;
  }

  static constexpr double edge = 0.01, distance = 0.0005;  // m
  Vec3 place{0.011, 0.0123, 0.0217};
  Model model;
};

/// Distances that are all but the same, one after the other: of those the triangle that faces the particle most says
/// where it is, whichever comes first. Where they differ the nearest does.
class NearTrianglesIn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(NearTrianglesIn);

TEST_P(NearTrianglesIn, WhichIsMetDoesNotDependOnTheirOrder) {
  std::array<int, 3> order{0, 1, 2};
  do {
    SCOPED_TRACE(testing::PrintToString(order));
    for (const double step : {0.8e-9, 0.8e-6}) {
      if (step < 1e-8 && GetParam().starts_with("gl")) continue;  // floats do not know it
      EXPECT_EQ(NearTriangles(step, order).pushed(GetParam()), std::vector<int>{2}) << step;
    }
    EXPECT_EQ(NearTriangles(1e-4, order).pushed(GetParam()), std::vector<int>{0});
  } while (std::next_permutation(order.begin(), order.end()));
}

/// A particle 4 mm outside of the edge of a wedge of 40 degrees, between the normals of its faces, one of which is far
/// larger: nearest to both in the edge, it is outside by the face that it sees better, and touches nothing.
struct BesideAnEdge {
  BesideAnEdge(double one_side, double other_side) {
    constexpr double angle = 40.0 * std::numbers::pi / 180.0, high = 0.01, beyond = 0.14;  // rad, m
    const Vec3 one(one_side, 0, 0), other(other_side * std::cos(angle), other_side * std::sin(angle), 0);
    Model wedge;
    for (const double z : {0.0, high}) {
      for (const Vec3& corner : {Vec3(0, 0, 0), one, other}) wedge.rest.push_back(corner + z * Vec3::UnitZ());
    }
    NearTriangles::add(wedge, CellType::wedge, {0, 1, 2, 3, 4, 5});
    const double at = 0.5 * std::numbers::pi + angle + beyond;
    place = 0.004 * Vec3(std::cos(at), std::sin(at), 0) + 0.5 * high * Vec3::UnitZ();
    Model near;
    near.rest = {place, place + Vec3(-0.007, 0.007, 0)};
    NearTriangles::add(near, CellType::line, {0, 1});
    NearTriangles::finish(wedge);
    NearTriangles::finish(near);
    model = merged({{"wedge", &wedge}, {"near", &near}});
  }

  Vec3 place;
  Model model;
};

TEST_P(NearTrianglesIn, ALargeFaceDoesNotHideASmallOneAtTheirEdge) {
  for (const auto& [one, other] : {std::pair{0.05, 0.01}, std::pair{0.01, 0.05}}) {
    const BesideAnEdge beside(one, other);
    Scene scene = Scene(beside.model).contacts({.friction = 0.0, .margin = 1e-4, .rounds = 1});
    const auto solver = make_solver(GetParam(), beside.model, scene, {.on_sparse = SparseParticle::springs}, {});
    EXPECT_TRUE(solver->step(5, 0.05 * solver->stable_step()).ok());
    EXPECT_EQ((solver->read().position[beside.model.group("near").front()] - beside.place).norm(), 0.0) << one;
  }
}

/// Of random triangles on their way through a box: what is in it is found, as the integrals of another rule have it,
/// and what pushes it out is minus half the gradient of the squared depth, without jumps.
TEST(DepthInBox, IsThatOfTheWholeTriangleAndPushesAlongItsGradient) {
  const Vec3 half(0.01, 0.012, 0.002);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int inside = 0;
  for (int trial = 0; trial < 200; ++trial) {
    BoxPlanes box{-half, half};
    if (trial % 2 == 1) box.low.z() *= 1.5;
    std::array<Vec3, 3> at;
    for (Vec3& corner : at) corner = 0.015 * Vec3(unit(random), unit(random), 0.3 * unit(random));
    const Vec3 way = 1e-5 * Vec3(unit(random), unit(random), unit(random));
    const double area = 0.5 * (at[1] - at[0]).cross(at[2] - at[0]).norm();
    double before = -1.0;
    for (int step = 0; step < 20; ++step) {
      for (Vec3& corner : at) corner += way;
      const DepthInBox in = depth_in(box, at, area);
      double square = 0.0;
      Mat3 push = Mat3::Zero();
      Vec3 load = Vec3::Zero();
      integrate_depth(box, at, area, [&](const DepthPoint& point) {
        const Vec3 own = point.weight * point.depth * Vec3(point.share[0], point.share[1], point.share[2]);
        square += point.weight * point.depth * point.depth;
        push.row(point.face / 2) += (point.face % 2 == 0 ? 1.0 : -1.0) * own.transpose();
        load += own;
      });
      EXPECT_NEAR(in.square, square, 1e-10 * area * half.z() * half.z()) << trial;
      EXPECT_LT((in.push - push).norm(), 1e-10 * area * half.z()) << trial;
      EXPECT_LT((in.load - load).norm(), 1e-10 * area * half.z()) << trial;
      EXPECT_NEAR(in.whole, in.load.sum(), 1e-10 * area * half.z()) << trial;
      inside += in.square > 0.0;
      // The triangle's area times what it goes deeper by, and the depth times the area that comes in.
      if (before >= 0.0) {
        ASSERT_NEAR(in.whole, before, 4.0 * way.norm() * (area + 0.03 * half.z())) << trial;
      }
      before = in.whole;
    }
    const DepthInBox in = depth_in(box, at, area);
    for (std::size_t c = 0; c < 3; ++c) {
      for (int axis = 0; axis < 3; ++axis) {
        constexpr double by = 1e-7;
        auto ahead = at, behind = at;
        ahead[c][axis] += by;
        behind[c][axis] -= by;
        // `area` is that at rest: it stays.
        const double slope = (depth_in(box, ahead, area).square - depth_in(box, behind, area).square) / (2.0 * by);
        EXPECT_NEAR(in.push(axis, static_cast<Eigen::Index>(c)), -0.5 * slope, 1e-4 * area * half.z()) << trial;
      }
    }
  }
  EXPECT_GT(inside, 1000);
}

/// A triangle as near to one face as to another all over is pressed by one of them; corners on planes leave no points
/// without a weight.
TEST(DepthInBox, TiesAndCornersOnPlanesAreNoHoles) {
  const BoxPlanes cube{Vec3::Constant(-0.01), Vec3::Constant(0.01)};
  const std::array<Vec3, 3> between{Vec3(0.004, 0, 0.004), Vec3(0.006, 0.001, 0.006), Vec3(0.006, -0.001, 0.006)};
  const std::array<Vec3, 3> at_planes{Vec3(0.01, 0, 0), Vec3(0.005, 0.001, 0.005), Vec3(0.002, -0.001, 0.0)};
  for (const auto& at : {between, at_planes}) {
    const double area = 0.5 * (at[1] - at[0]).cross(at[2] - at[0]).norm();
    EXPECT_GT(depth_in(cube, at, area).square, 0.0);
    double covered = 0.0;
    integrate_depth(cube, at, area, [&](const DepthPoint& point) {
      covered += point.weight;
      EXPECT_GT(point.weight + point.line_weight, 0.0);
    });
    EXPECT_NEAR(covered, area, 1e-9 * area);
  }
}

/// Below one face: the integral of a linear depth, squared, and its derivatives by the corners.
TEST(DepthInBox, IntegralsOverTheDepthAreExact) {
  const BoxPlanes box{-Vec3(0.05, 0.05, 0.01), Vec3(0.05, 0.05, 0.01)};
  const std::array<Vec3, 3> at{Vec3(0, 0, 0.009), Vec3(0.01, 0, 0.007), Vec3(0, 0.01, 0.004)};
  const Vec3 depth(0.001, 0.003, 0.006);
  double squared = 0.0;
  Vec3 by_corner = Vec3::Zero();
  integrate_depth(box, at, 5e-5, [&](const DepthPoint& point) {
    squared += point.weight * point.depth * point.depth;
    by_corner += 2.0 * point.weight * point.depth * Vec3(point.share[0], point.share[1], point.share[2]);
  });
  const double mixed = depth[0] * depth[1] + depth[1] * depth[2] + depth[2] * depth[0];
  EXPECT_NEAR(squared, 5e-5 / 6.0 * (depth.squaredNorm() + mixed), 1e-9 * squared);
  const Vec3 wanted = 5e-5 / 6.0 * (depth + Vec3::Constant(depth.sum()));
  EXPECT_LT((by_corner - wanted).norm(), 1e-9 * wanted.norm());
}

}  // namespace

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Skins: points that move with the cells they lie in.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <limits>

#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

/// A cube of six pyramids, their common apex off its middle.
Model leaning_pyramids() {
  Model model = make_block({0.02, 0.02, 0.02}, 1, 1, 1);
  std::vector<Index> corner = model.cells.front().particles;
  const auto apex = static_cast<Index>(model.rest.size());
  model.rest.emplace_back(0.011, 0.009, 0.0105);
  model.cells.clear();
  for (const std::array<int, 4>& face : std::vector<std::array<int, 4>>{
           {0, 1, 2, 3}, {7, 6, 5, 4}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}) {
    Cell cell;
    cell.type = CellType::pyramid;
    for (const int v : face) cell.particles.push_back(corner[v]);
    cell.particles.push_back(apex);
    model.cells.push_back(cell);
  }
  return model;
}

Model jittered_block() {
  Model block = make_block({0.1, 0.06, 0.04}, 4, 3, 2);
  jitter(block, 0.1, 3);
  return block;
}

std::vector<Model> one_of_each_cell() {
  return {jittered_block(), make_tetrahedral_block({0.1, 0.06, 0.04}, 4, 3, 2, 0.2, 1),
          make_cylinder(0.03, 0.08, 2, 8, 5), leaning_pyramids()};
}

/// Places in the box of the body, some of them outside of a round one.
VecList places_in_the_box(const Model& model, int count, std::uint32_t seed) {
  Vec3 low = model.rest.front(), high = low;
  for (const Vec3& p : model.rest) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::mt19937 bits(seed);
  VecList places;
  for (int k = 0; k < count; ++k) {
    places.push_back(0.5 * (low + high) + 0.5 * (high - low).cwiseProduct(test::random_vector(bits, 3)));
  }
  return places;
}

TEST(Skin, StartsWhereItWasBoundAndFollowsEvenStrainExactly) {
  Mat3 slope;
  slope << 1.2, 0.2, 0.3, -0.4, 0.8, 0.1, 0.2, -0.3, 1.1;
  for (const Model& model : one_of_each_cell()) {
    const VecList places = places_in_the_box(model, 200, 5);
    const Skin skin(model, places);
    ASSERT_EQ(skin.size(), places.size());
    VecList strained = model.rest;
    for (Vec3& p : strained) p = slope * p + Vec3(0.01, 0.02, 0.03);
    const VecList at_rest = skin.deform(model.rest), moved = skin.deform(strained);
    for (std::size_t k = 0; k < places.size(); ++k) {
      EXPECT_LT((at_rest[k] - places[k]).norm(), 1e-13) << k;
      EXPECT_LT((moved[k] - slope * places[k] - Vec3(0.01, 0.02, 0.03)).norm(), 1e-13) << k;
    }
  }
}

/// The cell's own vertices carry a point inside it: all weights between 0 and 1.
TEST(Skin, PointsInsideAreMeansOfTheCellTheyAreIn) {
  for (const Model& model : one_of_each_cell()) {
    VecList middles;
    for (const Cell& cell : model.cells) {
      Vec3 sum = Vec3::Zero();
      for (const Index i : cell.particles) sum += model.rest[i] / static_cast<double>(cell.particles.size());
      middles.push_back(sum);
    }
    const Skin skin(model, middles);
    EXPECT_EQ(skin.farthest_outside(), 0.0);
    for (std::size_t c = 0; c < middles.size(); ++c) {
      std::vector<Index> found(skin.particles(c).begin(), skin.particles(c).end());
      EXPECT_EQ(found, model.cells[c].particles);
      double sum = 0.0;
      for (const double weight : skin.weights(c)) {
        EXPECT_GT(weight, 0.0);
        sum += weight;
      }
      EXPECT_NEAR(sum, 1.0, 1e-14);
    }
  }
}

/// A visible surface is rarely inside its body: points a little outside keep their distance from it.
TEST(Skin, PointsOutsideMoveWithTheNearestCell) {
  const Model block = make_block({0.1, 0.1, 0.1}, 10, 10, 10);
  const Skin skin(block, VecList{{0.1025, 0.042, 0.057}});
  EXPECT_NEAR(skin.farthest_outside(), 0.25, 1e-12);
  VecList raised = block.rest;
  for (Vec3& p : raised) {
    if (p.x() > 0.085 && p.y() < 0.051) p.z() += 0.003;
  }
  EXPECT_NEAR((skin.deform(raised)[0] - Vec3(0.1025, 0.042, 0.060)).norm(), 0.0, 1e-15);
}

TEST(Skin, SaysHowFarPointsAreBeyondEachSide) {
  Model pyramid;
  pyramid.rest = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};
  pyramid.mass.assign(5, 1.0);
  pyramid.cells.push_back({CellType::pyramid, {0, 1, 2, 3, 4}});
  const auto beyond = [](const Model& model, const Vec3& x) { return Skin(model, VecList{x}).farthest_outside(); };
  // It gets narrower upwards: by as much of its size there.
  for (const Vec3& x : VecList{{0.3, 0.3, -0.2}, {0.5, 0.5, 1.2}, {0.85, 0.5, 0.5}, {0.5, 0.15, 0.5}}) {
    EXPECT_NEAR(beyond(pyramid, x), 0.2, 1e-9) << x.transpose();
  }
  const Model block = make_block({0.1, 0.1, 0.1}, 10, 10, 10);
  for (int side = 0; side < 6; ++side) {
    Vec3 place(0.042, 0.057, 0.034);
    place[side / 2] = side % 2 == 0 ? -0.003 : 0.103;
    EXPECT_NEAR(beyond(block, place), 0.3, 1e-9) << side;
  }
}

TEST(Skin, RefusesWhatDoesNotBelongToTheBody) {
  const Model block = make_block({0.1, 0.1, 0.1}, 2, 2, 2);
  const auto refusal = [&](const Model& model, const Vec3& point) {
    return message_of([&] { Skin(model, VecList{{0.05, 0.05, 0.05}, point}, 0.5); });
  };
  EXPECT_EQ(refusal(block, {0.1249, 0.05, 0.05}), "(no error)");
  EXPECT_EQ(refusal(block, {0.1251, 0.05, 0.05}),
            "Skin: point 1 at (0.1251, 0.05, 0.05) m is not within 0.5 cells of the body; expected points in the frame "
            "and units (m) of Model::rest. Where the body lacks a thin part, take a smaller spacing or a larger "
            "most_outside");
  const Skin beyond_a_corner(make_tetrahedron(1.0), VecList{});
  EXPECT_EQ(beyond_a_corner.size(), 0u);
  EXPECT_NE(refusal(block, {100, 50, 50}), "(no error)");
  EXPECT_NE(refusal(block, {0, std::numeric_limits<double>::quiet_NaN(), 0}), "(no error)");
  EXPECT_EQ(refusal(make_strip(0.1, 0.1, 2, 2), {0, 0, 0}),
            "Skin: the body has no volume cells, between whose particles a point could move");
  Model damaged = block;
  damaged.cells[3].particles[2] = 27;
  EXPECT_TRUE(says(refusal(damaged, {0.05, 0.05, 0.05}), "27"));
  const Skin skin(block, VecList{{0.05, 0.05, 0.05}});
  EXPECT_EQ(message_of([&] { skin.deform(VecList(26, Vec3::Zero())); }),
            "Skin::deform: expected the positions of 27 particles, got 26");
}

// The state of one body on another of the same shape.

Model ball_fine_at(const Vec3& place) {
  return make_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.016, .spacing_at = fine_near(place, 0.01, 0.004, 0.016)});
}

TEST(StateTransfer, KeepsRigidMotionAndUniformStrain) {
  const Model from = ball_fine_at({0.05, 0, 0}), to = ball_fine_at({-0.05, 0, 0});
  const Mat3 turn = Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Mat3 motion = turn * Vec3(1.2, 0.9, 0.95).asDiagonal();
  const Vec3 away(0.1, -0.2, 0.3), spin(3, -2, 1);
  const auto moved = [&](const Model& model) {
    State state{2.5, {}, {}};
    for (const Vec3& x : model.rest) {
      state.position.push_back(motion * x + away);
      state.velocity.push_back(spin.cross(x) + away);
    }
    return state;
  };
  State state = moved(from);
  state.tools.push_back({.name = "probe", .pose = {.position = {1, 2, 3}}, .placed = false});
  const State there = StateTransfer(from, to)(state), expected = moved(to);
  EXPECT_EQ(there.time, 2.5);
  ASSERT_EQ(there.position.size(), to.rest.size());
  ASSERT_EQ(there.velocity.size(), to.rest.size());
  for (std::size_t i = 0; i < to.rest.size(); ++i) {
    ASSERT_LT((there.position[i] - expected.position[i]).norm(), 1e-12);
    ASSERT_LT((there.velocity[i] - expected.velocity[i]).norm(), 1e-12);
  }
  ASSERT_EQ(there.tools.size(), 1u);
  EXPECT_EQ(there.tools[0].pose.position, Vec3(1, 2, 3));
  EXPECT_TRUE(there.tools[0].placed);
}

TEST(StateTransfer, RefusesWhatNamesParticles) {
  const Model body = make_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.02});
  const State rest = rest_state(body);
  const StateTransfer transfer(body, body);
  const auto message = [&](const State& state) { return message_of([&] { transfer(state); }); };
  EXPECT_EQ(message(rest), "(no error)");
  State state = rest;
  state.velocity.pop_back();
  EXPECT_TRUE(says(message(state), "expected positions and velocities of "));
  state = rest;
  state.tools.push_back({.name = "hook", .held = {0}, .held_at = {Vec3::Zero()}});
  EXPECT_TRUE(says(message(state), "the tool \"hook\" holds particles, which"));
  state = rest;
  state.tools.push_back({.name = "needle"});
  state.tools[0].needle.hole.emplace_back();
  EXPECT_TRUE(says(message(state), "the needle \"needle\" is in the body"));
  state = rest;
  state.joints.push_back({"suture", {1}});
  EXPECT_TRUE(says(message(state), "the joint \"suture\" has broken springs"));
  Model far = body;
  for (Vec3& x : far.rest) x.x() += 1.0;
  EXPECT_TRUE(refuses([&] { StateTransfer(body, far); }, "not within 1 cells of the body"));
}

/// Both bodies are cut in two, and one half has gone: each particle of the other body goes with its own half.
TEST(StateTransfer, KeepsACutOpen) {
  const CutSurface plane = cut_plane({0.031, 0, 0}, {1, 0.2, 0.1});
  const auto cut = [&](int n, std::uint32_t seed) {
    return cut_body(make_tetrahedral_block({0.06, 0.04, 0.03}, 2 * n, n + 1, n, 0.2, seed), plane);
  };
  const auto gone = [&](const Model& model) {
    State state = rest_state(model);
    const std::vector<ConnectedBody> halves = connected_bodies(model);
    EXPECT_EQ(halves.size(), 2u);
    for (const ConnectedBody& half : halves) {
      double distance = 0.0;
      for (const Index row : half.cells) distance += plane.distance(model.rest[model.cells[row].particles[0]]);
      for (const Index i : half.particles) state.position[i].z() += distance > 0.0 ? 0.02 : 0.0;
    }
    return state;
  };
  for (const auto& [from, to] : {std::pair{cut(3, 7), cut(5, 3)}, {cut(5, 3), cut(3, 7)}, {cut(4, 1), cut(4, 1)}}) {
    const State there = StateTransfer(from, to)(gone(from)), expected = gone(to);
    int wrong = 0;
    for (std::size_t i = 0; i < to.rest.size(); ++i) {
      wrong += (there.position[i] - expected.position[i]).norm() > 1e-9 ? 1 : 0;
    }
    EXPECT_EQ(wrong, 0) << "of " << to.rest.size();
  }
}

/// Spare particles, and those where a hole is that both bodies have.
TEST(StateTransfer, LeavesParticlesWithoutMassAtRest) {
  const auto holed = [](int n) {
    Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.04}, n + 2, n, n, 0.2, 3), 5),
                   {.material = {5e3, 0.4, 1000.0}, .backend = "reference"});
    sim.remove_cells(sim.model().cells_in([](const Vec3& x) { return x.x() < 0.025; }));
    return sim.model();
  };
  const Model from = holed(7), to = holed(8);
  ASSERT_GT(std::ranges::count(to.mass, 0.0), 80);
  State state = rest_state(from);
  for (Vec3& x : state.position) x.z() += 0.01;
  for (Vec3& v : state.velocity) v.z() = 1.0;
  const State there = StateTransfer(from, to, 2.0)(state);
  for (std::size_t i = 0; i < to.rest.size(); ++i) {
    const double moved = to.mass[i] > 0.0 ? 1.0 : 0.0;
    ASSERT_NEAR(there.position[i].z() - to.rest[i].z(), 0.01 * moved, 1e-12) << i;
    ASSERT_NEAR(there.velocity[i].z(), moved, 1e-12) << i;
  }
}

TEST(StateTransfer, CarriesThreadsAndFluidsAlong) {
  const Model body = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  State state = rest_state(body);
  state.threads.push_back({.name = "suture", .position = {{0, 0, 1}, {0, 0, 2}}, .tension = {0.5}});
  state.fluids.push_back({.name = "bile", .volume = 2e-5, .pressure = 30.0});
  const StateTransfer transfer(body, body);
  EXPECT_EQ(transfer(state).threads, state.threads);
  EXPECT_EQ(transfer(state).fluids, state.fluids);
  state.threads[0].sewn.push_back(at_particle(3));
  EXPECT_TRUE(refuses([&] { transfer(state); }, "a needle has sewn the thread \"suture\", which names particles"));
  state.threads.clear();
  state.tools.push_back({.name = "scalpel"});
  state.tools[0].blade.push_back({.place = 0, .cell = 3});
  EXPECT_TRUE(refuses([&] { transfer(state); }, "the blade \"scalpel\" is in the body"));
}

}  // namespace

}  // namespace phymul::test

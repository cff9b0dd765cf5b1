// SPDX-License-Identifier: MIT
//
// Bodies whose spacing varies in space: cells that fit to each other, angles, where they are fine, what is refused, and
// that a material keeps its laws on them.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "body/filling.h"
#include "body/graded_lattice.h"
#include "body_shapes.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

/// Fine at a place on the surface, by 2, 4 or 8.
BodyOptions random_grading(std::uint32_t seed) {
  std::mt19937 bits(seed + 7);
  const Vec3 place = 0.05 * random_vector(bits, 3).normalized();
  const double spacing = 0.01 + 0.008 * std::abs(uniform(bits)), radius = 0.004 + 0.012 * std::abs(uniform(bits));
  const double growth = 0.3 + std::abs(uniform(bits));
  return {.spacing = spacing, .spacing_at = fine_near(place, radius, spacing / (2 << seed % 3), spacing, growth)};
}

/// Every face of the lattice belongs to two tetrahedra, but for those with an edge at the box: beyond them nothing is
/// made. Points of a tetrahedron belong to leaves that differ by one halving at most.
TEST(GradedBody, TetrahedraOfTheLatticeShareWholeFaces) {
  for (const double growth : {0.2, 0.7, 3.0}) {
    const BodyOptions options{.spacing = 0.02,
                              .spacing_at = fine_near({0.013, 0.004, -0.007}, 0.006, 0.0025, 0.02, growth)};
    GradedLattice lattice(lattice_over(Vec3::Constant(-0.05), Vec3::Constant(0.05), options), options);
    lattice.number_points();
    std::vector<std::array<Index, 3>> faces;
    double finest = 1.0, coarsest = 0.0;
    for (const Tetrahedron& cell : lattice.cells()) {
      const auto side = [&](int k) { return Vec3(lattice.place(cell[k]) - lattice.place(cell[0])); };
      ASSERT_GT(side(3).dot(side(1).cross(side(2))), 0.0);
      double low = 1.0, high = 0.0;
      for (int k = 0; k < 4; ++k) {
        low = std::min(low, lattice.leaf_edge(cell[k]));
        high = std::max(high, lattice.leaf_edge(cell[k]));
        faces.push_back({cell[(k + 1) % 4], cell[(k + 2) % 4], cell[(k + 3) % 4]});
        std::ranges::sort(faces.back());
      }
      ASSERT_LE(high, 2.0 * low);
      finest = std::min(finest, low);
      coarsest = std::max(coarsest, high);
    }
    EXPECT_EQ(finest, 0.125);
    EXPECT_EQ(coarsest, 1.0);
    std::ranges::sort(faces);
    const auto& [x, y, z] = lattice.roots().count;
    const Vec3 low = lattice.roots().origin, high = low + lattice.roots().edge * Vec3(x - 1, y - 1, z - 1);
    for (std::size_t from = 0, to = 0; from < faces.size(); from = to) {
      for (to = from + 1; to < faces.size() && faces[to] == faces[from];) ++to;
      ASSERT_LE(to - from, 2u);
      if (to - from == 2) continue;
      int at_box = 0;
      for (const Index p : faces[from]) {
        const Vec3 at = lattice.place(p);
        at_box += std::min((at - low).minCoeff(), (high - at).minCoeff()) < 1e-9;
      }
      ASSERT_EQ(at_box, 2);
    }
  }
}

TEST(GradedBody, RandomShapesHaveGoodCells) {
  for (std::uint32_t seed = 0; seed < 9; ++seed) {
    SCOPED_TRACE(seed);
    const BodyOptions options = random_grading(seed);
    const auto [model, report] = sound_body(random_solid(seed), options);
    EXPECT_EQ(report.parts, 1);
    EXPECT_NEAR(report.volume, report.wanted_volume, 1e-3 * report.wanted_volume);
    EXPECT_NEAR(report.largest_spacing, options.spacing, 1e-12);
    EXPECT_NEAR(report.smallest_spacing, options.spacing / (2 << seed % 3), 1e-12);
  }
}

TEST(GradedBodyOfManyShapes, NoCellIsThin) {
  double smallest = 180.0, largest = 0.0;
  for (std::uint32_t seed = 100; seed < 600; ++seed) {
    SCOPED_TRACE(seed);
    const auto [model, report] = sound_body(random_solid(seed), random_grading(seed));
    smallest = std::min(smallest, report.smallest_angle);
    largest = std::max(largest, report.largest_angle);
  }
  RecordProperty("smallest_angle", std::to_string(smallest));
  RecordProperty("largest_angle", std::to_string(largest));
}

TEST(GradedBody, OfOneSpacingIsTheUniformBody) {
  const Solid solid = random_solid(3);
  const Model uniform_body = make_body(solid, {.spacing = 0.012});
  const Model same = make_body(solid, {.spacing = 0.012, .spacing_at = [](const Vec3&) { return 0.5; }});
  EXPECT_EQ(same.rest, uniform_body.rest);
  ASSERT_EQ(same.cells.size(), uniform_body.cells.size());
  for (std::size_t row = 0; row < same.cells.size(); ++row) {
    ASSERT_EQ(same.cells[row].particles, uniform_body.cells[row].particles);
  }
}

/// Edges are as long as asked for: inside the fine ball, and far from it.
TEST(GradedBody, IsFineWhereItIsAsked) {
  const Vec3 place(0, 0, 0.05);
  const auto [model, report] =
      sound_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.016, .spacing_at = fine_near(place, 0.01, 0.002, 0.016)});
  EXPECT_LT(12.0 * report.particles, report.volume / std::pow(0.002, 3));
  std::array<double, 2> sum{}, count{};
  for (Index i = 0; i < model.particle_count(); ++i) {
    const double away = (model.rest[i] - place).norm();
    if (away > 0.01 && away < 0.08) continue;
    for (const Index* j = model.neighbours.begin(i); j < model.neighbours.end(i); ++j) {
      sum[away > 0.01] += (model.rest[*j] - model.rest[i]).norm();
      count[away > 0.01] += 1.0;
    }
  }
  EXPECT_NEAR(sum[0] / count[0], 0.002, 0.1 * 0.002);
  EXPECT_NEAR(sum[1] / count[1], 0.016, 0.2 * 0.016);
  // Of the surface: where it is finest, no flat triangle cuts off much.
  for (const Index i : model.group("surface")) {
    const double away = (model.rest[i] - place).norm();
    EXPECT_NEAR(model.rest[i].norm(), 0.05, away < 0.01 ? 2e-5 : 1.5e-3);
  }
}

/// A lobe of 8 mm at a thick part: with 10 mm alone it is lost.
TEST(GradedBody, KeepsAThinPart) {
  const Solid thick = solid_ball({0, 0, 0}, 0.04), lobe = solid_ellipsoid({0.06, 0, 0}, {0.04, 0.02, 0.004});
  const Solid organ = solid_union({thick, lobe});
  BodyReport coarse, graded;
  make_body(organ, {.spacing = 0.012, .most_volume_error = 0.5}, &coarse);
  const auto field = [](const Vec3& x) { return x.x() > 0.035 ? 0.003 : 0.012; };
  const Model model = make_body(organ, {.spacing = 0.012, .spacing_at = field}, &graded);
  expect_sound(model, graded);
  const Index at_tip = static_cast<Index>(model.particles_in([](const Vec3& x) { return x.x() > 0.09; }).size());
  EXPECT_GT(at_tip, 20);
  EXPECT_NEAR(graded.volume, graded.wanted_volume, 1e-3 * graded.wanted_volume);
}

TEST(GradedBody, SurfacesFillAsTheSolidsDo) {
  const SpacingField field = fine_near({0.05, 0, 0}, 0.01, 0.0025, 0.01);
  BodyReport of_surface, of_solid;
  make_body(ball_surface(0.05, 40), {.spacing = 0.01, .spacing_at = field}, &of_surface);
  make_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.01, .spacing_at = field}, &of_solid);
  EXPECT_NEAR(of_surface.particles, of_solid.particles, 0.01 * of_solid.particles);
  EXPECT_NEAR(of_surface.volume, of_solid.volume, 2e-3 * of_solid.volume);
}

/// However coarse the lattice beneath, the shape is measured, and its surface moved, by the spacing that there is.
TEST(GradedBody, FineAllOverHasTheVolumeOfItsShape) {
  const double spacing = 0.1;
  const auto fine = [=](const Vec3&) { return spacing / 8.0; };
  BodyReport report;
  make_body(solid_ball({0, 0, 0}, 0.05), {.spacing = spacing, .most_volume_error = 1.0, .spacing_at = fine}, &report);
  EXPECT_NEAR(report.wanted_volume / ball_volume(0.05), 1.0, 0.015);
  EXPECT_NEAR(report.volume / report.wanted_volume, 1.0, 1e-9);
  EXPECT_LT(report.moved, 0.05 * report.largest_spacing);
}

TEST(GradedBody, RefusesFieldsOutOfRange) {
  const Solid ball = solid_ball({0, 0, 0}, 0.05);
  const auto filling = [&](double least, Index most = 1'000'000) {
    const SpacingField field = [=](const Vec3& x) { return x.x() > 0.03 ? least : 0.016; };
    return message_of([&] { make_body(ball, {.spacing = 0.016, .most_particles = most, .spacing_at = field}); });
  };
  for (const double least : {0.0, -1.0, 0.0019, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(says(filling(least), "at least an eighth of the spacing of 0.016 m, got "));
  }
  EXPECT_EQ(filling(0.002), "(no error)");
  EXPECT_TRUE(says(filling(0.002, 1000), "more than 10000 leaves"));
  EXPECT_TRUE(says(filling(0.008, 300), "needs 1008 particles"));
  const auto near = [](const Vec3& place, double radius, double fine, double coarse, double growth) {
    return message_of([&] { fine_near(place, radius, fine, coarse, growth); });
  };
  const Vec3 origin(0, 0, 0);
  EXPECT_TRUE(says(near({0, std::nan(""), 0}, 1, 1, 1, 1), "a finite place, got"));
  EXPECT_TRUE(says(near(origin, 0, 1, 1, 1), "a radius above 0, got 0"));
  EXPECT_TRUE(says(near(origin, 1, 1, 1, 0), "a growth above 0, got 0"));
  EXPECT_TRUE(says(near(origin, 1, 2, 1, 1), "0 < fine <= coarse, both in m, got 2 and 1"));
  EXPECT_TRUE(says(near(origin, 1, 0, 1, 1), "got 0 and 1"));
}

BodyOptions fine_at(const Vec3& place, double finest) {
  return {.spacing = 0.016, .spacing_at = fine_near(place, 0.01, finest, 0.016)};
}

/// A uniform strain has its energy, and no force acts on particles inside.
TEST(GradedBody, PassesThePatchTest) {
  Model model = make_body(solid_box({0, 0, 0}, {0.2, 0.05, 0.05}), fine_at({0.1, 0.025, 0.05}, 0.002));
  const double e = 1e-6, young = 10e3;
  for (const double nu : {0.0, 0.45}) {
    set_material(model, {.young = young, .poisson = nu, .density = 1000});
    const TopologyTextures tables = build_topology(model, {});
    double volume = 0.0;
    for (const Cell& cell : model.cells) volume += cell_volume(model, cell);
    VecList x = tables.rest, force(x.size());
    for (Vec3& p : x) p += e * Vec3(1.0, -nu, -nu).cwiseProduct(p);
    EXPECT_NEAR(elastic_energy(tables, x) / (0.5 * young * e * e * volume), 1.0, 1e-5);
    elastic_forces(tables, x, force);
    std::vector<char> at_surface(x.size(), 0);
    for (const Index i : model.group("surface")) at_surface[i] = 1;
    const auto is_outer = [&](Index i) { return at_surface[i] != 0; };
    double inside = 0.0, outside = 0.0;
    for (Index i = 0; i < model.particle_count(); ++i) {
      // The mean of a neighbour at the surface sees fewer cells: its own neighbours pull back.
      const Index *begin = model.neighbours.begin(i), *end = model.neighbours.end(i);
      const bool is_inner = !is_outer(i) && std::none_of(begin, end, is_outer);
      (is_inner ? inside : outside) = std::max(is_inner ? inside : outside, force[i].norm());
    }
    EXPECT_GT(outside, 0.0);
    EXPECT_LT(inside, 1e-6 * outside);
  }
}

/// Where it is fine hardly changes how it bends. The stabiliser is calibrated on each body. All are fine at the root,
/// whose particles are held: that they are some tenths of a spacing from where the support ends would count there.
TEST(GradedBody, BendsAsTheUniformBody) {
  const auto sag = [](const BodyOptions& options) {
    Model model = with_material(make_body(solid_capsule({0, 0, 0}, {0.2, 0, 0}, 0.025), options),
                                {.young = 10e3, .poisson = 0.45, .density = 1000});
    model.add_group("held", model.particles_in([](const Vec3& x) { return x.x() < 0.0; }));
    Simulation sim(model, {.backend = "cpu"});
    sim.scene().fix("held").gravity({0, 0, -0.05});
    EXPECT_TRUE(sim.solve_static().converged());
    return sim.max_displacement();
  };
  const double of_uniform = sag({.spacing = 0.006});
  for (const double x : {0.1, 0.2}) {
    const SpacingField at_root = fine_near({0, 0, 0}, 0.03, 0.006, 0.012),
                       at_side = fine_near({x, 0, 0.025}, 0.005, 0.003, 0.012);
    const auto field = [&](const Vec3& place) { return std::min(at_root(place), at_side(place)); };
    EXPECT_NEAR(sag({.spacing = 0.012, .spacing_at = field}) / of_uniform, 1.0, 0.03);
  }
}

/// Crushed to a tenth across, it comes back.
TEST(GradedBody, ReturnsFromABrokenState) {
  const Model model =
      with_material(make_body(solid_box({0, 0, 0}, {0.05, 0.05, 0.05}), fine_at({0.025, 0.025, 0.05}, 0.004)),
                    {.young = 10e3, .poisson = 0.3, .density = 1000});
  const Scene scene(model);
  const auto solver = make_solver("cpu", model, scene, {}, damped(60.0));
  State state = rest_state(model);
  for (Vec3& x : state.position) x.z() *= 0.1;
  solver->reset(state);
  const RestResult rest = solver->run_to_rest(20000, 0.2 * solver->stable_step());
  ASSERT_TRUE(rest.converged()) << rest.message();
  const VecList at = solver->read().position;
  double most = 0.0;
  for (Index i = 0; i < model.particle_count(); ++i) {
    const double own = (model.rest[i] - model.rest[0]).norm() - (at[i] - at[0]).norm();
    most = std::max(most, std::abs(own));
  }
  EXPECT_LT(most, 1e-4);
}

// How soft the cells of make_body are in bending: a cantilever, in any direction against the lattice that it is filled
// by, held by its end's surface.

const Vec3 size(0.2, 0.05, 0.05);                 // m
constexpr double far_end = 0.19, lightly = 1e-3;  // m; of the earth's gravity

/// m: mean way of the end under a little of its weight, along the third of `axes`.
double sag(Simulation& sim, const Mat3& axes) {
  sim.scene().gravity(-9.81 * lightly * axes.col(2));
  EXPECT_TRUE(sim.solve_static().converged());
  const State now = sim.state();
  double sum = 0.0, mass = 0.0;
  for (Index i = 0; i < sim.model().particle_count(); ++i) {
    if (axes.col(0).dot(sim.model().rest[i]) < far_end) continue;
    sum -= sim.model().mass[i] * axes.col(2).dot(now.position[i] - sim.model().rest[i]);
    mass += sim.model().mass[i];
  }
  return sum / mass;
}

TEST(FilledBeam, IsALittleTooSoft) {
  const SimulationOptions options{.material = {.young = 10e3, .poisson = 0.3, .density = 1000.0}, .backend = "cpu"};
  Simulation lattice(make_block(size, 48, 12, 12), options);
  lattice.scene().fix("x0");
  const double right = sag(lattice, Mat3::Identity());
  std::mt19937 bits(1);
  std::normal_distribution<double> normal;
  for (int direction = 0; direction < 10; ++direction) {
    const Eigen::Quaterniond turn(normal(bits), normal(bits), normal(bits), normal(bits));
    const Mat3 axes = turn.normalized().toRotationMatrix();
    Surface box = box_surface({0, 0, 0}, size);
    for (Vec3& vertex : box.vertices) vertex = axes * vertex;
    for (const auto& [across, most] : {std::pair{4, 0.065}, {6, 0.045}}) {
      const double spacing = size.y() / across;
      Simulation sim(make_body(box, {.spacing = spacing}), options);
      sim.scene().hold(sample_surface(box, spacing / 3.0, [&](const Vec3& x) { return axes.col(0).dot(x) < 1e-9; }));
      const double softer = sag(sim, axes) / right - 1.0;
      EXPECT_GT(softer, 0.0) << direction << ", " << across;
      EXPECT_LT(softer, most) << direction << ", " << across;
    }
  }
}

/// The middle of an octahedron's eight cells, moved to `place`, and where improve_cells() puts it.
Vec3 improved(const Vec3& place) {
  Stuffing body{.place = {place}, .at_surface = std::vector<char>(7, 0), .cells = {}, .leaf_edge = {}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) body.place.push_back(side * Vec3::Unit(axis));
  }
  for (const Index x : {1, 2}) {
    for (const Index y : {3, 4}) {
      for (const Index z : {5, 6}) {
        Tetrahedron cell{0, x, y, z};
        if (((x == 1) != (y == 3)) != (z == 5)) std::swap(cell[1], cell[2]);
        body.cells.push_back(cell);
      }
    }
  }
  improve_cells(body, {});
  double smallest = 10.0;
  for (const Tetrahedron& cell : body.cells) {
    smallest = std::min(smallest, dihedral_angles(corners_of(cell, body.place)).smallest);
  }
  EXPECT_GT(smallest, 15.0 / 57.3) << place.transpose();
  return body.place.front();
}

TEST(ImproveCells, SearchesAlikeOnAllSides) {
  for (const Vec3& place :
       {Vec3(0.8, 0.05, 0.02), Vec3(0.85, 0.03, 0.004), Vec3(0.9, 0.01, 0.002), Vec3(0.5, 0.4, 0.03)}) {
    const Vec3 there = improved(place);
    EXPECT_LT(there.norm(), 0.95 * place.norm());
    for (int signs = 0; signs < 8; ++signs) {
      const Vec3 side(signs & 1 ? -1 : 1, signs & 2 ? -1 : 1, signs & 4 ? -1 : 1);
      for (int axis = 0; axis < 3; ++axis) {
        const auto turned = [&](const Vec3& v) {
          return Vec3(side.cwiseProduct(Vec3(v[axis], v[(axis + 1) % 3], v[(axis + 2) % 3])));
        };
        EXPECT_LT((improved(turned(place)) - turned(there)).norm(), 1e-12) << turned(place).transpose();
      }
    }
  }
}

}  // namespace
}  // namespace phymul::test

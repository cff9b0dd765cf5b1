// SPDX-License-Identifier: MIT
//
// Young's modulus and Poisson's ratio in, Young's modulus and Poisson's ratio out; and beams that bend as beams do.
// Masses that set_material moves to light particles (Model::most_mass_moved).
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <set>

#include "support/bodies.h"
#include "support/dense_operator.h"
#include "support/mechanics.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

TEST(Material, UniformStretchIsExactOnEveryMesh) {
  const std::vector<std::pair<const char*, Model>> meshes = {
      {"lattice", make_block({0.04, 0.02, 0.03}, 4, 2, 3)},
      {"tetrahedra", make_tetrahedral_block({0.05, 0.04, 0.04}, 5, 4, 4, 0.2, 1)},
      {"tetrahedra, another mesh", make_tetrahedral_block({0.04, 0.03, 0.03}, 4, 3, 3, 0.2, 2)}};
  for (const auto& [name, shape] : meshes) {
    for (const double poisson : {0.0, 0.3, 0.45}) {
      Model model = shape;
      const Material tissue = soft_tissue(poisson);
      set_material(model, tissue);
      const Moduli found = stretch_block(model, build_topology(model), 1e-4);
      std::printf("%-26s nu %.2f: E / asked %.5f, nu found %.5f\n", name, poisson, found.young / tissue.young,
                  found.poisson);
      // Of a strain of 1e-4, and of how far the body was let come to rest.
      EXPECT_NEAR(found.young, tissue.young, 1e-3 * tissue.young) << name;
      EXPECT_NEAR(found.poisson, poisson, 1e-3) << name;
    }
  }
}

/// A ball of 4.19 ml in a block: by centres its volume is met, by particles only the cells wholly in it are.
TEST(Material, RegionsReachTheirVolume) {
  const double radius = 0.01, asked = 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
  const auto ball = [&](const Vec3& at) { return (at - Vec3(0.031, 0.03, 0.029)).norm() < radius; };
  for (const Model& block :
       {make_tetrahedral_block({0.06, 0.06, 0.06}, 10, 10, 10, 0.2, 1), make_block({0.06, 0.06, 0.06}, 20, 20, 20)}) {
    Model by_centre = with_material(block), by_group = by_centre;
    const Material hard{50e3, 0.45, 1000};
    const double reached = set_material(by_centre, hard, ball);
    double volume = 0.0, whole = 0.0;
    by_group.add_group("ball", by_group.particles_in(ball));
    set_material(by_group, hard, "ball");
    for (const Cell& cell : by_centre.cells) volume += cell.material == 1 ? cell_volume(block, cell) : 0.0;
    for (const Cell& cell : by_group.cells) whole += cell.material == 1 ? cell_volume(block, cell) : 0.0;
    std::printf("ball of %.2f ml: %.2f ml by centres, %.2f ml wholly in it\n", 1e6 * asked, 1e6 * reached, 1e6 * whole);
    EXPECT_NEAR(reached, volume, 1e-12 * volume);
    EXPECT_NEAR(reached, asked, 0.06 * asked);
    EXPECT_LT(whole, 0.8 * asked);
  }
  // Of cells and of walls as far as they are left.
  Model capsule = with_material(make_tetrahedral_block({0.04, 0.04, 0.04}, 2, 2, 2, 0.0, 1));
  const Material skin{.young = 1e4, .poisson = 0.4, .density = 1000.0, .thickness = 1e-3};
  const auto everywhere = [](const Vec3&) { return true; };
  add_capsule(capsule, skin);
  for (Cell& cell : capsule.cells) cell.share = 0.5;
  EXPECT_NEAR(set_material(capsule, skin, everywhere), 0.5 * 6.0 * 1.6e-6, 1e-15);
  EXPECT_NEAR(set_material(capsule, soft_tissue(), everywhere), 0.5 * 6.4e-5, 1e-15);
  Model strip = make_strip(0.04, 0.04, 4, 4);
  EXPECT_DOUBLE_EQ(set_material(strip, soft_tissue(), [](const Vec3& at) { return at.x() < 0.02; }), 8e-4);
  EXPECT_EQ(message_of([&] { set_material(strip, soft_tissue(), [](const Vec3&) { return false; }); }),
            "set_material: expected the centres of some triangles or quads in the region, but there are none");
}

/// A group that lists cells means these, not all cells between their particles; one that lists faces, and one that
/// lists particles, mean the cells wholly among them.
TEST(Material, GroupsOfCells) {
  Model model = make_tetrahedral_block({0.06, 0.06, 0.06}, 3, 3, 3, 0.2, 1);
  const auto count = static_cast<Index>(model.cells.size());
  const auto add = [&](const char* name, std::vector<Index> cells) {
    model.add_group(name, {});
    model.components.back().cell_refs = std::move(cells);
  };
  std::vector<Index> all_but_one;
  for (Index cell = 1; cell < count; ++cell) all_but_one.push_back(cell);
  add("all but one", all_but_one);
  ASSERT_EQ(model.group("all but one").size(), model.rest.size());
  const std::vector<Index> first = model.cells[0].particles;
  Cell face, other;
  face.type = other.type = CellType::triangle;
  face.particles = {first[0], first[1], first[2]};
  other.particles = {first[1], first[2], first[3]};
  model.cells.push_back(face);
  model.cells.push_back(other);
  add("faces of one", {count, count + 1});
  const Material hard{50e3, 0.45, 1000}, harder{90e3, 0.45, 1000};
  set_material(model, soft_tissue());
  set_material(model, hard, "all but one");
  EXPECT_EQ(model.materials[model.cells[0].material], soft_tissue());
  for (Index cell = 1; cell < count; ++cell) ASSERT_EQ(model.materials[model.cells[cell].material], hard);
  set_material(model, harder, "faces of one");
  EXPECT_EQ(model.materials[model.cells[0].material], harder);
  EXPECT_EQ(model.materials[model.cells[1].material], hard);
  // A group within a group.
  add("inner", {0, 1});
  model.components.back().parent = static_cast<Index>(model.components.size()) - 2;
  set_material(model, soft_tissue(), "faces of one");
  EXPECT_EQ(model.materials[model.cells[1].material], soft_tissue());
  EXPECT_EQ(model.materials[model.cells[2].material], hard);
}

TEST(Material, CantileverAgreesWithTimoshenko) {
  for (double poisson : {0.0, 0.3, 0.45}) {
    const Material tissue = soft_tissue(poisson);
    const Model beam = cantilever(4, tissue);
    const double ratio = cantilever_ratio(beam, build_topology(beam), tissue, Root::beam);
    std::printf("cantilever of four cells across, nu %.2f: %.4f\n", poisson, ratio);
    EXPECT_NEAR(ratio, 1.0, 0.03) << "nu " << poisson;
  }
}

TEST(Material, AveragedEnergyDoesNotConverge) {
  const Material tissue = soft_tissue();
  double ratio[2];
  for (int k = 0; k < 2; ++k) {
    const Model beam = cantilever(2 << k, tissue);
    ratio[k] = cantilever_ratio(beam, averaged_tables(beam), tissue, Root::beam);
    std::printf("cantilever n = %d, averaged energy: %.3f\n", 2 << k, ratio[k]);
  }
  EXPECT_GT(ratio[1], 2.0 * ratio[0]);  // softer and softer: the deflection runs away from 1
  EXPECT_GT(ratio[1], 2.0);
}

constexpr Material of_an_organ{.young = 5e3, .poisson = 0.45, .density = 1000};

Model organ(double most_moved, double spacing = 0.012) {
  Model model = make_body(solid_ellipsoid({0, 0, 0}, {0.05, 0.035, 0.03}), {.spacing = spacing});
  model.most_mass_moved = most_moved;
  set_material(model, of_an_organ);
  return model;
}

double largest_eigenvalue(const Model& model) {
  const TopologyTextures topology = build_topology(model);
  return estimate_spectrum(topology, topology.rest).largest;
}

/// Total mass, and the moments of first and second degree about the origin.
Eigen::Matrix4d moments(const Model& model) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < model.mass.size(); ++i) {
    const Eigen::Vector4d x(1.0, model.rest[i].x(), model.rest[i].y(), model.rest[i].z());
    sum += model.mass[i] * x * x.transpose();
  }
  return sum;
}

double moved(const Model& from, const Model& to) {
  double sum = 0.0, total = 0.0;
  for (std::size_t i = 0; i < from.mass.size(); ++i) {
    sum += std::max(0.0, to.mass[i] - from.mass[i]);
    total += from.mass[i];
  }
  return sum / total;
}

TEST(BalancedMasses, LengthenTheStepAndKeepTheMoments) {
  const Model plain = organ(0.0), balanced = organ(0.03);
  EXPECT_GT(moved(plain, balanced), 0.01);
  EXPECT_LE(moved(plain, balanced), 0.03);
  EXPECT_GT(*std::ranges::min_element(balanced.mass), 2.0 * *std::ranges::min_element(plain.mass));
  EXPECT_LT(largest_eigenvalue(balanced), largest_eigenvalue(plain) / 1.3);
  const Eigen::Matrix4d before = moments(plain), after = moments(balanced);
  EXPECT_NEAR(after(0, 0), before(0, 0), 1e-12 * before(0, 0));
  const double size = std::sqrt(before(1, 1) / before(0, 0));  // m
  for (int a = 1; a < 4; ++a) {
    EXPECT_NEAR(after(0, a), before(0, a), 1e-12 * before(0, 0) * size);
    for (int b = 1; b < 4; ++b) EXPECT_NEAR(after(a, b), before(a, b), 1e-12 * before(1, 1));
  }
  const auto is_told = [](const Model& model) {
    return std::ranges::count_if(model.notes,
                                 [](const std::string& n) { return n.find("most_mass_moved") < n.size(); });
  };
  EXPECT_EQ(is_told(balanced), 1);
  EXPECT_EQ(is_told(plain), 0);
}

TEST(BalancedMasses, MoveNoMoreThanAllowed) {
  const Model plain = organ(0.0);
  double last = largest_eigenvalue(plain);
  for (const double most : {0.02, 0.04, 0.08}) {
    const Model balanced = organ(most);
    EXPECT_LE(moved(plain, balanced), most);
    const double now = largest_eigenvalue(balanced);
    EXPECT_LT(now, last);
    last = now;
  }
}

/// What keeps the moments may take more from light particles than others gave them.
TEST(BalancedMasses, GainNoLessWhereMoreMayMove) {
  double last = std::numeric_limits<double>::infinity();
  for (const double most : {0.0, 0.03, 0.1, 0.3}) {
    Model model = make_tetrahedral_block({0.1, 0.1, 0.1}, 6, 6, 6, 0.45, 2, 0.02);
    model.most_mass_moved = most;
    set_material(model, of_an_organ);
    const double now = largest_eigenvalue(model);
    EXPECT_LT(now, 1.001 * last) << most;
    last = now;
  }
}

/// rad/s, ascending, of the organ held where x < -0.03 m.
std::vector<double> frequencies(const Model& model) {
  const TopologyTextures topology = build_topology(model);
  std::vector<std::uint8_t> fixed;
  for (const Vec3& x : model.rest) fixed.push_back(x.x() < -0.03 ? 7 : 0);
  std::vector<double> found;
  for (const auto& value : dense_eigenvalues(topology, topology.rest, fixed)) {
    if (value.real() > 1.0) found.push_back(std::sqrt(value.real()));  // 1/s^2; of held coordinates it is 0
  }
  std::ranges::sort(found);
  return found;
}

TEST(BalancedMasses, ChangeNoLowFrequency) {
  const std::vector<double> plain = frequencies(organ(0.0, 0.017)), balanced = frequencies(organ(0.03, 0.017));
  EXPECT_LT(balanced.back(), plain.back() / 1.1);
  for (int k = 0; k < 10; ++k) EXPECT_NEAR(balanced[k], plain[k], 5e-3 * plain[k]) << k;  // of so coarse a body
}

TEST(BalancedMasses, OfLatticesAreTheSharesOfTheirVolume) {
  Model plain = make_block({0.1, 0.05, 0.05}, 8, 4, 4), balanced = plain;
  plain.most_mass_moved = 0.0;
  set_material(plain, of_an_organ);
  set_material(balanced, of_an_organ);
  EXPECT_EQ(plain.mass, balanced.mass);
}

TEST(BalancedMasses, StayInTheirPartOfTheBody) {
  // A fine end, all of which is light for its stiffness, takes nothing from the coarse rest.
  const auto fine = [](const Vec3& x) { return x.x() > 0.03; };
  Model plain = make_body(solid_ellipsoid({0, 0, 0}, {0.06, 0.03, 0.03}),
                          {.spacing = 0.014, .spacing_at = [&](const Vec3& x) { return fine(x) ? 0.005 : 0.014; }});
  Model balanced = plain;
  plain.most_mass_moved = 0.0;
  set_material(plain, of_an_organ);
  set_material(balanced, of_an_organ);
  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < plain.rest.size(); ++i) {
    if (!fine(plain.rest[i])) continue;
    before += plain.mass[i];
    after += balanced.mass[i];
  }
  EXPECT_NE(plain.mass, balanced.mass);
  EXPECT_NEAR(after, before, 0.01 * before);
  EXPECT_LT(largest_eigenvalue(balanced), largest_eigenvalue(plain) / 1.3);
}

TEST(BalancedMasses, AreTakenFromTheNeighbours) {
  const Model plain = organ(0.0), balanced = organ(0.03);
  double gained = 0.0;  // with their neighbours, over the mass of these, by all that were light
  for (Index i = 0; i < plain.particle_count(); ++i) {
    if (balanced.mass[i] < 1.3 * plain.mass[i]) continue;
    std::set<Index> around;
    for (const Cell& cell : plain.cells) {
      if (std::ranges::count(cell.particles, i) > 0) around.insert(cell.particles.begin(), cell.particles.end());
    }
    double before = 0.0, after = 0.0;
    for (const Index j : around) {
      before += plain.mass[j];
      after += balanced.mass[j];
    }
    gained += (after - before) / before;
  }
  EXPECT_LT(gained, 0.0);
}

TEST(BalancedMasses, FollowTheLastMaterial) {
  Model twice = organ(0.03);
  const Model once = twice;
  set_material(twice, {.young = 20e3, .poisson = 0.3, .density = 1200}, [](const Vec3& x) { return x.x() > 0.0; });
  EXPECT_NE(twice.mass, once.mass);
  set_material(twice, of_an_organ);
  EXPECT_EQ(twice.mass, once.mass);
  EXPECT_EQ(twice.notes, once.notes);
}

TEST(BalancedMasses, RefuseAShareOutOfRange) {
  for (const double share : {-0.01, 1.0, std::nan("")}) {
    Model model = make_block({0.1, 0.05, 0.05}, 2, 1, 1);
    model.most_mass_moved = share;
    EXPECT_NE(message_of([&] { set_material(model, of_an_organ); }).find("most_mass_moved"), std::string::npos);
    EXPECT_TRUE(model.materials.empty());
  }
}

}  // namespace
}  // namespace phymul::test

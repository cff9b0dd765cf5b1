// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <random>
#include <set>

#include "model/cell_geometry.h"
#include "model/duplicates.h"
#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/flaws.h"

namespace phymul {
namespace {

/// The finding of that kind, which must be there once; an empty one where it is not.
Finding only(const std::vector<Finding>& findings, Flaw flaw) {
  Finding found{flaw, {}, false, "(no such finding)"};
  int times = 0;
  for (const Finding& finding : findings) {
    if (finding.flaw != flaw) continue;
    found = finding;
    ++times;
  }
  EXPECT_EQ(times, 1);
  return found;
}

/// A cell as what it is whatever vertex its list starts with: its outward faces, each from its lowest particle on.
std::set<std::vector<Index>> oriented(const Cell& cell) {
  std::set<std::vector<Index>> faces;
  for (const CellFace& face : cell_faces(cell.type)) {
    std::vector<Index> ring;
    for (const int v : face) {
      if (v >= 0) ring.push_back(cell.particles[v]);
    }
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    faces.insert(ring);
  }
  return faces;
}

std::multiset<std::set<std::vector<Index>>> oriented(const std::vector<Cell>& cells) {
  std::multiset<std::set<std::vector<Index>>> all;
  for (const Cell& cell : cells) all.insert(oriented(cell));
  return all;
}

Model pyramids() {
  return test::cut_into_pyramids(make_block({1, 1, 1}, 1, 1, 1));
}

TEST(CheckMesh, CleanBodiesHaveNoFlaw) {
  for (const Model& model : {make_tetrahedron(0.01), make_block({0.1, 0.1, 0.1}, 3, 3, 3, 26), pyramids(),
                             make_cylinder(0.01, 0.04, 3, 8, 11), make_strip(0.1, 0.1, 3, 3),
                             make_tetrahedral_block({0.1, 0.1, 0.1}, 4, 4, 4, 0.2, 3)}) {
    const std::vector<Finding> findings = find_flaws(model);
    EXPECT_TRUE(findings.empty()) << model.name << ": " << findings.front().message;
  }
}

/// Spare particles are none, nor cells whose parts have their particles in common. Copies at one place are.
TEST(CheckMesh, CutsHaveNoFlawButTheirCopies) {
  Model body = make_tetrahedral_block({0.1, 0.1, 0.1}, 4, 4, 4, 0.2, 3);
  set_material(body, test::soft_tissue());
  body = with_spare_particles(body, 100);
  EXPECT_TRUE(find_flaws(body).empty());
  CutSurface cut = cut_plane({0.05, 0.0, 0.0}, {1.0, 0.1, 0.0});
  cut.front = [](const Vec3& x) { return x.z() - 0.04; };
  for (const Finding& finding : find_flaws(cut_body(body, cut))) EXPECT_EQ(finding.flaw, Flaw::duplicate_point);
}

TEST(CheckMesh, TurnsEveryKindOfVolumeCellRound) {
  for (const Model& right : {make_tetrahedral_block({1, 1, 1}, 3, 3, 3, 0.2, 3), make_block({1, 1, 1}, 3, 3, 3),
                             make_cylinder(0.1, 0.4, 2, 6, 4), pyramids()}) {
    Model wrong = right;
    std::vector<Index> turned;
    for (Index row = 0; row < static_cast<Index>(wrong.cells.size()); row += 2) {
      mirror(wrong.cells[row]);
      turned.push_back(row);
    }
    ASSERT_NE(oriented(wrong.cells), oriented(right.cells));
    const Finding finding = only(check_mesh(wrong), Flaw::winding);
    EXPECT_EQ(finding.items, turned);
    EXPECT_TRUE(finding.mended);
    EXPECT_EQ(oriented(wrong.cells), oriented(right.cells)) << right.name;
    for (const Cell& cell : wrong.cells) EXPECT_GT(cell_volume(wrong, cell), 0.0);
    EXPECT_TRUE(find_flaws(wrong).empty());
  }
}

TEST(CheckMesh, AnyOrderOfATetrahedronsVerticesGivesTheSameCell) {
  const Model right = make_tetrahedron(1.0);
  std::vector<Index> order{0, 1, 2, 3};
  int turned = 0;
  do {
    Model model = right;
    model.cells[0].particles = order;
    turned += has(check_mesh(model), Flaw::winding);
    EXPECT_EQ(oriented(model.cells), oriented(right.cells));
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(turned, 12);
}

TEST(CheckMesh, TurnsQuadsRoundInThePlaneOnly) {
  Model strip = make_strip(1, 1, 2, 1);
  mirror(strip.cells[1]);
  EXPECT_EQ(only(check_mesh(strip), Flaw::winding).message,
            "1 cell is wound the wrong way, with negative area: row 1; turned round");
  EXPECT_GT(signed_measure(2, strip.cells[1], strip.rest), 0.0);
  strip.dimension = 3;
  mirror(strip.cells[1]);
  EXPECT_FALSE(has(find_flaws(strip), Flaw::winding));
}

TEST(CheckMesh, FindFlawsChangesNothingAndSaysWhatWouldBeDone) {
  Model model = make_block({1, 1, 1}, 2, 2, 2);
  mirror(model.cells[3]);
  change_extras(model, [](FileExtras& extras) { extras.cell_index = {-1, -1, -1, 40}; });
  const Model before = model;
  const Finding finding = only(find_flaws(model), Flaw::winding);
  EXPECT_FALSE(finding.mended);
  EXPECT_EQ(finding.message, "1 cell is wound the wrong way, with negative volume: number 40; check_mesh mends this");
  EXPECT_EQ(model, before);
  EXPECT_TRUE(model.notes.empty());
}

TEST(CheckMesh, NotesNameTheSource) {
  Model model = make_block({1, 1, 1}, 3, 2, 2);
  for (Cell& cell : model.cells) mirror(cell);
  check_mesh(model, "liver.pml");
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_EQ(
      model.notes[0],
      "liver.pml: 12 cells are wound the wrong way, with negative volume: row 0, 1, 2, 3, 4 and 7 more; turned round");
}

TEST(CheckMesh, DegenerateCells) {
  Model flat = make_tetrahedron(1.0);
  flat.rest[3].z() = 1e-8;
  Finding finding = only(check_mesh(flat), Flaw::degenerate_cell);
  EXPECT_EQ(finding.items, std::vector<Index>{0});
  EXPECT_FALSE(finding.mended);
  EXPECT_EQ(
      finding.message,
      "1 cell is degenerate, with no volume or area for the length of the edges, a size beyond the range of "
      "numbers or a vertex repeated: row 0; remove such cells, or mend their places or the order of the vertices");
  flat.rest[3].z() = -1e-8;  // too flat to have a winding
  EXPECT_FALSE(has(find_flaws(flat), Flaw::winding));
  flat.rest[3].z() = 1e-4;
  EXPECT_FALSE(has(find_flaws(flat), Flaw::degenerate_cell));

  Model repeated = make_block({1, 1, 1}, 2, 1, 1);
  repeated.cells[1].particles[7] = repeated.cells[1].particles[6];  // still has volume
  EXPECT_EQ(only(find_flaws(repeated), Flaw::degenerate_cell).items, std::vector<Index>{1});

  // The vertex order of another format, where the rings cross themselves.
  Model crossed = make_block({1, 1, 1}, 1, 1, 1);
  std::swap(crossed.cells[0].particles[2], crossed.cells[0].particles[3]);
  std::swap(crossed.cells[0].particles[6], crossed.cells[0].particles[7]);
  EXPECT_TRUE(has(find_flaws(crossed), Flaw::degenerate_cell));

  // Sums of products beyond the range have no sign to go by.
  for (const double size : {1e103, 1e277}) {
    Model huge = make_block({size, size, size}, 1, 1, 1);
    EXPECT_EQ(only(check_mesh(huge), Flaw::degenerate_cell).items, std::vector<Index>{0}) << size;
  }

  Model strip = make_strip(1, 1, 1, 1);
  std::swap(strip.cells[0].particles[2], strip.cells[0].particles[3]);
  EXPECT_TRUE(has(find_flaws(strip), Flaw::degenerate_cell));
}

TEST(CheckMesh, DegenerateFacesAndLines) {
  for (const double scale : {1e-4, 1.0}) {
    Model model = make_block({scale, scale, scale}, 1, 1, 1);
    Cell sliver, line;
    sliver.type = CellType::triangle;
    sliver.particles = {0, 1, 3};
    line.type = CellType::line;
    line.particles = {0, 7};
    model.cells.push_back(sliver);
    model.cells.push_back(line);
    EXPECT_FALSE(has(find_flaws(model), Flaw::degenerate_cell));
    model.cells.resize(1);
    test::add_particle(model, model.rest[1] / 2 + Vec3(0, 1e-7 * scale, 0), sliver.particles);
    sliver.particles = {0, 1, 8};
    model.cells.push_back(sliver);
    EXPECT_EQ(only(find_flaws(model), Flaw::degenerate_cell).items, std::vector<Index>{1});
  }
}

TEST(CheckMesh, DuplicateCells) {
  Model model = make_tetrahedral_block({1, 1, 1}, 2, 2, 2, 0.1, 1);
  Cell again = model.cells[7];
  std::reverse(again.particles.begin(), again.particles.end());  // two exchanges: wound as before
  const Index last = static_cast<Index>(model.cells.size());
  model.cells.push_back(again);
  model.cells.push_back(again);
  Cell list = again;  // a mere list over the same particles is no second cell
  list.type = CellType::poly_vertex;
  model.cells.push_back(list);
  model.cells.push_back(list);
  const std::vector<Finding> findings = find_flaws(model);
  const Finding finding = only(findings, Flaw::duplicate_cell);
  EXPECT_EQ(findings.size(), 1u);
  EXPECT_EQ(finding.items, (std::vector<Index>{7, last, last + 1}));
  EXPECT_EQ(finding.message, "2 cells stand over the particles of another: row " + std::to_string(last) +
                                 " repeats 7, " + std::to_string(last + 1) +
                                 " repeats 7; keep one of each, or their volume counts twice");
}

TEST(CheckMesh, DuplicatePointsAtAnyScaleAndPlace) {
  for (const double scale : {1e-5, 1e-3, 1.0}) {
    Model model = make_block({scale, scale, scale}, 4, 4, 4);
    change_extras(model, [&](FileExtras& extras) {
      for (Index i = 0; i < model.particle_count(); ++i) extras.particle_index.push_back(i + 1000);
    });
    model.rest[60] = model.rest[5] + Vec3(0.5e-9, -0.5e-9, 0) * scale;
    model.rest[80] = model.rest[6] + Vec3(1.1e-9, 0, 0) * scale;
    const Finding finding = only(find_flaws(model), Flaw::duplicate_point);
    EXPECT_EQ(finding.items, (std::vector<Index>{5, 60}));
    EXPECT_EQ(finding.message,
              "1 particle lies on the place of another: number 1060 on 1005; merge such pairs, unless the body is "
              "meant to be cut "
              "there");
  }
}

TEST(RepeatedPoints, AgreesWithTheSearchOfAllPairs) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(0.0, 1.0);
  VecList points(600);
  for (Vec3& x : points) x = Vec3(number(random), number(random), number(random));
  for (const double tolerance : {1e-3, 0.02, 0.1}) {
    std::vector<std::pair<Index, Index>> expected;
    std::vector<Index> kept;
    for (Index i = 0; i < 600; ++i) {
      const auto near =
          std::count_if(kept.begin(), kept.end(), [&](Index j) { return (points[i] - points[j]).norm() <= tolerance; });
      if (near == 0) kept.push_back(i);
      if (near > 0) expected.emplace_back(i, -1);
    }
    const Repeats found = repeated_points(points, tolerance);
    ASSERT_EQ(found.size(), expected.size()) << tolerance;
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].first, expected[k].first);
      EXPECT_LE((points[found[k].first] - points[found[k].second]).norm(), tolerance);
    }
  }
}

TEST(CheckMesh, AllParticlesOnOnePlace) {
  Model model = make_block({1, 1, 1}, 1, 1, 1);
  model.rest.assign(8, Vec3(1, 2, 3));
  EXPECT_EQ(only(find_flaws(model), Flaw::duplicate_point).items.size(), 8u);
  EXPECT_TRUE(has(find_flaws(model), Flaw::degenerate_cell));
  EXPECT_FALSE(has(find_flaws(model), Flaw::suspect_units)) << "a size of 0 says nothing of units";
}

TEST(RepeatedPoints, FindsAPairWhereverItLies) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  VecList points{Vec3(-1, -1, -1), Vec3(0, 0, 0), Vec3(0, 0, 0)};
  for (int trial = 0; trial < 2000; ++trial) {
    points[1] = vector();
    const Vec3 step = 0.01 * vector().normalized();
    points[2] = points[1] + 0.999 * step;
    ASSERT_EQ(repeated_points(points, 0.01), (Repeats{{2, 1}})) << points[1].transpose();
    points[2] = points[1] + 1.001 * step;
    ASSERT_TRUE(repeated_points(points, 0.01).empty()) << points[1].transpose();
  }
}

TEST(CheckMesh, MasslessParticles) {
  Model model = make_block({1, 1, 1}, 2, 2, 2);
  model.mass[4] = 1e-10;
  model.mass[9] = 1e-8;
  const Finding finding = only(find_flaws(model), Flaw::massless);
  EXPECT_EQ(finding.items, std::vector<Index>{4});
  EXPECT_EQ(finding.message,
            "1 particle has next to no mass beside the mean: row 4; give more, or the stable step becomes tiny");
  model.cells[0].share = model.mass[0] = 0.0;  // removed, and a particle that has no other cell
  for (double& mass : model.mass) mass *= 1e-12;
  EXPECT_EQ(only(find_flaws(model), Flaw::massless).items, std::vector<Index>{4});
}

void replace_row(RaggedList& list, Index row, const std::vector<Index>& entries) {
  RaggedList made;
  for (Index i = 0; i < list.rows(); ++i) {
    if (i == row) {
      made.push_row(entries.begin(), entries.end());
    } else {
      made.push_row(list.begin(i), list.end(i));
    }
  }
  list = made;
}

TEST(CheckMesh, IsolatedParticles) {
  Model model = make_block({1, 1, 1}, 2, 2, 2);
  replace_row(model.neighbours, 13, {});
  EXPECT_EQ(only(find_flaws(model), Flaw::isolated).items, std::vector<Index>{13});
  model = make_block({1, 1, 1}, 2, 2, 2);
  model.cells.erase(model.cells.begin());
  model.components.clear();
  const Finding finding = only(find_flaws(model), Flaw::isolated);
  EXPECT_EQ(finding.items, std::vector<Index>{0});
  EXPECT_EQ(
      finding.message,
      "1 particle has no neighbours or no cell around: row 0; nothing elastic holds such a particle: remove it, or "
      "add it to the mesh");
  Cell list;  // holds particles together in name only
  list.type = CellType::poly_vertex;
  list.particles = {0, 1, 2};
  model.cells.push_back(list);
  EXPECT_EQ(only(find_flaws(model), Flaw::isolated).items, std::vector<Index>{0});
  model.cells.clear();  // no cells at all: neighbourhoods alone make a body
  EXPECT_TRUE(find_flaws(model).empty());
}

TEST(CheckMesh, FewNeighboursOrAllOnOneLine) {
  for (const double scale : {1e-4, 1.0}) {
    Model model = make_block({scale, scale, scale}, 4, 1, 1);
    replace_row(model.neighbours, 0, {1, 5});
    replace_row(model.neighbours, 7, {0, 1, 2, 3, 4});
    replace_row(model.neighbours, 8, {5, 5, 3, 3});
    const Finding finding = only(find_flaws(model), Flaw::few_neighbours);
    EXPECT_EQ(finding.items, (std::vector<Index>{0, 7, 8}));
    EXPECT_EQ(
        finding.message,
        "3 particles have fewer than 3 neighbours or all of them on one line: row 0, 7, 8; add neighbours, or choose "
        "what becomes of sparse particles");
    model.rest[2].y() += 1e-4 * scale;  // off the line by far more than rounding
    EXPECT_EQ(only(find_flaws(model), Flaw::few_neighbours).items, (std::vector<Index>{0, 8}));
  }
  Model strip = make_strip(1, 1, 2, 2);
  EXPECT_FALSE(has(find_flaws(strip), Flaw::few_neighbours));
  replace_row(strip.neighbours, 4, {1});
  EXPECT_EQ(
      only(find_flaws(strip), Flaw::few_neighbours).message,
      "1 particle has fewer than 2 neighbours: row 4; add neighbours, or choose what becomes of sparse particles");
}

TEST(CheckMesh, SelfNeighboursAreRemovedAndDoNotCount) {
  Model model = make_block({1, 1, 1}, 2, 2, 2);
  const Model right = model;
  replace_row(model.neighbours, 0, {1, 0, 3, 9, 0});
  EXPECT_EQ(only(find_flaws(model), Flaw::self_neighbour).message,
            "1 particle is among its own neighbours: row 0; check_mesh mends this");
  const Finding finding = only(check_mesh(model), Flaw::self_neighbour);
  EXPECT_TRUE(finding.mended);
  EXPECT_EQ(finding.message, "1 particle is among its own neighbours: row 0; removed from the lists");
  EXPECT_EQ(model, right);
  replace_row(model.neighbours, 0, {0, 1, 3});
  EXPECT_EQ(only(check_mesh(model), Flaw::few_neighbours).items, std::vector<Index>{0});
}

TEST(CheckMesh, SuspectUnits) {
  const auto message = [](double size) {
    const std::vector<Finding> findings = find_flaws(make_block({size, size, size}, 2, 2, 2));
    return findings.empty() ? "" : only(findings, Flaw::suspect_units).message;
  };
  EXPECT_EQ(message(40.0),
            "the body is 40 m large: perhaps millimetres were read as metres; set the length unit when reading");
  EXPECT_EQ(message(4e-6),
            "the body is 4e-06 m large: perhaps metres were read as millimetres; set the length unit when reading");
  EXPECT_EQ(message(9.0), "");
  EXPECT_EQ(message(2e-5), "");
}

TEST(CheckMesh, CostGrowsAlmostAsTheBody) {
  const auto seconds = [](int n) {
    Model model = make_block({1, 1, 1}, n, n, n);
    for (Index i = 0; i < model.particle_count(); i += 2) model.rest[i] = Vec3(0.5, 0.5, 0.5);  // many coincide
    // Processor time, so that other work on the machine does not count, and the least of several.
    double least = std::numeric_limits<double>::infinity();
    for (int trial = 0; trial < 3; ++trial) {
      const std::clock_t start = std::clock();
      EXPECT_FALSE(find_flaws(model).empty());
      least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
    return least;
  };
  // Eight times the particles: a quadratic search would take 64 times as long. Some clocks go on by 16 ms.
  EXPECT_LT(seconds(40), 32 * std::max(seconds(20), 0.004));
}

}  // namespace
}  // namespace phymul

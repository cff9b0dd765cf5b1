// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <functional>
#include <limits>
#include <numeric>

#include "model/file_extras.h"
#include "support/message_of.h"
#include "support/print.h"

namespace phymul {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
const Material soft{10e3, 0.3, 1000.0};

double total(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(CellType, SizesAndNames) {
  EXPECT_EQ(cell_size(CellType::atom), 1);
  EXPECT_EQ(cell_size(CellType::wedge), 6);
  EXPECT_EQ(cell_size(CellType::pyramid), 5);
  EXPECT_EQ(cell_size(CellType::poly_vertex), 0);
  EXPECT_STREQ(cell_name(CellType::hexahedron), "HEXAHEDRON");
  EXPECT_STREQ(cell_name(CellType::poly_line), "POLY_LINE");
  EXPECT_TRUE(is_volume(CellType::pyramid));
  EXPECT_FALSE(is_volume(CellType::quad));
}

TEST(Group, TakesParticlesDirectlyThroughCellsAndThroughParts) {
  Model model = make_block({2, 1, 1}, 2, 1, 1);
  Component part, leaf;
  part.name = "part";
  part.structural = false;
  leaf.name = "leaf";
  leaf.parent = static_cast<Index>(model.components.size());
  leaf.cell_refs = {1};
  leaf.particles = {0, 1};
  model.components.push_back(part);
  model.components.push_back(leaf);
  const std::vector<Index> expected{0, 1, 2, 4, 5, 7, 8, 10, 11};
  EXPECT_EQ(model.group("leaf"), expected);
  EXPECT_EQ(model.group("part"), expected);
  EXPECT_EQ(model.group("Elements").size(), 12u);
}

TEST(Group, UnknownNameListsTheKnownOnes) {
  Model model = make_tetrahedron(1.0);
  EXPECT_FALSE(model.has_group("liver"));
  EXPECT_TRUE(refuses([&] { model.group("liver"); }, "\"liver\"", "\"apex\", \"base\""));
  model.components.clear();
  EXPECT_TRUE(refuses([&] { model.group("liver"); }, "no named groups"));
}

TEST(Group, AddedOnesShareOneInformativeRoot) {
  Model model = make_tetrahedron(1.0);
  const std::size_t before = model.components.size();
  model.add_group("a", {3, 1}).add_group("a", {1, 2});
  EXPECT_EQ(model.components.size(), before + 2);
  EXPECT_EQ(model.group("a"), (std::vector<Index>{1, 2, 3}));
  EXPECT_FALSE(model.components.back().exclusive);
  EXPECT_NO_THROW(validate(model));
  EXPECT_TRUE(refuses([&] { model.add_group("bad", {4}); }, "from 0 to 3, got 4"));
  EXPECT_FALSE(model.has_group("bad"));
  EXPECT_THROW(model.add_group("", {0}), Error);
}

TEST(Model, EqualityLooksAtEverythingButNotes) {
  const Model model = make_cylinder(0.01, 0.04, 1, 4, 3);
  Model other = model;
  other.notes.push_back("seen");
  EXPECT_EQ(model, other);
  const std::vector<std::function<void(Model&)>> changes{
      [](Model& m) { m.name += "x"; },
      [](Model& m) { m.rest[1].x() += 1e-9; },
      [](Model& m) { m.mass[2] = 2; },
      [](Model& m) { m.stiffness[2] = 2; },
      [](Model& m) { std::swap(m.neighbours.entry[0], m.neighbours.entry[1]); },
      [](Model& m) {
        m.cells[0].attributes.push_back({"a", "b"});
      },
      [](Model& m) {
        m.components[0].colour = Colour{1, 0, 0, 1};
      },
      [](Model& m) { m.materials.push_back(soft); },
      [](Model& m) { change_extras(m, [&](FileExtras& e) { e.particle_index.assign(m.rest.size(), 1); }); },
      [](Model& m) { change_extras(m, [&](FileExtras& e) { e.particle_name.resize(m.rest.size()); }); },
      [](Model& m) { change_extras(m, [&](FileExtras& e) { e.particle_fields.resize(m.rest.size()); }); },
      [](Model& m) { change_extras(m, [](FileExtras& e) { e.cell_index = {4}; }); },
      [](Model& m) { change_extras(m, [](FileExtras& e) { e.atom_list.name = "list"; }); }};
  for (std::size_t k = 0; k < changes.size(); ++k) {
    other = model;
    changes[k](other);
    EXPECT_FALSE(model == other) << "change " << k;
  }
}

TEST(SetMaterial, MassesSumToDensityTimesVolume) {
  for (Model model : {make_block({0.1, 0.02, 0.03}, 5, 2, 3), make_cylinder(0.01, 0.04, 3, 8, 11),
                      make_tetrahedral_block({0.1, 0.1, 0.1}, 4, 4, 4, 0.2, 1), make_strip(0.2, 0.1, 4, 2)}) {
    double volume = 0.0;
    for (const Cell& cell : model.cells) volume += cell_volume(model, cell);
    if (model.dimension == 2) volume = 0.02;  // per metre of thickness
    set_material(model, soft);
    EXPECT_NEAR(total(model.mass), 1000.0 * volume, 1e-12 * 1000.0 * volume) << model.name;
    EXPECT_EQ(model.materials, std::vector<Material>{soft});
    for (const Cell& cell : model.cells) EXPECT_EQ(cell.material, 0);
  }
}

TEST(SetMaterial, ShareIsTheCellsVolumeOverItsVertices) {
  Model model = make_block({2, 1, 1}, 2, 1, 1);
  set_material(model, soft);
  EXPECT_NEAR(model.mass[0], 1000.0 / 8, 1e-10);
  EXPECT_NEAR(model.mass[1], 1000.0 / 4, 1e-10);  // between the two cells
}

TEST(SetMaterial, GroupsShareABodyAndUnusedMaterialsGo) {
  Model model = make_block({2, 1, 1}, 2, 1, 1);
  model.add_group("left", model.cells[0].particles);
  set_material(model, soft);
  const Material hard{1e6, 0.4, 2000.0};
  set_material(model, hard, "left");
  EXPECT_EQ(model.materials.size(), 2u);
  EXPECT_EQ(model.materials[model.cells[0].material], hard);
  EXPECT_EQ(model.materials[model.cells[1].material], soft);
  EXPECT_NEAR(total(model.mass), 3000.0, 1e-9);
  EXPECT_NEAR(model.mass[1], 3000.0 / 8, 1e-9);
  for (double young = 1e3; young < 2e3; young += 100) set_material(model, {young, 0.4, 2000.0}, "left");
  EXPECT_EQ(model.materials.size(), 2u);
}

TEST(SetMaterial, ParticlesOfNoSuchCellKeepTheirMass) {
  Model model = make_block({2, 1, 1}, 2, 1, 1);
  model.add_group("left", model.cells[0].particles);
  set_material(model, soft, "left");
  EXPECT_EQ(model.mass[2], 1.0);
  EXPECT_EQ(model.cells[1].material, -1);
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_EQ(model.notes[0], "set_material: 4 particle(s) are in no cell with a material and keep their mass");
}

TEST(SetMaterial, RefusesWhatItCannotDoAndLeavesTheModel) {
  Model model = make_block({1, 1, 1}, 1, 1, 1);
  const Model before = model;
  const auto refused = [&](const Material& material) { return message_of([&] { set_material(model, material); }); };
  EXPECT_TRUE(says(refused({0.0, 0.3, 1.0}), "Young's modulus in Pa, got 0"));
  EXPECT_TRUE(says(refused({not_a_number, 0.3, 1.0}), "Young's modulus"));
  EXPECT_TRUE(says(refused({1.0, 0.5, 1.0}), "below 1/2, got 0.5"));
  EXPECT_TRUE(says(refused({1.0, -1.0, 1.0}), "above -1 "));
  EXPECT_TRUE(says(refused({1.0, not_a_number, 1.0}), "Poisson"));
  EXPECT_TRUE(says(refused({1.0, 0.3, -2.0}), "density in kg/m^3, got -2"));
  EXPECT_TRUE(says(refused({1.0, 0.3, std::numeric_limits<double>::infinity()}), "density in kg/m^3, got inf"));
  EXPECT_TRUE(refuses([&] { set_material(model, soft, "x0"); }, "it holds none whole"));
  EXPECT_EQ(model, before);
  std::swap(model.cells[0].particles[0], model.cells[0].particles[2]);
  std::swap(model.cells[0].particles[4], model.cells[0].particles[6]);
  EXPECT_TRUE(says(refused(soft), "run check_mesh first"));
  EXPECT_EQ(model.mass, before.mass);
  EXPECT_TRUE(model.materials.empty());
  model.cells.clear();
  model.components.clear();
  for (Vec3& p : model.rest) p.z() = 0.0;
  EXPECT_TRUE(says(refused(soft), "not in one plane, but those of particle 0 are"));
  model = before;
  model.mass.clear();
  EXPECT_TRUE(says(refused(soft), "expected 8 rows in mass"));
  model = before;
  model.cells[0].particles[7] = 8;
  EXPECT_TRUE(says(refused(soft), "expected particles from 0 to 7, got 8"));
}

TEST(Model, SpacingAndSize) {
  const Model model = make_block({3, 2, 1}, 3, 2, 1);
  EXPECT_DOUBLE_EQ(mean_spacing(model), 1.0);
  EXPECT_DOUBLE_EQ(body_size(model), 3.0);
  EXPECT_EQ(mean_spacing(Model{}), 0.0);
  EXPECT_EQ(body_size(Model{}), 0.0);
}

TEST(Validate, NamesTheFirstOffender) {
  struct Case {
    std::function<void(Model&)> spoil;
    const char* text;
  };
  const std::vector<Case> cases{
      {[](Model& m) { m.dimension = 4; }, "expected dimension 2 or 3, got 4"},
      {[](Model& m) { m = Model{}; }, "expected at least one particle"},
      {[](Model& m) { m.mass.pop_back(); }, "expected 8 rows in mass, one per particle, got 7"},
      {[](Model& m) { m.stiffness.push_back(1); }, "expected 8 rows in stiffness, one per particle, got 9"},
      {[](Model& m) { change_extras(m, [](FileExtras& e) { e.particle_index.resize(3); }); },
       "expected extras of 8 particles, as the model has, got those of 3; set Model::extras to null"},
      {[](Model& m) { change_extras(m, [](FileExtras& e) { e.particle_name.resize(3); }); }, "expected extras of 8"},
      {[](Model& m) { change_extras(m, [](FileExtras& e) { e.particle_fields.resize(3); }); }, "expected extras of 8"},
      {[](Model& m) { m.rest[5].y() = not_a_number; }, "particle 5: expected finite coordinates"},
      {[](Model& m) {
         m.cells[0].cuts.push_back({1, 1, -1, -1});
       },
       "expected cuts of tetrahedra and triangles alone"},
      {[](Model& m) { m.mass[2] = m.mass[6] = 0.0; }, "particle 2: expected a positive, finite mass"},
      {[](Model& m) { m.mass[2] = INFINITY; }, "particle 2: expected a positive, finite mass"},
      {[](Model& m) { m.stiffness[3] = -1.0; }, "particle 3: expected a finite stiffness"},
      {[](Model& m) { m.neighbours.offset.pop_back(); }, "expected 8 rows in neighbours"},
      {[](Model& m) { m.neighbours.offset[3] = 1; }, "particle 2: expected neighbour offsets that never decrease"},
      {[](Model& m) { m.neighbours.entry.push_back(0); }, "expected the last neighbour offset to be 25, got 24"},
      {[](Model& m) { m.neighbours.offset.clear(); }, "expected the neighbour offsets to start with 0"},
      {[](Model& m) { m.neighbours.entry[4] = 8; }, "particle 1: expected neighbours from 0 to 7, got 8"},
      {[](Model& m) { m.cells[0].particles.pop_back(); }, "cell 0 (HEXAHEDRON): expected 8 particles, got 7"},
      {[](Model& m) { m.cells[0].particles[1] = -1; }, "cell 0 (HEXAHEDRON): expected particles from 0 to 7, got -1"},
      {[](Model& m) { m.cells[0].material = 0; }, "cell 0 (HEXAHEDRON): expected a material from 0 to -1, got 0"},
      {[](Model& m) {
         m.materials.push_back({1, 0.7, 1});
       },
       "Poisson's ratio"},
      {[](Model& m) { m.components[0].parent = 1; }, "component 0 \"Exclusive Components\": expected a parent"},
      {[](Model& m) { m.components[1].cells = {1}; }, "component 1 \"Elements\": expected cells from 0 to 0, got 1"},
      {[](Model& m) { m.components[1].cell_refs = {-1}; }, "expected references to cells from 0 to 0, got -1"},
      {[](Model& m) { m.components[1].particles = {9}; }, "expected particles from 0 to 7, got 9"},
      {[](Model& m) { m.dimension = 2; }, "particle 4: expected z = 0 in a two-dimensional model"}};
  for (const Case& c : cases) {
    Model model = make_block({1, 1, 1}, 1, 1, 1);
    ASSERT_NO_THROW(validate(model));
    c.spoil(model);
    EXPECT_TRUE(refuses([&] { validate(model); }, c.text));
  }
}

/// Of two triangles of a wall one is removed.
TEST(Validate, MassesOfWhatIsLeftOfAWall) {
  const Surface square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}, {}};
  Model wall = make_wall(square, {.material = {.young = 1e4, .poisson = 0.4, .density = 1e3, .thickness = 1e-3}});
  wall.cells[0].share = 0.0;
  wall.mass[1] = 0.0;
  EXPECT_NO_THROW(validate(wall));
  wall.mass[0] = 0.0;
  EXPECT_TRUE(refuses([&] { validate(wall); }, "particle 0: expected a positive, finite mass, got 0 kg"));
}

TEST(Validate, SpeaksOfFileIndices) {
  Model model = make_tetrahedron(1.0);
  change_extras(model, [](FileExtras& extras) {
    extras.particle_index = {10, 20, 30, 40};
    extras.cell_index = {77};
  });
  model.mass[2] = -1.0;
  EXPECT_TRUE(refuses([&] { validate(model); }, "particle 2 (file index 30)"));
  model.mass[2] = 1.0;
  model.cells[0].particles.resize(3);
  EXPECT_TRUE(refuses([&] { validate(model); }, "cell 0 (TETRAHEDRON, file index 77)"));
}

std::vector<Index> row(const RaggedList& list, Index i) {
  return {list.begin(i), list.end(i)};
}

TEST(NeighboursFromCells, FollowTheEdgesInIncreasingOrder) {
  const auto cell = [](CellType type, std::vector<Index> particles) {
    return Cell{.type = type, .particles = std::move(particles)};
  };
  const RaggedList pyramid = neighbours_from_cells({cell(CellType::pyramid, {4, 3, 2, 1, 0})}, 6);
  EXPECT_EQ(row(pyramid, 0), (std::vector<Index>{1, 2, 3, 4}));
  EXPECT_EQ(row(pyramid, 4), (std::vector<Index>{0, 1, 3}));
  EXPECT_TRUE(row(pyramid, 5).empty());
  const RaggedList mixed = neighbours_from_cells(
      {cell(CellType::line, {5, 0}), cell(CellType::triangle, {0, 1, 2}), cell(CellType::tetrahedron, {0, 1, 2, 3}),
       cell(CellType::quad, {2, 3, 4, 5}), cell(CellType::poly_vertex, {0, 4}), cell(CellType::atom, {1})},
      6);
  EXPECT_EQ(row(mixed, 0), (std::vector<Index>{1, 2, 3, 5}));
  EXPECT_EQ(row(mixed, 2), (std::vector<Index>{0, 1, 3, 5}));
  EXPECT_EQ(row(mixed, 4), (std::vector<Index>{3, 5}));
  const RaggedList wedge = neighbours_from_cells({cell(CellType::wedge, {0, 1, 2, 3, 4, 5})}, 6);
  EXPECT_EQ(row(wedge, 1), (std::vector<Index>{0, 2, 4}));
  EXPECT_EQ(row(neighbours_from_cells({cell(CellType::line, {1, 1})}, 2), 1), std::vector<Index>{});
  EXPECT_TRUE(refuses([&] { neighbours_from_cells({cell(CellType::line, {0, 2})}, 2); }, "from 0 to 1, got one"));
  const Cell short_of_two = cell(CellType::tetrahedron, {0, 1});
  EXPECT_TRUE(refuses([&] { neighbours_from_cells({short_of_two}, 2); }, "of 4 particles, got 2"));
  EXPECT_TRUE(refuses([&] { cell_volume(make_tetrahedron(1.0), short_of_two); }, "of 4 particles, got 2"));
}

TEST(Group, OfRowsThatAreNotThereIsRefused) {
  Model model = make_tetrahedron(2.0);
  Component component{.name = "broken", .particles = {1, 4}};
  model.components.push_back(component);
  EXPECT_TRUE(refuses([&] { (void)model.group("broken"); }, "expected particles from 0 to 3, got 4"));
  model.components.back().particles = {-1};
  EXPECT_TRUE(refuses([&] { (void)model.group("broken"); }, "expected particles from 0 to 3, got -1"));
  model.components.back().particles = {};
  model.components.back().cells = {123456789};
  EXPECT_TRUE(refuses([&] { (void)model.group("broken"); }, "expected cells from 0 to 0, got 123456789"));
}

TEST(State, RestStateAndFiniteness) {
  const Model model = make_tetrahedron(2.0);
  State state = rest_state(model);
  EXPECT_EQ(state.position, model.rest);
  EXPECT_EQ(state.velocity, VecList(4, Vec3::Zero()));
  EXPECT_EQ(state.time, 0.0);
  EXPECT_TRUE(is_finite(state));
  state.velocity[3].z() = INFINITY;
  EXPECT_FALSE(is_finite(state));
  state = rest_state(model);
  state.position[0].x() = not_a_number;
  EXPECT_FALSE(is_finite(state));
  state = rest_state(model);
  state.time = not_a_number;
  EXPECT_FALSE(is_finite(state));
}

}  // namespace
}  // namespace phymul

// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <locale>
#include <sstream>
#include <stdexcept>

#include "base/files.h"
#include "io/vtk/vtk_parts.h"
#include "support/message_of.h"
#include "support/text_file.h"

namespace phymul {
namespace {

/// A smooth deformation with velocities: every number has all its digits.
State bent(const Model& model) {
  State state = rest_state(model);
  state.time = 1.0 / 3.0;
  for (Index i = 0; i < model.particle_count(); ++i) {
    const Vec3& rest = model.rest[i];
    state.position[i] = rest + Vec3(0.1 * rest.z() * std::sin(40.0 * rest.z()), rest.x() / 7.0, 1e-3 / 3.0);
    state.velocity[i] = Vec3(rest.y() / 3.0, -1.0 / 7.0, i * 1e-9);
  }
  return state;
}

/// Values of the named appended array of a file that write_vtu wrote.
std::vector<double> appended(const std::string& file, const std::string& name, std::size_t count) {
  const std::size_t element = file.find("Name=\"" + name + '"');
  EXPECT_NE(element, std::string::npos) << name;
  if (element == std::string::npos) return {};
  const std::size_t offset = std::stoul(file.substr(file.find("offset=\"", element) + 8));
  const std::string_view data = std::string_view(file).substr(file.find("\n_", file.find("<AppendedData")) + 2);
  const std::string bytes = decode_vtu_array(data.substr(offset), {.header_type = NumberType::uint64}, 8 * count, name);
  std::vector<double> values(count);
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

TEST(Writer, VtuComesBackAsItWas) {
  for (const Model& model : {make_cylinder(0.01, 0.04, 2, 6, 5), make_block({0.03, 0.02, 0.01}, 3, 2, 1),
                             make_tetrahedral_block({0.03, 0.02, 0.01}, 3, 2, 2, 0.2, 5)}) {
    const State state = bent(model);
    const TextFile file("frame.vtu", "");
    write_vtu(model, state, file.path());
    const Model back = read_mesh(file.path());

    EXPECT_EQ(back.rest, state.position);
    ASSERT_EQ(back.cells.size(), model.cells.size());
    for (std::size_t c = 0; c < model.cells.size(); ++c) {
      EXPECT_EQ(back.cells[c].type, model.cells[c].type);
      EXPECT_EQ(back.cells[c].particles, model.cells[c].particles);
    }
    std::size_t groups = 0;
    for (const Component& component : model.components) {
      const std::vector<Index> members = model.group(component.name);
      if (members.empty() || members.size() == model.rest.size()) continue;
      EXPECT_EQ(back.group(component.name), members) << component.name;
      ++groups;
    }
    EXPECT_GE(groups, 2u);
  }
}

TEST(Writer, VtuHoldsTheFieldsExactly) {
  const Model model = make_block({0.03, 0.02, 0.01}, 3, 2, 1);
  const State state = bent(model);
  const std::size_t n = model.rest.size();
  Field field{"heat & \"cold\"", std::vector<double>(n)};
  for (std::size_t i = 0; i < n; ++i) field.values[i] = 1.0 / static_cast<double>(i + 3);
  const TextFile file("frame.vtu", "");
  write_vtu(model, state, file.path(), {field});

  const std::string text = text_of(file.path());
  EXPECT_EQ(appended(text, "heat &amp; &quot;cold&quot;", n), field.values);
  EXPECT_EQ(appended(text, "mass", n), model.mass);
  const std::vector<double> velocity = appended(text, "velocity", 3 * n);
  const std::vector<double> displacement = appended(text, "displacement", 3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(Vec3(velocity[3 * i], velocity[3 * i + 1], velocity[3 * i + 2]), state.velocity[i]);
    EXPECT_EQ(Vec3(displacement[3 * i], displacement[3 * i + 1], displacement[3 * i + 2]),
              Vec3(state.position[i] - model.rest[i]));
  }
  EXPECT_TRUE(says(text, ">0.3333333333333333<"));  // TimeValue
}

TEST(Writer, VtuOfABodyWithoutCellsHasVertices) {
  Model model = make_block({1, 1, 1}, 1, 1, 1);
  model.cells.clear();
  model.components.clear();
  const TextFile file("cloud.vtu", "");
  write_vtu(model, rest_state(model), file.path());
  EXPECT_TRUE(says(text_of(file.path()), "NumberOfPoints=\"8\" NumberOfCells=\"8\""));
}

TEST(Writer, VtuNamesAreXmlWhateverTheyHold) {
  Model model = make_block({1, 1, 1}, 1, 1, 1);
  model.add_group("<a>\a&\"b\"", {1, 2});
  const TextFile file("names.vtu", "");
  write_vtu(model, rest_state(model), file.path());
  const std::string text = text_of(file.path());
  EXPECT_TRUE(says(text, "Name=\"group:&lt;a&gt;?&amp;&quot;b&quot;\""));
  EXPECT_EQ(text.find("group:Elements"), std::string::npos) << "all particles are no group";
  EXPECT_EQ(read_mesh(file.path()).group("<a>?&\"b\""), (std::vector<Index>{1, 2}));
}

TEST(Writer, DraftsGoWhateverStopsTheWriting) {
  const TextFile file("kept.txt", "as it was");
  EXPECT_THROW(replace_file(file.path(),
                            [](std::ostream& out) {
                              out << "half";
                              throw std::runtime_error("no more");
                            }),
               std::runtime_error);
  EXPECT_EQ(text_of(file.path()), "as it was");
  const std::filesystem::directory_iterator files(std::filesystem::path(file.path()).parent_path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(Writer, SeriesIsCompleteAfterEveryFrame) {
  const Model model = make_block({0.03, 0.02, 0.01}, 1, 1, 1);
  const TextFile marker("marker", "");
  const std::string stem = std::filesystem::path(marker.path()).replace_filename("run").string();
  VtkSeries series(stem);
  State state = rest_state(model);
  for (std::size_t frame = 1; frame <= 3; ++frame) {
    state.time += 0.1;
    series.write(model, state);
    EXPECT_EQ(series.frames(), frame);
    const std::string list = text_of(stem + ".pvd");
    EXPECT_TRUE(says(list, "</VTKFile>"));
    std::size_t listed = 0;
    for (std::size_t at = list.find("<DataSet"); at != std::string::npos; at = list.find("<DataSet", at + 1)) ++listed;
    EXPECT_EQ(listed, frame);
  }
  EXPECT_TRUE(says(text_of(stem + ".pvd"), "timestep=\"0.30000000000000004\" part=\"0\" file=\"run_000002.vtu\""));
  EXPECT_EQ(read_mesh(stem + "_000001.vtu").rest, model.rest);
}

TEST(Writer, CsvHoldsEveryNumberExactly) {
  const Model model = make_block({0.03, 0.02, 0.01}, 2, 1, 1);
  const State state = bent(model);
  const TextFile file("state.csv", "");
  write_csv(model, state, file.path());

  std::istringstream in(text_of(file.path()));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "particle,x,y,z,ux,uy,uz,vx,vy,vz");
  for (Index i = 0; i < model.particle_count(); ++i) {
    ASSERT_TRUE(std::getline(in, line));
    std::istringstream words(line);
    std::string word;
    std::vector<double> values;
    while (std::getline(words, word, ',')) values.push_back(std::strtod(word.c_str(), nullptr));
    ASSERT_EQ(values.size(), 10u);
    EXPECT_EQ(values[0], i);
    EXPECT_EQ(Vec3(values[1], values[2], values[3]), state.position[i]);
    EXPECT_EQ(Vec3(values[4], values[5], values[6]), Vec3(state.position[i] - model.rest[i]));
    EXPECT_EQ(Vec3(values[7], values[8], values[9]), state.velocity[i]);
  }
  EXPECT_FALSE(std::getline(in, line));
}

/// As in much of Europe: 1.234,5.
class CommaNumbers : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Writer, WritesTheSameInEveryLocale) {
  const Model model = make_block({0.03, 0.02, 0.01}, 11, 9, 9);
  const State state = bent(model);
  const TextFile here("here.vtu", "");
  const std::string csv = std::filesystem::path(here.path()).replace_filename("here.csv").string();
  write_vtu(model, state, here.path());
  write_csv(model, state, csv);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new CommaNumbers));
  write_vtu(model, state, here.path() + "2");
  write_csv(model, state, csv + "2");
  std::locale::global(before);
  EXPECT_EQ(text_of(here.path()), text_of(here.path() + "2"));
  EXPECT_EQ(text_of(csv), text_of(csv + "2"));
}

TEST(Writer, DeformedModelHasTheStateAsItsRestShape) {
  const Model model = make_block({0.03, 0.02, 0.01}, 2, 1, 1);
  const State state = bent(model);
  const Model deformed = deformed_model(model, state);
  EXPECT_EQ(deformed.rest, state.position);
  EXPECT_EQ(deformed.cells, model.cells);
  EXPECT_EQ(deformed.neighbours, model.neighbours);
}

TEST(Writer, DeformedModelTakesItsFibresAlong) {
  for (Model model :
       {make_block({0.03, 0.02, 0.01}, 2, 1, 1), make_tetrahedral_block({0.03, 0.02, 0.01}, 2, 1, 1, 0.1, 3)}) {
    for (Cell& cell : model.cells) cell.fibre = {2, 0, 0};
    Mat3 motion;
    motion << 0, -1, 0.3, 1.5, 0, 0, 0, 0, 0.9;
    State state = rest_state(model);
    for (Vec3& x : state.position) x = motion * x + Vec3(1, 2, 3);
    const Model deformed = deformed_model(model, state);
    for (const Cell& cell : deformed.cells) EXPECT_LT((cell.fibre - Vec3(0, 3, 0)).norm(), 1e-10);
  }
}

TEST(Writer, RefusesAStateOfAnotherModel) {
  const Model model = make_block({0.03, 0.02, 0.01}, 2, 1, 1);
  const State other = rest_state(make_block({0.03, 0.02, 0.01}, 1, 1, 1));
  const TextFile file("kept.vtu", "as it was");
  EXPECT_THROW(write_vtu(model, other, file.path()), Error);
  EXPECT_THROW(write_csv(model, other, file.path()), Error);
  EXPECT_THROW(deformed_model(model, other), Error);
  EXPECT_THROW(write_vtu(model, rest_state(model), file.path(), {{"short", {1.0}}}), Error);
  EXPECT_EQ(text_of(file.path()), "as it was");
}

TEST(Writer, RefusesFieldsWithoutANameOfTheirOwn) {
  Model model = make_block({0.03, 0.02, 0.01}, 1, 1, 1);
  model.add_group("a\x01", {1});
  const TextFile file("fields.vtu", "as it was");
  const std::vector<double> values(8, 1.0);
  const std::vector<std::vector<phymul::Field>> bad{{{"", values}},
                                                    {{"mass", values}},
                                                    {{"a", values}, {"a", values}},
                                                    {{"group:x0", values}},
                                                    {{"a\x01", values}, {"a?", values}},
                                                    {{"group:a?", values}}};
  for (const std::vector<phymul::Field>& fields : bad) {
    EXPECT_THROW(write_vtu(model, rest_state(model), file.path(), fields), Error);
  }
  EXPECT_EQ(text_of(file.path()), "as it was");
}

TEST(Writer, WritesThroughALinkAndIntoADevice) {
  const Model model = make_block({0.03, 0.02, 0.01}, 1, 1, 1);
  const State state = rest_state(model);
  const TextFile file("behind.csv", "");
  const std::string link = file.path() + ".link";
  std::error_code no_links;
  std::filesystem::create_symlink(file.path(), link, no_links);
  if (no_links) GTEST_SKIP() << "no links to files on this system: " << no_links.message();
  write_csv(model, state, link);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_FALSE(text_of(file.path()).empty());
  // Through a link of our own: where this fails, it is not the machine's device that is lost.
  const std::string device = file.path() + ".device";
  std::filesystem::create_symlink("/dev/full", device);
  if (std::filesystem::is_character_file(device)) {
    EXPECT_THROW(write_csv(model, state, device), Error);
    EXPECT_TRUE(std::filesystem::is_symlink(device));
  }
  std::filesystem::remove(link);
  std::filesystem::remove(device);
}

TEST(Writer, LeavesNothingBehindWhereItCannotWrite) {
  const Model model = make_block({0.03, 0.02, 0.01}, 1, 1, 1);
  const TextFile file("folder_in_the_way", "");
  const std::string folder = std::filesystem::path(file.path()).replace_filename("frame.vtu").string();
  std::filesystem::create_directory(folder);
  EXPECT_THROW(write_vtu(model, rest_state(model), folder), Error);
  const std::filesystem::directory_iterator files(std::filesystem::path(folder).parent_path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 2) << "the file in the way and the folder";
  EXPECT_THROW(write_csv(model, rest_state(model), folder + "_none/a.csv"), Error);
}

}  // namespace
}  // namespace phymul

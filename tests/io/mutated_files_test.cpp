// SPDX-License-Identifier: MIT
//
// Damaged files: each either reads into a valid model, which then survives a round trip, or throws phymul::Error.
#include <phymul/lml.h>
#include <phymul/shapes.h>

#include <array>
#include <ctime>
#include <filesystem>
#include <functional>
#include <random>

#include "io/mesh/mesh_parts.h"
#include "support/pml_text.h"
#include "support/text_file.h"

namespace phymul {
namespace {

constexpr int mutants = 1000;
constexpr double seconds_each = 2.0;  // of processor time; two thousand times what a sample takes in a release build

/// A small body with everything that the reader knows.
std::string rich_pml() {
  const std::string colour = "<color r=\"0.1\" g=\"0.2\" b=\"0.3\" a=\"0.4\"/>";
  const std::string after =
      "<informativeComponents>\n<multiComponent name=\"I\">\n<multiComponent name=\"J\">\n"
      "<structuralComponent name=\"G\" mode=\"NONE\">\n<cellRef index=\"4\"/>\n<atomRef index=\"2\"/>\n"
      "</structuralComponent>\n</multiComponent>\n<structuralComponent name=\"Neighborhoods\" stiffness=\"2\" "
      "mass=\"1\">\n" +
      cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\" index=\"50\" eta=\"x\"", colour) + "\n" +
      cell_text("POLY_VERTEX", {0, 2, 3}, "name=\"Atom #1\" stiffness=\"4\"") + "\n" +
      cell_text("POLY_VERTEX", {0, 1}, "name=\"Atom #3\" phymul=\"unnumbered\"") +
      "\n</structuralComponent>\n</multiComponent>\n</informativeComponents>\n";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!DOCTYPE physicalModel>\n" +
         replaced(pml_text(tetrahedron_atoms,
                           {colour,
                            cell_text("TETRAHEDRON", {0, 1, 2, 3},
                                      "index=\"4\" young=\"1e3\" poisson=\"0.4\" density=\"1000\" phymul=\"row=1\""),
                            cell_text("LINE", {0, 3}, "index=\"5\" phymul=\"row=0\""), "<unknown a=\"&amp;&#10;\"/>"},
                           after, "comment=\"c\" nrOfAtoms=\"4\""),
                  "z=\"0\"/>", "z=\"0\" name=\"tip\" fixed=\"1\" mass=\"2\"/>");
}

const char* const rich_lml =
    "<loads xmlns:xsi='x'>\n<load xsi:type='Translation'>\n<appliedTo>1, 2,3-5</appliedTo>\n"
    "<valueEvent date='0' value='1'/>\n<valueEvent date='1e0' value='-2.5'/>\n<direction x='NULL' y='1'/>\n"
    "<unit>micron</unit>\n</load>\n<load type='Pressure'>\n<?phymul generated?>\n<appliedTo>*</appliedTo>\n"
    "<valueEvent date='0' value='1'/>\n<unit>mmHg</unit>\n</load>\n<load xsi:type='Force'>\n"
    "<appliedTo>Tip</appliedTo>\n<valueEvent date='0.5' value='3'/>\n<direction toward='7'/>\n<unit>pN</unit>\n"
    "</load>\n</loads>\n";

/// Damages a text as disks, editors and ill will do.
class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {}

  std::string mutate(std::string text) {
    for (std::size_t times = 1 + below(3); times > 0 && !text.empty(); --times) mutate_once(text);
    return text;
  }

 private:
  // Not a distribution: those differ between standard libraries.
  std::size_t below(std::size_t end) { return end == 0 ? 0 : random_() % end; }

  void mutate_once(std::string& text) {
    const std::size_t at = below(text.size());
    switch (below(11)) {
      case 0:
        text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        break;
      case 1:
        text.erase(at, 1 + below(8));
        break;
      case 2:
        text.resize(at);
        break;
      case 3:
        copy_line(text, at, true);
        break;
      case 4:
        copy_line(text, at, false);
        break;
      case 5:
      case 6:
        set_value(text, value_at_random(text));
        break;
      case 7:
      case 8:
        set_value(text, extremes_[below(extremes_.size())]);
        break;
      case 9:
        text.insert(at, std::string(1 + below(3), "<>&\"'/?![]-#;= \0"[below(16)]));
        break;
      default:
        for (std::size_t times = below(200); times > 0; --times) text.insert(at, text.substr(at, 20));
    }
  }

  /// Duplicates or removes the line around a place.
  void copy_line(std::string& text, std::size_t at, bool duplicate) {
    const std::size_t before = text.rfind('\n', at);
    const std::size_t start = before == std::string::npos ? 0 : before + 1;
    const std::size_t end = std::min(text.find('\n', start), text.size() - 1) + 1;
    if (start >= end) return;
    const std::string line = text.substr(start, end - start);
    if (duplicate) {
      text.insert(below(2) == 0 ? start : 0, line);
    } else {
      text.erase(start, end - start);
    }
  }

  /// Start and end of a quoted value.
  std::pair<std::size_t, std::size_t> random_value(const std::string& text) {
    const std::size_t equals = text.find('=', below(text.size()));
    if (equals == std::string::npos || equals + 2 >= text.size()) return {0, 0};
    const std::size_t end = text.find(text[equals + 1], equals + 2);
    return end == std::string::npos ? std::pair<std::size_t, std::size_t>{0, 0} : std::pair{equals + 2, end};
  }

  std::string value_at_random(const std::string& text) {
    const auto [start, end] = random_value(text);
    return text.substr(start, end - start);
  }

  void set_value(std::string& text, const std::string& value) {
    const auto [start, end] = random_value(text);
    if (end > 0) text.replace(start, end - start, value);
  }

  std::mt19937 random_;
  const std::array<std::string, 20> extremes_ = {"1e308",
                                                 "-1e308",
                                                 "1e-320",
                                                 "-5",
                                                 "2147483647",
                                                 "2147483648",
                                                 "4294967296",
                                                 "1e999",
                                                 "nan",
                                                 "inf",
                                                 "",
                                                 "NULL",
                                                 "0",
                                                 "row=7",
                                                 "row=0 loose",
                                                 "*",
                                                 "0-2147483647",
                                                 "unlisted",
                                                 "99999999999999999999",
                                                 "Neighborhoods"};
};

struct Outcome {
  int read = 0;
  int refused = 0;
};

/// Reads mutants of a file's bytes. Anything but an Error that names the file escapes or fails the test.
Outcome read_mutants(const std::string& name, const std::string& text, std::uint32_t seed, int count,
                     const std::function<void(const std::string&)>& read) {
  Outcome outcome;
  Mutator mutator(seed);
  for (int i = 0; i < count; ++i) {
    const std::string mutant = mutator.mutate(text);
    const std::clock_t start = std::clock();
    try {
      read(mutant);
      ++outcome.read;
    } catch (const Error& error) {
      ++outcome.refused;
      EXPECT_TRUE(std::string(error.what()).starts_with(name + ":")) << error.what();
    }
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, seconds_each) << mutant;
  }
  return outcome;
}

void expect_pml_holds(const std::string& text, std::uint32_t seed) {
  int unequal = 0;
  const Outcome outcome = read_mutants("m.xml", text, seed, mutants, [&](const std::string& mutant) {
    const Model model = read_pml_text(mutant, "m.xml");
    EXPECT_EQ(message_of([&] { validate(model); }), "(no error)") << mutant;
    // A reference to a control character is read but cannot be written; all else comes back.
    std::string once;
    if (message_of([&] { once = written(model); }) == "(no error)" && !(read_pml_text(once, "again.xml") == model)) {
      ++unequal;
      ADD_FAILURE() << "not equal after a round trip:\n" << mutant << "\nwritten:\n" << once;
    }
  });
  EXPECT_EQ(unequal, 0);
  EXPECT_GT(outcome.read, mutants / 20);
  EXPECT_GT(outcome.refused, mutants / 4);
}

TEST(MutatedFiles, TheStartReads) {
  EXPECT_EQ(read_pml_text(rich_pml(), "m.xml").cells[1].type, CellType::tetrahedron);
}

TEST(MutatedFiles, SmallPml) {
  expect_pml_holds(text_of(PHYMUL_TEST_DATA "/tetrahedron_4.pml"), 1);
}

TEST(MutatedFiles, RichPml) {
  expect_pml_holds(rich_pml(), 2);
}

TEST(MutatedFiles, WrittenPml) {
  expect_pml_holds(written(make_strip(0.02, 0.01, 2, 1)), 3);
}

void expect_lml_holds(const std::string& text, const Model& model, std::uint32_t seed) {
  const Outcome outcome = read_mutants("m.xml", text, seed, mutants, [&](const std::string& mutant) {
    const std::vector<Load> loads = read_lml_text(mutant, "m.xml", model);
    std::ostringstream out;
    if (message_of([&] { write_lml(loads, model, out); }) == "(no error)") {
      EXPECT_EQ(read_lml_text(out.str(), "again.xml", model), loads) << mutant << "\nwritten:\n" << out.str();
    }
  });
  EXPECT_GT(outcome.read, mutants / 20);
  EXPECT_GT(outcome.refused, mutants / 4);
}

TEST(MutatedFiles, SampleLml) {
  expect_lml_holds(text_of(PHYMUL_SAMPLE_DATA "/cylinder_275_pull.lml"),
                   read_pml(PHYMUL_SAMPLE_DATA "/cylinder_275.pml"), 4);
}

TEST(MutatedFiles, RichLml) {
  Model model = make_block({0.04, 0.01, 0.01}, 4, 1, 1);
  model.add_group("Tip", {3, 1});
  expect_lml_holds(rich_lml, model, 5);
}

TEST(MutatedFiles, Meshes) {
  Outcome all;
  for (const auto& file : std::filesystem::directory_iterator(PHYMUL_TEST_DATA "/mesh")) {
    const std::string name = "m" + file.path().extension().string();
    const Outcome one =
        read_mutants(name, text_of(file.path().string()), 6, mutants / 4, [&](const std::string& mutant) {
          EXPECT_EQ(message_of([model = mesh_from_bytes(name, mutant, {})] { validate(model); }), "(no error)");
        });
    all.read += one.read;
    all.refused += one.refused;
  }
  EXPECT_GT(all.read, mutants / 5);
  EXPECT_GT(all.refused, mutants);
}

}  // namespace
}  // namespace phymul

// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>

#include "truth_table.h"

namespace phymul::bench {
namespace {

// The coarsest body of each case that takes well under a second: its error, as docs/measurements/truth.md has it, is
// met to 0.1 % of the known value, so that a change of the law or of a case is seen. 1e-3 as the frequencies' window.
TEST(Truth, CoarseBodiesKeepTheirErrors) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "phymul_truth_test";
  std::filesystem::create_directories(folder);
  {
    TruthTable table(PHYMUL_REFERENCE_CASES "/measured.csv", folder.string());
    for (const char* name : {"brain", "cook finite", "cook small", "sphere", "torsion"}) {
      const auto& cases = static_cases().contains(name) ? static_cases() : solid_cases();
      cases.at(name)(table, true);
    }
    for (const char* name : {"cantilever", "wave"}) motion_cases().at(name)(table, true);
    const std::map<std::string, double> expected{
        {"brain; tension 1.1, mu 1 kPa; one cube", 0.0},
        {"brain; compression 0.9, mu 1 kPa; one cube", 0.0},
        {"brain; shear 0.2, mu 1 kPa; one cube", 0.0},
        {"brain; compression 0.9; fit of all", -0.3312},
        {"cook finite; limit; 4 a side", -0.1557},
        {"cook finite; limit; 4 a side, tetrahedra", -0.0663},
        {"cook finite; with the other volume law; 4 a side", -0.1551},
        {"cook small; u E t / F; 4 a side", -0.2698},
        {"sphere; inner radius nu 0.30; 4 x 5", 0.0088},
        {"sphere; outer radius nu 0.45; 4 x 5", 0.0072},
        {"torsion; ends free to warp L / a 4; 4 across, lattice", 0.0973},
        {"torsion; bonded ends L / a 4; 4 across, lattice", 0.1063},
        {"cantilever; first bending Hz; 3 across, step 0.90", 0.0036},
        {"cantilever; first torsion Hz; 3 across, step 0.90", -0.0167},
        {"cantilever; second bending Hz; 3 across, step 0.90, tetrahedra", -0.0261},
        {"wave; speed m/s nu 0.00; 2 across, step 0.90", -0.0098},
        {"wave; speed m/s nu 0.30; 2 across, step 0.90", -0.0159},
    };
    for (const auto& [name, error] : expected) {
      ASSERT_TRUE(table.errors().contains(name)) << name;
      EXPECT_NEAR(table.errors().at(name), error, 1e-3) << name;
    }
  }
  std::filesystem::remove_all(folder);
}

TEST(Truth, NamesWhatIsNotMeasured) {
  const std::string folder = std::filesystem::temp_directory_path().string();
  EXPECT_THROW(TruthTable("no such file.csv", folder), Error);
  const TruthTable table(PHYMUL_REFERENCE_CASES "/measured.csv", folder);
  EXPECT_THROW(table.measured("beam", "2 N mark 1"), Error);
  EXPECT_DOUBLE_EQ(table.measured("beam", "0 N mark 1").mean(), -6.74);
}

}  // namespace
}  // namespace phymul::bench

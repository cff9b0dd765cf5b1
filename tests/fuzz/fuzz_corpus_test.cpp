// SPDX-License-Identifier: MIT
//
// The files of corpus/, among them all that a fuzz target ever found, and the samples of tests/data through their
// targets: what was mended stays so.
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

#include "fuzz_target.h"
#include "support/text_file.h"

namespace phymul::fuzz {

void PrintTo(const NamedTarget& target, std::ostream* out) {
  *out << target.name;
}

namespace {

class FuzzCorpus : public testing::TestWithParam<NamedTarget> {};

TEST_P(FuzzCorpus, Holds) {
  int files = 0;
  const auto hold = [&](const std::filesystem::path& file) {
    SCOPED_TRACE(file.filename().string());
    EXPECT_NO_THROW(GetParam().run(text_of(file.string())));
    ++files;
  };
  const std::filesystem::path found = std::filesystem::path(PHYMUL_FUZZ_CORPUS) / GetParam().name;
  if (std::filesystem::exists(found)) {
    for (const auto& entry : std::filesystem::directory_iterator(found)) hold(entry.path());
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(PHYMUL_TEST_DATA)) {
    if (entry.is_regular_file() && entry.path().extension() == GetParam().ending) hold(entry.path());
  }
  EXPECT_GT(files, 0);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(all_targets),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace phymul::fuzz

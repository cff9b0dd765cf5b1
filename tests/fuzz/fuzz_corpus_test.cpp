// SPDX-License-Identifier: MIT
//
// The files of corpus/, among them all that a fuzz target ever found, through their targets: what was mended stays so.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz_target.h"
#include "support/text_file.h"

namespace phymul::fuzz {
namespace {

class FuzzCorpus : public testing::TestWithParam<NamedTarget> {};

TEST_P(FuzzCorpus, Holds) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(PHYMUL_FUZZ_CORPUS "/") + GetParam().name)) {
    SCOPED_TRACE(entry.path().filename().string());
    EXPECT_NO_THROW(GetParam().run(text_of(entry.path().string())));
    ++files;
  }
  EXPECT_GT(files, 0);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(all_targets),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace phymul::fuzz

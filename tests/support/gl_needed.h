// SPDX-License-Identifier: MIT
//
// Tests that need a GL: skipped, with the reason, on a machine that has none, and failed where PHYMUL_REQUIRE_GL=1 says
// that it should have one.
#pragma once

#include <gtest/gtest.h>
#include <phymul/error.h>

#include <cstdlib>
#include <string>
#include <string_view>

namespace phymul::test {

inline bool gl_is_required() {
  const char* wish = std::getenv("PHYMUL_REQUIRE_GL");
  return wish && std::string_view(wish) == "1";
}

}  // namespace phymul::test

/// In a test or SetUp: skips or fails it unless `reason`, a sentence, is empty.
#define PHYMUL_SKIP_OR_FAIL(reason)                                                                             \
  do {                                                                                                          \
    const std::string why_not = (reason);                                                                       \
    if (!why_not.empty() && ::phymul::test::gl_is_required()) FAIL() << "PHYMUL_REQUIRE_GL=1, but " << why_not; \
    if (!why_not.empty()) GTEST_SKIP() << "NOT TESTED: " << why_not;                                            \
  } while (false)

// SPDX-License-Identifier: MIT
//
// Tests that need a GL: skipped, with the reason, on a machine that has none, and failed where PHYMUL_REQUIRE_GL=1 says
// that it should have one.
#pragma once

#include <gtest/gtest.h>
#include <phymul/solver.h>

#include <cstdlib>
#include <map>
#include <string>
#include <string_view>

#include "steps.h"

namespace phymul::test {

inline bool gl_is_required() {
  const char* wish = std::getenv("PHYMUL_REQUIRE_GL");
  return wish && std::string_view(wish) == "1";
}

/// Why this machine cannot run a backend, a sentence; empty where it can. Asked once a process, because the answer may
/// take making a context.
inline const std::string& why_not_here(const std::string& backend) {
  static std::map<std::string, std::string> known;
  const auto found = known.find(backend);
  return found != known.end() ? found->second : known.emplace(backend, why_unavailable(backend)).first->second;
}

}  // namespace phymul::test

/// In a test or SetUp: skips or fails it unless `reason`, a sentence, is empty.
#define PHYMUL_SKIP_OR_FAIL(reason)                                                                             \
  do {                                                                                                          \
    const std::string why_not = (reason);                                                                       \
    if (!why_not.empty() && ::phymul::test::gl_is_required()) FAIL() << "PHYMUL_REQUIRE_GL=1, but " << why_not; \
    if (!why_not.empty()) GTEST_SKIP() << "NOT TESTED: " << why_not;                                            \
  } while (false)

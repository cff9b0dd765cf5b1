// SPDX-License-Identifier: MIT
//
// Suites that run on every backend of the build. Nothing is asked of a backend before a test begins: on a machine that
// cannot run it, its tests are skipped with the reason, or fail where PHYMUL_REQUIRE_GL=1 says that it should.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>

#include "message_of.h"

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

/// In a test or SetUp: skips or fails it unless `reason`, a sentence, is empty.
#define PHYMUL_SKIP_OR_FAIL(reason)                                                                             \
  do {                                                                                                          \
    const std::string why_not = (reason);                                                                       \
    if (!why_not.empty() && ::phymul::test::gl_is_required()) FAIL() << "PHYMUL_REQUIRE_GL=1, but " << why_not; \
    if (!why_not.empty()) GTEST_SKIP() << "NOT TESTED: " << why_not;                                            \
  } while (false)

class OnEveryBackend : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { PHYMUL_SKIP_OR_FAIL(why_not_here(GetParam())); }
};

/// "gl-compute" as a test may be called: gl_compute.
inline std::string test_name_of(std::string backend) {
  std::ranges::replace(backend, '-', '_');
  return backend;
}

}  // namespace phymul::test

#define PHYMUL_ON_BACKENDS(suite, names)                         \
  INSTANTIATE_TEST_SUITE_P(All, suite, testing::ValuesIn(names), \
                           [](const auto& backend) { return ::phymul::test::test_name_of(backend.param); })
#define PHYMUL_ON_EVERY_BACKEND(suite) PHYMUL_ON_BACKENDS(suite, ::phymul::backend_names())

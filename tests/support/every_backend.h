// SPDX-License-Identifier: MIT
//
// Suites that run on every backend of the build. Nothing is asked of a backend before a test begins: on a machine that
// cannot run it, its tests are skipped with the reason, or fail where PHYMUL_REQUIRE_GL=1 says that it should.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <string>

#include "gl_needed.h"

namespace phymul::test {

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

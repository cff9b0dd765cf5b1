// SPDX-License-Identifier: MIT
//
// Fixture of the tests of src/gl.
#pragma once

#include <dlfcn.h>
#include <phymul/solver.h>

#include <ostream>

#include "environment.h"
#include "every_backend.h"
#include "gl/context/context.h"

namespace phymul {

inline void PrintTo(GlBackend backend, std::ostream* out) {
  *out << name_of(backend);
}

}  // namespace phymul

namespace phymul::test {

/// Keeps Mesa's driver, if that is the one, to the end of the process. A leak checker looks when libraries are gone,
/// and would count what EGL's display still holds, which nobody may terminate.
inline void* const kept_driver = dlopen("libEGL_mesa.so.0", RTLD_LAZY | RTLD_NODELETE);

/// Skipped, or failed, without a GL context and what else needs() names.
class GlTest : public testing::Test {
 protected:
  void SetUp() final {
    PHYMUL_SKIP_OR_FAIL(why_no_context());
    if (!needs().empty()) PHYMUL_SKIP_OR_FAIL(why_not_here(needs()));
    set_up();
  }
  virtual std::string needs() const { return {}; }  ///< a backend, or nothing
  virtual void set_up() {}                          ///< where the test runs

 private:
  static std::string why_no_context() {
    try {
      gl::Context::open({});
      return {};
    } catch (const Error& error) {
      return error.what();
    }
  }
};

/// On "gl-compute" alone.
class OnCompute : public GlTest {
 protected:
  std::string needs() const override { return "gl-compute"; }
};

/// On both backends; the test's name ends in gl or gl_compute.
class OnBothDevices : public GlTest, public testing::WithParamInterface<GlBackend> {
 protected:
  std::string needs() const override { return name_of(GetParam()); }
};

}  // namespace phymul::test

#define PHYMUL_ON_BOTH_DEVICES(suite)                                       \
  INSTANTIATE_TEST_SUITE_P(                                                 \
      All, suite, testing::Values(GlBackend::fragment, GlBackend::compute), \
      [](const auto& backend) { return std::string(backend.param == GlBackend::fragment ? "gl" : "gl_compute"); })

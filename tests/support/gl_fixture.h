// SPDX-License-Identifier: MIT
//
// Fixture of the tests of src/gl.
#pragma once

#include <dlfcn.h>
#include <phymul/solver.h>

#include <cstdlib>
#include <optional>

#include "gl/context/context.h"
#include "gl_needed.h"

namespace phymul::test {

/// Keeps Mesa's driver, if that is the one, to the end of the process. A leak checker looks when libraries are gone,
/// and would count what EGL's display still holds, which nobody may terminate.
inline void* const kept_driver = dlopen("libEGL_mesa.so.0", RTLD_LAZY | RTLD_NODELETE);

/// An environment variable for the time of a test; null removes it. Not while other threads look.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    set(value);
  }
  ~Environment() { set(old_ ? old_->c_str() : nullptr); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  void set(const char* value) const {
    if (value) {
      setenv(name_, value, 1);
    } else {
      unsetenv(name_);
    }
  }
  const char* name_;
  std::optional<std::string> old_;
};

class GlTest : public testing::Test {
 protected:
  void SetUp() override { PHYMUL_SKIP_OR_FAIL(why_no_context()); }

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
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    PHYMUL_SKIP_OR_FAIL(why_not_here("gl-compute"));
  }
};

/// On both backends; the test's name ends in gl or gl_compute.
class OnBothDevices : public GlTest, public testing::WithParamInterface<GlBackend> {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    PHYMUL_SKIP_OR_FAIL(why_not_here(name_of(GetParam())));
  }
};

}  // namespace phymul::test

#define PHYMUL_ON_BOTH_DEVICES(suite)                                       \
  INSTANTIATE_TEST_SUITE_P(                                                 \
      All, suite, testing::Values(GlBackend::fragment, GlBackend::compute), \
      [](const auto& backend) { return std::string(backend.param == GlBackend::fragment ? "gl" : "gl_compute"); })

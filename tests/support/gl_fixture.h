// SPDX-License-Identifier: MIT
//
// Fixture of the tests of src/gl.
#pragma once

#include <dlfcn.h>
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

}  // namespace phymul::test

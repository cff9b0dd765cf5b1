// SPDX-License-Identifier: MIT
//
// Kernel: a compute program, ready to be dispatched, and what the context allows of storage and dispatches.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "program.h"

namespace phymul::gl {

struct ComputeLimits {
  std::int64_t block_bytes = 0;  ///< of a storage buffer that a shader sees
  std::int64_t groups_across = 0, groups_down = 0;
  int invocations = 0;                                                 ///< of a group
  std::int64_t loop_turns = std::numeric_limits<std::int64_t>::max();  ///< ContextInfo::loop_turns

  static ComputeLimits of_context();
};

class Kernel {
 public:
  Kernel() = default;
  /// `group` invocations a group, which the shader knows as GROUP.
  Kernel(const ShaderLibrary& library, ShaderRequest request, int group, const ComputeLimits& limits);

  explicit operator bool() const { return program_.id() != 0; }
  int group() const { return group_; }

  /// For uniforms, which stay. Makes the program current.
  void set(const char* name, int value) { glUniform1i(program_.use_uniform(name), value); }
  void set(const char* name, float value) { glUniform1f(program_.use_uniform(name), value); }

  /// Groups that hold as many invocations.
  int groups_for(std::int64_t rows) const { return static_cast<int>((rows + group_ - 1) / group_); }
  /// So many groups or more, as a rectangle where they are too many for a line. What it writes is seen by the next one.
  void dispatch(int groups);

 private:
  std::string name_;
  Program program_;
  int group_ = 1;
  ComputeLimits limits_;
};

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#include "kernel.h"

#include <phymul/error.h>

#include <algorithm>
#include <utility>

#include "gl/context/context_info.h"
#include "pass_timer.h"

namespace phymul::gl {
namespace {

std::int64_t limit(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return value;
}

std::int64_t groups_along(GLuint axis) {
  GLint count = 0;
  glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &count);
  return count;
}

ShaderRequest with_group(ShaderRequest request, int group) {
  request.defines.emplace_back("GROUP", group);
  return request;
}

}  // namespace

ComputeLimits ComputeLimits::of_context() {
  return {.block_bytes = limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE),
          .groups_across = groups_along(0),
          .groups_down = groups_along(1),
          .invocations = static_cast<int>(limit(GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS)),
          .loop_turns = loop_turns_of(gl_text(GL_RENDERER))};
}

Kernel::Kernel(const ShaderLibrary& library, ShaderRequest request, int group, const ComputeLimits& limits)
    : name_(request.name()),
      program_(Program::computing(library, with_group(std::move(request), group))),
      group_(group),
      limits_(limits) {}

void Kernel::dispatch(int groups) {
  if (groups == 0) return;
  const std::int64_t across = std::min<std::int64_t>(groups, limits_.groups_across);
  const std::int64_t down = (groups + across - 1) / across;
  if (down > limits_.groups_down) {
    throw Error(ErrorCode::not_supported,
                "a pass of " + std::to_string(groups) + " groups of " + std::to_string(group_) +
                    " rows is more than the " + std::to_string(limits_.groups_across) + " x " +
                    std::to_string(limits_.groups_down) +
                    " groups that this driver dispatches at a time; use fewer particles or bases");
  }
  glUseProgram(program_.id());
  const PassTimer::Timed timed(name_, PassTimer::Work::dispatch);
  glDispatchCompute(static_cast<GLuint>(across), static_cast<GLuint>(down), 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#include "gl/compute_report.h"

#include <algorithm>
#include <bit>

namespace phymul::gl {
namespace {

constexpr int largest_group = 256;
constexpr int rows_a_lane = 4;  // before another group is worth its launch

}  // namespace

ComputeReport::ComputeReport(const ShaderLibrary& library, const ComputePasses& passes, const ComputeState& state,
                             const ComputeLimits& limits)
    : particles_(passes.tables().kind().particles) {
  const int group =
      static_cast<int>(std::bit_floor(static_cast<unsigned>(std::min(limits.invocations, largest_group))));
  ShaderRequest request{.files = {"dialect_compute.glsl", "tables.glsl", "report_events.glsl", "report_kernel.glsl"},
                        .defines = {}};
  passes.tables().define(request);
  kernel_ = Kernel(library, std::move(request), group, limits);
  passes.tables().place(kernel_);
  state.place(kernel_);
  groups_ = std::clamp(particles_ / (group * rows_a_lane), 1, ComputeState::most_report_groups);
}

void ComputeReport::request(const ComputeState& state, int pair) {
  const int last = state.report_row() + 2 * ComputeState::most_report_groups;
  const int partial = groups_ > 1 ? state.report_row() : last;
  kernel_.set("pair", pair);
  kernel_.set("source_count", particles_);
  kernel_.set("report_place", partial);
  kernel_.dispatch(groups_);
  if (groups_ > 1) {
    kernel_.set("pair", -1);
    kernel_.set("source_count", groups_);
    kernel_.set("source_place", partial);
    kernel_.set("report_place", last);
    kernel_.dispatch(1);
  }
  copy_.request([&] {
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glBindBuffer(GL_COPY_READ_BUFFER, state.rows().id());
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_PIXEL_PACK_BUFFER, static_cast<GLintptr>(16) * last, 0, 32);
    glBindBuffer(GL_COPY_READ_BUFFER, 0);
  });
}

}  // namespace phymul::gl

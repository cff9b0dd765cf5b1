// SPDX-License-Identifier: MIT
#include "compute_report.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int largest_group = 256;
constexpr int rows_a_lane = 4;   // before another group is worth its launch
constexpr int tool_group = 128;  // whose rows fit the 16 KiB of OpenGL ES 3.1

}  // namespace

ComputeReport::ComputeReport(const ShaderLibrary& library, const ComputePasses& passes, const ComputeState& state,
                             const ComputeLimits& limits)
    : library_(&library), passes_(&passes), limits_(limits), particles_(passes.tables().kind().particles) {
  const int group =
      static_cast<int>(std::bit_floor(static_cast<unsigned>(std::min(limits.invocations, largest_group))));
  ShaderRequest request{.files = {"dialect/dialect_compute.glsl", "step/tables.glsl", "report/report_events.glsl",
                                  "report/report_kernel.glsl"},
                        .defines = {}};
  passes.tables().define(request);
  kernel_ = Kernel(library, std::move(request), group, limits);
  passes.tables().place(kernel_);
  state.place(kernel_);
  groups_ = std::clamp(particles_ / (group * rows_a_lane), 1, ComputeState::most_report_groups);
}

void ComputeReport::sum_tools(const ComputeTools& tools) {
  if (!tool_kernel_) {
    ShaderRequest request{.files = {"dialect/dialect_compute.glsl", "tools/tool_sums_kernel.glsl"},
                          .defines = {{"TOOLS", 1}}};
    passes_->tables().define(request);
    tool_kernel_ = Kernel(*library_, std::move(request), tool_group, limits_);
  }
  const auto sum = [&](std::int64_t source, int rows, int stride, int parts, std::int64_t to) {
    tool_kernel_.set("source_place", static_cast<int>(source));
    tool_kernel_.set("source_count", rows);
    tool_kernel_.set("source_stride", stride);
    tool_kernel_.set("part_count", parts);
    tool_kernel_.set("sums_place", static_cast<int>(to));
    tool_kernel_.dispatch(parts * tools.count());
  };
  const int parts = std::clamp(particles_ / (tool_group * rows_a_lane), 1, ComputeTools::most_parts);
  const int places = passes_->tables().places();
  if (parts == 1) return sum(tools.sums_row(), particles_, places, 1, tools.total_row());
  sum(tools.sums_row(), particles_, places, parts, tools.parts_row());
  sum(tools.parts_row(), parts, parts, 1, tools.total_row());
}

BatchReport ComputeReport::take() {
  BatchReport report = copy_.take();
  for (std::size_t tool = 0; tool < tool_sums_.size(); ++tool) {
    const Float4* const rows = &copy_.more()[4 * tool];
    tool_sums_[tool].force = rows[0];
    tool_sums_[tool].torque = rows[1];
    tool_sums_[tool].last_force = rows[2];
    tool_sums_[tool].last_torque = rows[3];
  }
  const std::span<const Float4> more(copy_.more());
  report.see_volumes(more.subspan(4 * tool_sums_.size(), volumes_));
  if (needles_) {
    const ComputeNeedles::Told told = needles_->take(more.subspan(4 * tool_sums_.size() + volumes_), tool_sums_);
    report.full_step = told.full_step;
    report.full_needle = told.tool;
  }
  return report;
}

void ComputeReport::request(const ComputeState& state, int pair, const ComputeLoads& loads) {
  const ComputeTools* const tools = loads.tools();
  tool_sums_.resize(tools ? static_cast<std::size_t>(tools->count()) : 0);
  const ComputeVolumes* const volumes = loads.volumes();
  volumes_ = volumes ? static_cast<std::size_t>(volumes->count()) : 0;
  needles_ = loads.needles();
  const auto needle_rows = static_cast<std::size_t>(needles_ ? needles_->told_rows() : 0);
  copy_.carry(4 * tool_sums_.size() + volumes_ + needle_rows);
  if (tools) sum_tools(*tools);
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
    glBindBuffer(GL_COPY_READ_BUFFER, loads.rows().id());
    const auto tool_bytes = static_cast<GLsizeiptr>(64 * tool_sums_.size());
    if (tools) {
      glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_PIXEL_PACK_BUFFER, static_cast<GLintptr>(16 * tools->total_row()), 32,
                          tool_bytes);
    }
    if (volumes) {
      glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_PIXEL_PACK_BUFFER, static_cast<GLintptr>(16 * volumes->roots_row()),
                          32 + tool_bytes, static_cast<GLsizeiptr>(16 * volumes_));
    }
    if (needles_) needles_->copy_told(32 + tool_bytes + static_cast<GLintptr>(16 * volumes_));
    glBindBuffer(GL_COPY_READ_BUFFER, 0);
  });
}

}  // namespace phymul::gl

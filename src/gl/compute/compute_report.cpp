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
  kernel_ = passes.compiled({.files = {"dialect/dialect_compute.glsl", "step/tables.glsl", "report/report_events.glsl",
                                       "report/report_kernel.glsl"},
                             .defines = {}},
                            group, state);
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

BatchReport ComputeReport::read(const ComputeState& state, int pair, const ComputeLoads& loads) {
  const ComputeTools* const tools = loads.tools();
  const ComputeVolumes* const volumes = loads.volumes();
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
  const std::int64_t tool_rows = tools ? 4 * tools->count() : 0, volume_rows = volumes ? volumes->count() : 0;
  BatchReport report = copy_.read(tool_rows + volume_rows, [&] {
    std::int64_t to = 0;
    const auto copy = [&to](const StorageBuffer& from, std::int64_t row, std::int64_t rows) {
      from.copy(row, rows, GL_PIXEL_PACK_BUFFER, 16 * to);
      to += rows;
    };
    copy(state.rows(), last, 2);
    if (tools) copy(loads.rows(), tools->total_row(), tool_rows);
    if (volumes) copy(loads.rows(), volumes->roots_row(), volume_rows);
  });
  const std::span<const Float4> more(copy_.more());
  tool_sums_.resize(static_cast<std::size_t>(tool_rows / 4));
  for (std::size_t tool = 0; tool < tool_sums_.size(); ++tool) {
    const Float4* const rows = &more[4 * tool];
    tool_sums_[tool] = {rows[0], rows[1], rows[2], rows[3]};
  }
  report.see_volumes(more.subspan(static_cast<std::size_t>(tool_rows), static_cast<std::size_t>(volume_rows)));
  return report;
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#include "compute_device.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "device/slice_tables.h"

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

std::unique_ptr<Device> make_compute_device(FloatTables tables, const TopologyTextures& topology, const Scene& scene,
                                            const FloatTools& tools, bool on_host, const ShaderLibrary& library,
                                            std::vector<Index>& domains) {
  SliceTables slices = pack_slices(std::move(tables), topology);
  auto device = std::make_unique<ComputeDevice>(slices, scene, tools, on_host, library);
  domains = std::move(slices.rows.domains.source);
  return device;
}

ComputeDevice::ComputeDevice(const SliceTables& slices, const Scene& scene, const FloatTools& tools, bool on_host,
                             const ShaderLibrary& library, const ComputeLimits& limits)
    : library_(library),
      limits_(limits),
      tables_(slices, limits_),
      passes_(tables_, library_, limits_),
      state_(tables_, limits_),
      report_(library_, passes_, state_, limits_) {
  set_scene(scene, tools, on_host);
  begin_batch({.dt = 1.0}, {0.0, 1.0}, tools);
  try_step(1);
}

void ComputeDevice::bind() const {
  tables_.bind();
  state_.bind();
  loads_->bind();
}

void ComputeDevice::set_scene(const Scene& scene, const FloatTools& tools, bool on_host) {
  auto loads = std::make_unique<ComputeLoads>(scene, most_steps + 1, tools, on_host, tables_, limits_);
  passes_.set_loads(*loads, state_);
  loads_ = std::move(loads);
}

void ComputeDevice::begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                                const FloatTools& tools) {
  loads_->evaluate(instants);
  loads_->set_frames(tools);
  passes_.set_constants(constants);
  if (loads_->open()) loads_->open()->set_pushes({}, loads_->rows());
  state_.set_checkpoint();
}

void ComputeDevice::run(int count) {
  bind();
  state_.go_back();
  for (int step = 1; step <= count; ++step) {
    passes_.step(state_, step, step == count);
    state_.advance();
  }
}

BatchReport ComputeDevice::try_step(int number) {
  bind();
  passes_.step(state_, number, true);
  return report_.read(state_, state_.free_pair(), *loads_);
}

BatchReport ComputeDevice::report() {
  bind();
  return report_.read(state_, state_.current(), *loads_);
}

void ComputeDevice::open_step() {
  bind();
  passes_.open(state_, 1, true);
}

void ComputeDevice::gather(std::span<const Index> rows) {
  bind();
  loads_->open()->set_gathered(rows, loads_->rows());
  passes_.gather(state_);
}

void ComputeDevice::close_step(std::span<const Push> pushes) {
  bind();
  loads_->open()->set_pushes(pushes, loads_->rows());
  passes_.close(state_, 1, true);
  state_.advance();
}

/// Rows in the model's order, sent from a buffer to a texture without the host.
const Texture& ComputeDevice::displacements() {
  if (!show_) {
    show_ = passes_.compiled(
        {.files = {"dialect/dialect_compute.glsl", "step/tables.glsl", "display/show_kernel.glsl"}, .defines = {}},
        lanes, state_);
    shown_ = Texture::target(tables_.kind().particles, "displacement");
  }
  bind();
  show_.set("pair", state_.current());
  show_.set("shown_place", state_.spare_row());
  show_.dispatch(show_.groups_for(tables_.kind().particles));
  glMemoryBarrier(GL_PIXEL_BUFFER_BARRIER_BIT);
  shown_.upload_from(state_.rows().id(), state_.spare_row());
  return shown_;
}

}  // namespace phymul::gl

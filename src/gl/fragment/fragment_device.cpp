// SPDX-License-Identifier: MIT
#include "fragment_device.h"

#include <utility>

namespace phymul::gl {
namespace {

constexpr int rows_to_one = 16;
const std::vector<std::string> report_files{"dialect/dialect_fragment.glsl", "step/tables.glsl",
                                            "report/report_events.glsl", "report/report_pass.glsl"};

}  // namespace

FragmentReport::FragmentReport(const ShaderLibrary& library, Index particles)
    : library_(&library),
      first_(library, {.files = report_files, .defines = {{"ROWS_TO_ONE", rows_to_one}, {"FIRST", 1}}}),
      reduction_(particles, rows_to_one, {{"events", TexelFormat::rgba32i}, {"maxima"}}, "what steps tell") {
  if (particles > rows_to_one)
    further_ = Pass(library, {.files = report_files, .defines = {{"ROWS_TO_ONE", rows_to_one}}});
}

BatchReport FragmentReport::read(const Texture& displacement, const Texture& velocity, const Texture& measured,
                                 FragmentScene& scene) {
  auto* const tools = scene.tools_act() ? &*scene.tools : nullptr;
  const auto& volumes = scene.volumes;
  first_.input("displacement", displacement);
  first_.input("velocity", velocity);
  first_.input("measured", measured);
  reduction_.draw(first_, further_);
  if (tools) {
    if (!tools_added_)
      tools_added_.emplace(*library_,
                           ShaderRequest{.files = {"dialect/dialect_fragment.glsl", "tools/tool_sums_pass.glsl"},
                                         .defines = {{"ROWS_TO_ONE", FragmentTools::rows_to_one}}});
    tools->sum(*tools_added_);
  }
  // Behind the report: four rows of texels of tools, one of volumes.
  const std::size_t tool_rows = tools ? tools->texels() : 0, volume_rows = volumes ? volumes->texels() : 0;
  const std::size_t more_rows = 4 * tool_rows + volume_rows;
  BatchReport report = copy_.read(static_cast<std::int64_t>(more_rows), [&] {
    reduction_.target().read(0, GL_RGBA_INTEGER, GL_INT, nullptr);
    reduction_.target().read(1, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(sizeof(Int4)));  // an offset in the buffer
    const std::size_t behind = sizeof(Int4) + sizeof(Float4);
    if (tools) tools->copy(behind);
    if (volumes) volumes->copy(behind + 4 * tool_rows * sizeof(Float4));
  });
  const std::span<const Float4> more(copy_.more());
  tool_sums_.resize(tools ? static_cast<std::size_t>(tools->count()) : 0);
  for (std::size_t tool = 0; tool < tool_sums_.size(); ++tool) {
    const Float4* const at = more.data() + tool;
    tool_sums_[tool] = {at[0], at[tool_rows], at[2 * tool_rows], at[3 * tool_rows]};
  }
  if (volumes) report.see_volumes(more.subspan(4 * tool_rows, static_cast<std::size_t>(volumes->count())));
  return report;
}

FragmentDevice::FragmentDevice(const FloatTables& tables, const Scene& scene, const FloatTools& tools, bool on_host,
                               const ShaderLibrary& library)
    : library_(library),
      tables_(tables),
      state_(tables.particle_count),
      strains_(tables_.kind().dissipates() ? std::make_unique<FragmentStrains>(tables_.kind()) : nullptr),
      passes_(tables_, strains_.get(), library_),
      report_(library_, tables.particle_count) {
  set_scene(scene, tools, on_host);
  const VecList origin(static_cast<std::size_t>(tables.particle_count), Vec3::Zero());
  state_.write(origin, {.time = 0.0, .position = origin, .velocity = origin});
  begin_batch({.dt = 1.0}, {0.0, 1.0}, tools);
  try_step(1);
}

void FragmentDevice::set_scene(const Scene& scene, const FloatTools& tools, bool on_host) {
  auto made = std::make_unique<FragmentScene>(scene, most_steps + 1, tables_, tools, on_host, state_.measured());
  passes_.set_scene(*made);
  scene_ = std::move(made);
}

void FragmentDevice::set_held(const FloatTools& tools) {
  if (scene_->tools) scene_->tools->set_held(tools);
}

void FragmentDevice::write_strains(std::span<const Float4> rows) {
  strains_->kept.write(rows, state_.current());
  state_.set_strains_fresh(false);
}

std::vector<Float4> FragmentDevice::read_strains() {
  return state_.no_strains() ? std::vector<Float4>() : strains_->kept.read(state_.current());
}

void FragmentDevice::begin_batch(const StepConstants& constants, const std::vector<double>& instants,
                                 const FloatTools& tools) {
  scene_->loads.evaluate(instants);
  if (scene_->tools) scene_->tools->set_frames(tools);
  if (scene_->joints) scene_->joints->follow();
  passes_.set_constants(constants);
  if (scene_->open) scene_->open->set_pushes({});
  state_.set_checkpoint();
}

void FragmentDevice::run(int count) {
  vertices_.bind();
  state_.go_back();
  for (int step = 1; step <= count; ++step) {
    passes_.step(state_, step, step == count);
    state_.advance();
  }
}

BatchReport FragmentDevice::try_step(int number) {
  vertices_.bind();
  passes_.step(state_, number, true);
  return report(state_.next_displacement(), state_.next_velocity());
}

BatchReport FragmentDevice::report(const Texture& displacement, const Texture& velocity) {
  vertices_.bind();
  return report_.read(displacement, velocity, state_.measured(), *scene_);
}

void FragmentDevice::open_step() {
  vertices_.bind();
  passes_.open(state_, 1);
}

void FragmentDevice::gather(std::span<const Index> rows) {
  vertices_.bind();
  scene_->open->set_gathered(rows);
  passes_.gather(state_);
}

void FragmentDevice::close_step(std::span<const Push> pushes) {
  vertices_.bind();
  scene_->open->set_pushes(pushes);
  passes_.close(state_, 1, true);
  state_.advance();
}

}  // namespace phymul::gl

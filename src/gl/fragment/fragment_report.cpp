// SPDX-License-Identifier: MIT
#include "fragment_report.h"

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

}  // namespace phymul::gl

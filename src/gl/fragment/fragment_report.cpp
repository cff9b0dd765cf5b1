// SPDX-License-Identifier: MIT
#include "fragment_report.h"

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
      particles_(particles) {
  int rows = particles;
  do {
    rows = (rows + rows_to_one - 1) / rows_to_one;
    Level level;
    level.rows = rows;
    level.events = Texture::target(rows, TexelFormat::rgba32i, "events of steps");
    level.maxima = Texture::target(rows, TexelFormat::rgba32f, "largest speeds and forces");
    level.target = Framebuffer({{&level.events}, {&level.maxima}});
    levels_.push_back(std::move(level));
  } while (rows > 1);
  if (levels_.size() > 1) further_ = Pass(library, {.files = report_files, .defines = {{"ROWS_TO_ONE", rows_to_one}}});
}

void FragmentReport::request(const Texture& displacement, const Texture& velocity, const Texture& measured,
                             FragmentTools* tools, const FragmentVolumes* volumes, FragmentContacts* contacts) {
  first_.input("displacement", displacement);
  first_.input("velocity", velocity);
  first_.input("measured", measured);
  int source_rows = particles_;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    Pass& pass = k == 0 ? first_ : further_;
    if (k > 0) {
      pass.input("events", levels_[k - 1].events);
      pass.input("maxima", levels_[k - 1].maxima);
    }
    pass.set("source_count", source_rows);
    pass.set_rows(levels_[k].events, levels_[k].rows);
    pass.draw(levels_[k].target);
    source_rows = levels_[k].rows;
  }
  tool_sums_.resize(tools ? static_cast<std::size_t>(tools->count()) : 0);
  tool_rows_ = tools ? tools->texels() : 0;
  volumes_ = volumes ? static_cast<std::size_t>(volumes->count()) : 0;
  volume_rows_ = volumes ? volumes->texels() : 0;
  contacts_ = contacts;
  copy_.carry(4 * tool_rows_ + volume_rows_ + (contacts ? 1 : 0));
  if (tools) {
    if (!tools_added_)
      tools_added_.emplace(*library_,
                           ShaderRequest{.files = {"dialect/dialect_fragment.glsl", "tools/tool_sums_pass.glsl"},
                                         .defines = {{"ROWS_TO_ONE", FragmentTools::rows_to_one}}});
    tools->sum(*tools_added_);
  }
  copy_.request([&] {
    levels_.back().target.read(0, GL_RGBA_INTEGER, GL_INT, nullptr);
    levels_.back().target.read(1, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(sizeof(Int4)));  // an offset in the buffer
    const std::size_t behind = sizeof(Int4) + sizeof(Float4);
    if (tools) tools->copy(behind);
    if (volumes) volumes->copy(behind + 4 * tool_rows_ * sizeof(Float4));
    if (contacts) contacts->copy_told(behind + (copy_.more().size() - 1) * sizeof(Float4));
  });
}

BatchReport FragmentReport::take() {
  BatchReport report = copy_.take();
  for (std::size_t tool = 0; tool_rows_ > 0 && tool < tool_sums_.size(); ++tool) {
    const Float4* const at = copy_.more().data() + tool;
    tool_sums_[tool] = {at[0], at[tool_rows_], at[2 * tool_rows_], at[3 * tool_rows_]};
  }
  const std::span<const Float4> more(copy_.more());
  report.see_volumes(more.subspan(4 * tool_rows_, volumes_));
  if (contacts_ && contacts_->see(more.back(), report.runaway_step)) report.unfinished = true;
  return report;
}

}  // namespace phymul::gl

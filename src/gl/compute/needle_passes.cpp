// SPDX-License-Identifier: MIT
#include "needle_passes.h"

#include <limits>
#include <utility>

namespace phymul::gl {

/// A lane for each node of a hole, and for the particles of one. A processor that plays GPU takes up its lanes one
/// after another at every wait, so fewer of them wait less; that is where turns are limited.
int NeedlePasses::group(const ComputeLimits& limits) {
  const bool limited = limits.loop_turns < std::numeric_limits<std::int64_t>::max();
  return limited ? FloatNeedles::most_nodes : 2 * FloatNeedles::most_nodes;
}

NeedlePasses::NeedlePasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits,
                           bool bending)
    : tables_(&tables), limits_(limits), bending_(bending) {
  follow_ = compiled(library,
                     {"needle/needle_surface.glsl", "needle/needle_search.glsl", "needle/needle_weights.glsl",
                      "needle/needle_node.glsl", "needle/needle_follow_kernel.glsl"},
                     group(limits));
  ShaderFiles forces{"needle/needle_motion.glsl", "needle/needle_nodes.glsl", "needle/needle_settle.glsl",
                     "needle/needle_force_kernel.glsl"};
  if (bending)
    forces.insert(forces.begin() + 2,
                  {"dialect/two_floats.glsl", "needle/needle_held.glsl", "needle/needle_bend.glsl"});
  force_ = compiled(library, std::move(forces), group(limits));
}

Kernel NeedlePasses::compiled(const ShaderLibrary& library, ShaderFiles files, int group) const {
  ShaderRequest request{
      .files = joined({{"dialect/dialect_compute.glsl", "dialect/kernel_language.glsl", "tools/pushed_tables.glsl",
                        "tools/tool_tables.glsl", "dialect/lone_group.glsl", "needle/needle_tables.glsl",
                        "needle/needle_shaft.glsl"},
                       std::move(files)}),
      .defines = {{"PUSHES", 1},
                  {"OWN_BLOCK", 1},
                  {"ONE_WORKGROUP", 1},
                  {"MOST_NODES", FloatNeedles::most_nodes},
                  {"TEAM", team}}};
  if (bending_) request.defines.emplace_back("BENDING", 1);
  ComputeNeedles::define(request);
  define_tool_rows(request);
  tables_->define(request);
  return Kernel(library, std::move(request), group, limits_);
}

void NeedlePasses::set_needles(const ComputeLoads& loads) {
  needles_ = loads.needles();
  for (Kernel* kernel : {&follow_, &force_}) {
    needles_->place(*kernel);
    loads.place(*kernel);
  }
  follow_.set("most_units", needles_->follow_units());
  force_.set("kept_bits", 0);
}

void NeedlePasses::set_step(double dt) {
  force_.set("dt", static_cast<float>(dt));
  force_.set("inverse_dt", static_cast<float>(1.0 / dt));
}

void NeedlePasses::act(int number, int pair) {
  needles_->bind();
  const int dispatches = needles_->follow_dispatches();
  for (Kernel* kernel : {&follow_, &force_}) {
    kernel->set("pair", pair);
    kernel->set("number", number);
  }
  for (int needle = 0; needle < needles_->count(); ++needle) {
    follow_.set("needle", needle);
    for (int k = 0; k < dispatches; ++k) {
      follow_.set("goes_on", k > 0 ? 1 : 0);
      follow_.set("ends", k == dispatches - 1 ? 1 : 0);
      follow_.dispatch(1);
    }
    force_.set("needle", needle);
    force_.dispatch(1);
  }
  tables_->bind();
}

}  // namespace phymul::gl

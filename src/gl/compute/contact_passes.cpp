// SPDX-License-Identifier: MIT
#include "compute_passes.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace phymul::gl {
namespace {

/// Of a group that works alone. A processor that plays GPU takes up its lanes one after another at every wait, so fewer
/// of them wait less; that is where turns are limited.
int lone_group(const ComputeLimits& limits) {
  const bool limited = limits.loop_turns < std::numeric_limits<std::int64_t>::max();
  return static_cast<int>(std::bit_floor(static_cast<unsigned>(std::min(limits.invocations, limited ? 64 : 256))));
}

}  // namespace

ContactPasses::ContactPasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits)
    : tables_(&tables),
      group_(lone_group(limits)),
      most_turns_(static_cast<int>(std::min<std::int64_t>(limits.loop_turns / 2, std::numeric_limits<int>::max()))) {
  const auto compiled = [&](ShaderFiles files, int group, bool is_alone = false) {
    ShaderRequest request{.files = {"dialect/dialect_compute.glsl", "dialect/kernel_language.glsl",
                                    "tools/pushed_tables.glsl", "contact/contact_tables.glsl"},
                          .defines = {{"PUSHES", 1}, {"OWN_BLOCK", 1}}};
    request.files.insert(request.files.end(), files.begin(), files.end());
    if (is_alone) request.defines.emplace_back("ONE_WORKGROUP", 1);
    tables.define(request);
    return Kernel(library, std::move(request), group, limits);
  };
  const auto alone = [&](ShaderFiles files) {
    return compiled(joined({{"dialect/lone_group.glsl", "contact/contact_group.glsl"}, std::move(files)}), group_,
                    true);
  };
  grid_ = alone({"contact/contact_range.glsl", "contact/contact_grid_kernel.glsl"});
  order_ = compiled({"contact/contact_order_kernel.glsl"}, lanes);
  search_ = compiled({"tools/closest_point.glsl", "contact/contact_range.glsl", "contact/contact_nearest.glsl",
                      "contact/contact_search_kernel.glsl"},
                     lanes);
  queue_ = alone({"contact/contact_queue_kernel.glsl"});
  press_ = alone({"contact/contact_law.glsl", "contact/contact_press_kernel.glsl"});
  part_ = compiled({"contact/contact_law.glsl", "contact/contact_part_kernel.glsl"}, lanes);
}

void ContactPasses::set_contacts(const ComputeLoads& loads) {
  for (Kernel* kernel : {&grid_, &order_, &search_, &queue_, &press_, &part_}) loads.place(*kernel);
  press_.set("most_turns", most_turns_);
  loads_ = &loads;
}

void ContactPasses::set_step(double dt) {
  grid_.set("dt", static_cast<float>(dt));
  press_.set("inverse_dt", static_cast<float>(1.0 / dt));
  part_.set("inverse_dt", static_cast<float>(1.0 / dt));
}

void ContactPasses::order(const ComputeContacts::Lists& lists, std::int64_t most) {
  const auto set = [this](const char* name, std::int64_t word) { order_.set(name, static_cast<int>(word)); };
  set("first_list", lists.first);
  set("owner_count", lists.owners);
  set("raw_list", lists.raw);
  set("owner_list", lists.owner);
  set("to_list", lists.to);
  set("rank_list", lists.rank);
  order_.dispatch(order_.groups_for(most));
}

/// As many as finish the sweeps however contacts depend on each other: each phase of a dispatch presses at least one.
/// One where turns are not limited; those after the last one needed find nothing to do.
int ContactPasses::press_dispatches() const {
  const std::int64_t contacts = loads_->contacts()->meetings();
  const std::int64_t phases = most_turns_ / (3 + 3 * ((contacts + group_ - 1) / group_));
  const std::int64_t needed = contacts * loads_->contacts()->rounds();
  return static_cast<int>((needed + phases - 1) / phases);
}

void ContactPasses::act(int pair) {
  const ComputeContacts& contacts = *loads_->contacts();
  loads_->rows().bind(constant_words_binding);  // in place of constants, which these passes do not read
  grid_.set("pair", pair);
  grid_.dispatch(1);
  order(contacts.bucket_lists(), contacts.triangles());
  search_.dispatch(search_.groups_for(contacts.particles()));
  queue_.dispatch(1);
  order(contacts.queue_lists(), 4 * contacts.meetings());
  for (int k = press_dispatches(); k > 0; --k) press_.dispatch(1);
  part_.dispatch(part_.groups_for(contacts.particles()));
  tables_->bind();
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
#include "contact_passes.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int lanes = 64;  // of a group where groups are many

/// Of a group that works alone. A processor that plays GPU takes up its lanes one after another at every wait, so fewer
/// of them wait less; that is where turns are limited.
int lone_group(const ComputeLimits& limits) {
  const bool limited = limits.loop_turns < std::numeric_limits<std::int64_t>::max();
  return static_cast<int>(std::bit_floor(static_cast<unsigned>(std::min(limits.invocations, limited ? 64 : 256))));
}

}  // namespace

ContactPasses::ContactPasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits)
    : tables_(&tables),
      limits_(limits),
      group_(lone_group(limits)),
      most_turns_(static_cast<int>(std::min<std::int64_t>(limits.loop_turns / 2, std::numeric_limits<int>::max()))) {
  const ShaderFiles common{"dialect/dialect_compute.glsl", "dialect/kernel_language.glsl", "tools/pushed_tables.glsl",
                           "contact/contact_tables.glsl"};
  const auto request = [&](ShaderFiles files, bool alone) {
    ShaderRequest wanted{.files = joined({common, std::move(files)}), .defines = {{"PUSHES", 1}, {"OWN_BLOCK", 1}}};
    if (alone) wanted.defines.emplace_back("ONE_WORKGROUP", 1);
    return wanted;
  };
  grid_ = compiled(library,
                   request({"dialect/lone_group.glsl", "contact/contact_group.glsl", "contact/contact_range.glsl",
                            "contact/contact_grid_kernel.glsl"},
                           true),
                   group_);
  order_ = compiled(library, request({"contact/contact_order_kernel.glsl"}, false), lanes);
  search_ = compiled(library,
                     request({"tools/closest_point.glsl", "contact/contact_range.glsl", "contact/contact_nearest.glsl",
                              "contact/contact_search_kernel.glsl"},
                             false),
                     lanes);
  queue_ = compiled(
      library,
      request({"dialect/lone_group.glsl", "contact/contact_group.glsl", "contact/contact_queue_kernel.glsl"}, true),
      group_);
  press_ = compiled(library,
                    request({"dialect/lone_group.glsl", "contact/contact_group.glsl", "contact/contact_law.glsl",
                             "contact/contact_press_kernel.glsl"},
                            true),
                    group_);
  part_ = compiled(library, request({"contact/contact_law.glsl", "contact/contact_part_kernel.glsl"}, false), lanes);
}

Kernel ContactPasses::compiled(const ShaderLibrary& library, ShaderRequest request, int group) const {
  tables_->define(request);
  return Kernel(library, std::move(request), group, limits_);
}

void ContactPasses::set_contacts(const ComputeContacts& contacts) {
  for (Kernel* kernel : {&grid_, &order_, &search_, &queue_, &press_, &part_}) contacts.place(*kernel);
  press_.set("most_turns", most_turns_);
  contacts_ = &contacts;
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
  const std::int64_t contacts = contacts_->meetings();
  const std::int64_t phases = most_turns_ / (3 + 3 * ((contacts + group_ - 1) / group_));
  const std::int64_t needed = contacts * contacts_->options().rounds;
  return static_cast<int>((needed + phases - 1) / phases);
}

void ContactPasses::act(const StorageBuffer& rows, int pair) {
  rows.bind(constant_words_binding);  // in place of constants, which these passes do not read
  grid_.set("pair", pair);
  grid_.dispatch(1);
  order(contacts_->bucket_lists(), contacts_->triangles());
  search_.dispatch(search_.groups_for(contacts_->particles()));
  queue_.dispatch(1);
  order(contacts_->queue_lists(), 4 * contacts_->meetings());
  for (int k = press_dispatches(); k > 0; --k) press_.dispatch(1);
  part_.dispatch(part_.groups_for(contacts_->particles()));
  tables_->bind();
}

}  // namespace phymul::gl

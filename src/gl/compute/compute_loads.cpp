// SPDX-License-Identifier: MIT
#include "compute_loads.h"

#include <utility>

namespace phymul::gl {

ComputeLoads::ComputeLoads(const Scene& scene, int instants, const FloatTools& tools, bool on_host,
                           const ComputeTables& tables, const ComputeLimits& limits)
    : table_(scene, instants, tables.materials()), gravity_row_(rows_.take("gravity_place", instants)) {
  if (kind().any()) {
    rows_.add("load_index_place", tables.by_place(table_.index()));
    rows_.add("load_parts_place", table_.parts());
    values_row_ = rows_.take("load_values_place", static_cast<std::int64_t>((table_.values().size() + 3) / 4));
    rows_.note("load_count", table_.mode_count());
  }
  if (kind().scaled) {
    factors_row_ = rows_.take("stiffness_factor_place", static_cast<std::int64_t>((table_.factors().size() + 3) / 4));
  }
  FloatJoints joints(scene, tools.middle());
  const FloatVolumes volumes = on_host ? FloatVolumes() : pack_volumes(scene);
  std::optional<FloatContacts> touching;
  if (scene.contacts() && !on_host) touching.emplace(scene);
  const bool touches = touching && !touching->empty();
  if (on_host ? !joints.empty() && joints.any_tool() : !tools.empty()) tools_.emplace(tools, !on_host, tables, rows_);
  if (!volumes.empty()) volumes_.emplace(volumes, tables, rows_);
  if (!joints.empty()) joints_.emplace(std::move(joints), tables, rows_);
  if (touches || on_host) {  // pushed_tables.glsl
    for (const char* name : {"pushed_force_place", "free_velocity_place", "pushed_shift_place"}) {
      rows_.take(name, tables.places());
    }
    rows_.note("place_count", tables.places());
  }
  if (touches) contacts_.emplace(*touching, tables, limits, rows_);
  if (on_host) open_.emplace(tables, rows_);
  buffer_ = StorageBuffer(rows_.end(), "the scene's loads, tools, kept volumes, joints and contacts", limits);
  rows_.send(buffer_);
}

void ComputeLoads::evaluate(const std::vector<double>& instants) {
  table_.evaluate(instants);
  if (table_.scale()) buffer_.write_rows(factors_row_, table_.factors());
  buffer_.write_rows(gravity_row_, std::span(table_.gravity()).first(instants.size()));
  if (joints_) joints_->follow(buffer_);
  if (!kind().any()) return;
  const std::size_t values = instants.size() * static_cast<std::size_t>(table_.mode_count());
  buffer_.write_rows(values_row_, std::span(table_.values()).first(values));
}

void ComputeLoads::set_frames(const FloatTools& tools) {
  if (tools_) tools_->write_frames(tools, buffer_);
}

void ComputeLoads::write_joints(std::span<const Float4> rows, int pair) {
  buffer_.write_rows(joints_->state_row(pair), rows);
}

std::vector<Float4> ComputeLoads::read_joints(int pair) const {
  std::vector<Float4> rows(static_cast<std::size_t>(joints_->state_rows()));
  buffer_.read(joints_->state_row(pair), joints_->state_rows(), rows.data());
  return rows;
}

void ComputeLoads::set_held(const FloatTools& tools) {
  if (tools_) tools_->write_held(tools, buffer_);
}

}  // namespace phymul::gl

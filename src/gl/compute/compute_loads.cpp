// SPDX-License-Identifier: MIT
#include "compute_loads.h"

namespace phymul::gl {

ComputeLoads::ComputeLoads(const Scene& scene, int instants, const ComputeTables& tables, const ComputeLimits& limits,
                           const FloatTools* tools, const FloatVolumes* volumes)
    : table_(scene, instants), index_row_(instants), parts_row_(index_row_), values_row_(index_row_) {
  std::vector<Int4> index;
  std::vector<Float4> parts;
  if (kind().any()) {
    const std::vector<Int4> by_particle = table_.index();
    index.assign(static_cast<std::size_t>(tables.places()), Int4{});
    for (std::size_t i = 0; i < by_particle.size(); ++i) {
      index[static_cast<std::size_t>(tables.place_of()[i])] = by_particle[i];
    }
    parts = table_.parts();
    parts_row_ = index_row_ + static_cast<std::int64_t>(index.size());
    values_row_ = parts_row_ + static_cast<std::int64_t>(parts.size());
  }
  const auto value_rows = static_cast<std::int64_t>((table_.values().size() + 3) / 4);
  std::int64_t rows = values_row_ + value_rows;
  if (tools && !tools->empty()) rows = tools_.emplace(*tools, rows, tables).end();
  if (volumes && !volumes->empty()) rows = volumes_.emplace(*volumes, rows, tables).end();
  std::optional<FloatContacts> touching;
  if (tools && scene.contacts()) touching.emplace(scene);
  const bool touches = touching && !touching->empty(), pierces = tools && tools->needle_count() > 0;
  if (touches || pierces) rows = pushed_.emplace(rows, tables.places()).end();
  if (touches) rows = contacts_.emplace(*touching, *pushed_, rows, tables, limits).end();
  buffer_ = StorageBuffer(rows, "the scene's loads, tools, kept volumes and contacts", limits);
  buffer_.write(16 * index_row_, index.data(), static_cast<std::int64_t>(16 * index.size()));
  buffer_.write(16 * parts_row_, parts.data(), static_cast<std::int64_t>(16 * parts.size()));
  if (tools_) tools_->write(*tools, buffer_);
  if (volumes_) volumes_->write(*volumes, buffer_);
  if (contacts_) contacts_->write(*touching, buffer_);
  if (pierces) needles_.emplace(FloatNeedles(scene), *tools, tables, limits);
}

void ComputeLoads::evaluate(const std::vector<double>& instants) {
  table_.evaluate(instants);
  buffer_.write(0, table_.gravity().data(), static_cast<std::int64_t>(16 * instants.size()));
  if (!kind().any()) return;
  const std::size_t values = instants.size() * static_cast<std::size_t>(table_.mode_count());
  buffer_.write(16 * values_row_, table_.values().data(), static_cast<std::int64_t>(4 * values));
}

void ComputeLoads::set_frames(const FloatTools& tools) {
  if (tools_) tools_->write_frames(tools, buffer_);
}

void ComputeLoads::set_held(const FloatTools& tools) {
  if (tools_) tools_->write_held(tools, buffer_);
  if (needles_) needles_->uncouple();
}

void ComputeLoads::place(Kernel& kernel) const {
  kernel.set("gravity_place", 0);
  kernel.set("load_index_place", static_cast<int>(index_row_));
  kernel.set("load_parts_place", static_cast<int>(parts_row_));
  kernel.set("load_values_place", static_cast<int>(values_row_));
  kernel.set("load_count", table_.mode_count());
  if (tools_) tools_->place(kernel);
  if (volumes_) volumes_->place(kernel);
  if (pushed_) pushed_->place(kernel);
  if (contacts_) contacts_->place(kernel);
}

}  // namespace phymul::gl

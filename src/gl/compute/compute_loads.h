// SPDX-License-Identifier: MIT
//
// A scene's loads in a storage buffer: gravity per instant, index, parts and values, one after another, its tools, and
// the volumes it keeps, and what of it touches. Its needles in another.
#pragma once

#include <optional>

#include "compute_contacts.h"
#include "compute_needles.h"
#include "compute_tools.h"
#include "compute_volumes.h"
#include "gl/solver/load_table.h"

namespace phymul::gl {

class ComputeLoads {
 public:
  /// Room for the values of as many instants; `tools` and `volumes` may be none. Null: no steps are to be done with
  /// these loads, so that neither tools nor contacts are among them.
  ComputeLoads(const Scene& scene, int instants, const ComputeTables& tables, const ComputeLimits& limits,
               const FloatTools* tools = nullptr, const FloatVolumes* volumes = nullptr);

  const LoadKind& kind() const { return table_.kind(); }
  const ComputeTools* tools() const { return tools_ ? &*tools_ : nullptr; }              ///< null where there are none
  const ComputeVolumes* volumes() const { return volumes_ ? &*volumes_ : nullptr; }      ///< likewise
  const ComputeContacts* contacts() const { return contacts_ ? &*contacts_ : nullptr; }  ///< likewise
  ComputeNeedles* needles() { return needles_ ? &*needles_ : nullptr; }                  ///< likewise
  const ComputeNeedles* needles() const { return needles_ ? &*needles_ : nullptr; }
  const PushedRows* pushed() const { return pushed_ ? &*pushed_ : nullptr; }  ///< where contacts or needles push

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  void set_frames(const FloatTools& tools);
  void set_held(const FloatTools& tools);
  void bind() const { buffer_.bind(loads_binding); }
  void place(Kernel& kernel) const;
  const StorageBuffer& rows() const { return buffer_; }

 private:
  LoadTable table_;
  std::optional<ComputeTools> tools_;
  std::optional<ComputeVolumes> volumes_;
  std::optional<PushedRows> pushed_;
  std::optional<ComputeContacts> contacts_;
  std::optional<ComputeNeedles> needles_;
  std::int64_t index_row_, parts_row_, values_row_;
  StorageBuffer buffer_;
};

}  // namespace phymul::gl

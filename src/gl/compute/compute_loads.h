// SPDX-License-Identifier: MIT
//
// What a scene does to a body, in a storage buffer: gravity per instant, loads, tools, the volumes it keeps, where a
// step is open between its forces and its motion, and what touches. Its needles in another.
#pragma once

#include <optional>

#include "compute_contacts.h"
#include "compute_joints.h"
#include "compute_needles.h"
#include "compute_surfaces.h"
#include "compute_tools.h"
#include "compute_volumes.h"
#include "gl/solver/load_table.h"

namespace phymul::gl {

class ComputeLoads {
 public:
  /// Room for the values of as many instants.
  ComputeLoads(const Scene& scene, int instants, const FloatTools& tools, const ComputeTables& tables,
               const ComputeLimits& limits);

  const LoadKind& kind() const { return table_.kind(); }
  const ComputeTools* tools() const { return tools_ ? &*tools_ : nullptr; }              ///< null where there are none
  const ComputeSurfaces* surfaces() const { return surfaces_ ? &*surfaces_ : nullptr; }  ///< likewise
  const ComputeVolumes* volumes() const { return volumes_ ? &*volumes_ : nullptr; }      ///< likewise
  const ComputeContacts* contacts() const { return contacts_ ? &*contacts_ : nullptr; }  ///< likewise
  const ComputeJoints* joints() const { return joints_ ? &*joints_ : nullptr; }          ///< likewise
  ComputeNeedles* needles() { return needles_ ? &*needles_ : nullptr; }                  ///< likewise
  const ComputeNeedles* needles() const { return needles_ ? &*needles_ : nullptr; }

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  void set_frames(const FloatTools& tools);
  void set_held(const FloatTools& tools);
  void write_joints(std::span<const Float4> rows, int pair);
  std::vector<Float4> read_joints(int pair) const;
  void bind() const { buffer_.bind(loads_binding); }
  void place(Kernel& kernel) const { rows_.place(kernel); }
  const StorageBuffer& rows() const { return buffer_; }

 private:
  LoadTable table_;
  StorageRows rows_;
  std::int64_t gravity_row_, values_row_ = 0, factors_row_ = 0;
  std::optional<ComputeTools> tools_;
  std::optional<ComputeSurfaces> surfaces_;
  std::optional<ComputeVolumes> volumes_;
  std::optional<ComputeJoints> joints_;
  std::optional<ComputeContacts> contacts_;
  std::optional<ComputeNeedles> needles_;
  StorageBuffer buffer_;
};

}  // namespace phymul::gl

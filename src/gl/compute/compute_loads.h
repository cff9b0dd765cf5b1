// SPDX-License-Identifier: MIT
//
// What a scene does to a body, in a storage buffer: gravity per instant, loads, tools, the volumes it keeps, where a
// step is open between its forces and its motion, and what touches.
#pragma once

#include <optional>

#include "compute_contacts.h"
#include "compute_joints.h"
#include "compute_open_step.h"
#include "compute_tools.h"
#include "compute_volumes.h"
#include "gl/solver/load_table.h"

namespace phymul::gl {

class ComputeLoads {
 public:
  /// Room for the values of as many instants. `on_host`: tools, contacts and kept volumes act there.
  ComputeLoads(const Scene& scene, int instants, const FloatTools& tools, bool on_host, const ComputeTables& tables,
               const ComputeLimits& limits);

  const LoadKind& kind() const { return table_.kind(); }
  // Null where there are none, or act on the host.
  const ComputeTools* tools() const { return tools_ && tools_->act() ? &*tools_ : nullptr; }
  const ComputeVolumes* volumes() const { return volumes_ ? &*volumes_ : nullptr; }
  const ComputeContacts* contacts() const { return contacts_ ? &*contacts_ : nullptr; }
  const ComputeJoints* joints() const { return joints_ ? &*joints_ : nullptr; }
  ComputeOpenStep* open() { return open_ ? &*open_ : nullptr; }  ///< null where nothing acts on the host
  const ComputeOpenStep* open() const { return open_ ? &*open_ : nullptr; }

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  void set_frames(const FloatTools& tools);
  void set_held(const FloatTools& tools);
  void write_joints(std::span<const Float4> rows, int pair);
  std::vector<Float4> read_joints(int pair) const;
  void bind() const { buffer_.bind(loads_binding); }
  void place(Kernel& kernel) const { rows_.place(kernel); }
  const StorageBuffer& rows() const { return buffer_; }
  StorageBuffer& rows() { return buffer_; }

 private:
  LoadTable table_;
  StorageRows rows_;
  std::int64_t gravity_row_, values_row_ = 0, factors_row_ = 0;
  std::optional<ComputeTools> tools_;
  std::optional<ComputeVolumes> volumes_;
  std::optional<ComputeJoints> joints_;
  std::optional<ComputeContacts> contacts_;
  std::optional<ComputeOpenStep> open_;
  StorageBuffer buffer_;
};

}  // namespace phymul::gl

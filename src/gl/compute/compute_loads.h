// SPDX-License-Identifier: MIT
//
// What a scene does to a body, in rows of one storage buffer: a class for each kind of what acts.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "compute_state.h"
#include "device/float_scene.h"
#include "device/float_tools.h"
#include "gl/solver/body_kind.h"
#include "gl/solver/device.h"

namespace phymul::gl {

/// The tools of a scene among the rows of its loads: laws, frames per instant, particles as tools see them, grids, and,
/// where they act on the device, what the particles do to each.
class ComputeTools {
 public:
  static constexpr int most_parts = 64;  ///< that a tool's sums are cut to

  /// `acts`: on the device; else joints alone look where they are.
  ComputeTools(const FloatTools& tools, bool acts, const ComputeTables& tables, StorageRows& rows);

  bool act() const { return acts_; }

  int count() const { return count_; }
  bool any_grid() const { return any_grid_; }

  void write_held(const FloatTools& tools, StorageBuffer& buffer) const;
  void write_frames(const FloatTools& tools, StorageBuffer& buffer) const;

  std::int64_t sums_row() const { return sums_row_; }    ///< [count][places][4]
  std::int64_t parts_row() const { return parts_row_; }  ///< [count][parts][4]
  std::int64_t total_row() const { return total_row_; }  ///< [count][4]

 private:
  const ComputeTables* tables_;
  int count_;
  bool acts_, any_grid_;
  std::int64_t frames_row_, held_row_, sums_row_ = 0, parts_row_ = 0, total_row_ = 0;
};

/// The springs of a scene's joints among the rows of its loads, and their states with each pair of ComputeState.
class ComputeJoints {
 public:
  /// The scene must outlive it.
  ComputeJoints(FloatJoints joints, const ComputeTables& tables, StorageRows& rows);

  int count() const { return joints_.count(); }
  bool any_tool() const { return joints_.any_tool(); }
  /// Takes over changed constants of the scene.
  void follow(StorageBuffer& buffer);
  int state_row(int pair) const { return static_cast<int>(state_row_ + pair * state_rows()); }
  std::int64_t state_rows() const { return static_cast<std::int64_t>(FloatJoints::state_rows) * joints_.count(); }

 private:
  FloatJoints joints_;
  std::int64_t laws_row_ = 0, state_row_ = 0;
};

/// The volumes that a scene keeps, among the rows of its loads.
class ComputeVolumes {
 public:
  ComputeVolumes(const FloatVolumes& volumes, const ComputeTables& tables, StorageRows& rows);

  int count() const { return count_; }
  int facet_sums() const { return facet_sums_; }         ///< of the first level
  std::int64_t roots_row() const { return roots_row_; }  ///< [count]

 private:
  int count_, facet_sums_;
  std::int64_t roots_row_;
};

/// What of a scene touches, among the rows of its loads: surfaces, and what the passes of a step write of them.
class ComputeContacts {
 public:
  /// Every list has room for all that can be, so that none runs over. Throws Error where shaders cannot count to it.
  ComputeContacts(const FloatContacts& contacts, const ComputeTables& tables, const ComputeLimits& limits,
                  StorageRows& rows);

  std::int64_t particles() const { return particles_; }
  std::int64_t triangles() const { return triangles_; }
  std::int64_t meetings() const { return particles_ * bodies_; }  ///< most contacts that a step can have
  int rounds() const { return rounds_; }

  /// A list of lists in compressed rows, to be ordered; words.
  struct Lists {
    std::int64_t first, owners, raw, owner, to, rank;
  };
  const Lists& bucket_lists() const { return buckets_; }
  const Lists& queue_lists() const { return queues_; }

 private:
  std::int64_t particles_, triangles_, bodies_;
  int rounds_;
  Lists buckets_, queues_;
};

/// A step that the host acts in, among the rows of the loads: the list of particles that the host asks for, what is
/// gathered of them, and what it adds. Room for all particles, so that no step allocates.
class ComputeOpenStep {
 public:
  ComputeOpenStep(const ComputeTables& tables, StorageRows& rows);

  int asked_count() const { return asked_count_; }
  int gathered_row() const { return static_cast<int>(gathered_row_); }  ///< [asked_count()][3]
  int push_count() const { return push_count_; }

  void set_gathered(std::span<const Index> rows, StorageBuffer& buffer);
  void read(std::span<OpenRow> rows, const StorageBuffer& buffer) const;
  void set_pushes(std::span<const Push> pushes, StorageBuffer& buffer);

 private:
  const ComputeTables* tables_;
  std::int64_t asked_row_, gathered_row_, push_row_, force_row_, shift_row_;
  int asked_count_ = 0, push_count_ = 0;
  std::vector<Int4> rows_;
  std::vector<Push> pushes_;  // by place
  std::vector<Float4> values_;
};

/// What a scene does to a body, in a storage buffer: gravity per instant, loads, tools, the volumes it keeps, where a
/// step is open between its forces and its motion, and what touches.
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

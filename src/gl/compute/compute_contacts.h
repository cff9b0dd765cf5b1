// SPDX-License-Identifier: MIT
//
// What of a scene touches, among the rows of its loads: surfaces, and what the passes of a step write of them.
#pragma once

#include "compute_tables.h"
#include "device/float_contacts.h"

namespace phymul::gl {

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

}  // namespace phymul::gl

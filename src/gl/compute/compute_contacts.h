// SPDX-License-Identifier: MIT
//
// What of a scene touches, among the rows of its loads: surfaces, and what the passes of a step write of them.
#pragma once

#include "compute_tables.h"
#include "device/float_contacts.h"
#include "gl/solver/pushed_rows.h"

namespace phymul::gl {

class ComputeContacts {
 public:
  /// Takes rows from `first` on. Every list has room for all that can be, so that none runs over.
  ComputeContacts(const FloatContacts& contacts, const PushedRows& pushed, std::int64_t first,
                  const ComputeTables& tables, const ComputeLimits& limits);

  std::int64_t end() const { return end_; }
  std::int64_t particles() const { return particles_; }
  std::int64_t triangles() const { return triangles_; }
  std::int64_t meetings() const { return particles_ * bodies_; }  ///< most contacts that a step can have
  std::int64_t buckets() const { return buckets_; }
  const ContactOptions& options() const { return options_; }

  void write(const FloatContacts& contacts, StorageBuffer& rows) const;
  void place(Kernel& kernel) const;

  /// A list of lists in compressed rows, to be ordered; words.
  struct Lists {
    std::int64_t first, owners, raw, owner, to, rank;
  };
  Lists bucket_lists() const { return {bucket_first_, buckets_, raw_, owner_, bucket_list_, bucket_of_}; }
  Lists queue_lists() const { return {queue_first_, particles_, raw_, owner_, queue_list_, ticket_}; }

 private:
  const ComputeTables* tables_;
  PushedRows pushed_;
  ContactOptions options_;
  double longest_edge_, largest_skins_;
  std::int64_t particles_, triangles_, bodies_, buckets_ = 1, end_;
  // Rows.
  std::int64_t surface_ = 0, rest_ = 0, triangle_ = 0, law_ = 0;
  std::int64_t range_ = 0, moved_ = 0, surface_velocity_ = 0, push_ = 0, ball_ = 0, meeting_ = 0;
  // Words.
  std::int64_t bucket_first_ = 0, bucket_next_ = 0, bucket_list_ = 0, bucket_of_ = 0, raw_ = 0, owner_ = 0;
  std::int64_t queue_first_ = 0, queue_next_ = 0, queue_list_ = 0, live_ = 0, live_count_ = 0, turn_ = 0, ticket_ = 0;
};

}  // namespace phymul::gl

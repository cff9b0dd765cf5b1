// SPDX-License-Identifier: MIT
#include "compute_contacts.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <string>

namespace phymul::gl {
namespace {

std::int64_t size_of(const auto& rows) {
  return static_cast<std::int64_t>(rows.size());
}

/// Renderers that break off a shader's loops: half of the turns are left to what is not counted.
void require_turns(std::int64_t particles, std::int64_t triangles, std::int64_t meetings, const ComputeLimits& limits) {
  // A lane may look at every triangle, be in every contact, and see some of either again where buckets coincide.
  const std::int64_t turns = std::max(2 * triangles, meetings);
  if (turns <= limits.loop_turns / 2) return;
  throw Error(ErrorCode::not_supported,
              "expected contacts that take at most " + std::to_string(limits.loop_turns / 2) +
                  " turns of a shader's loops, half of where this renderer breaks off, got up to " +
                  std::to_string(turns) + " for surfaces of " + std::to_string(particles) + " particles and " +
                  std::to_string(triangles) + " triangles; use the backend \"cpu\"");
}

}  // namespace

ComputeContacts::ComputeContacts(const FloatContacts& contacts, const PushedRows& pushed, std::int64_t first,
                                 const ComputeTables& tables, const ComputeLimits& limits)
    : tables_(&tables),
      pushed_(pushed),
      options_(contacts.options),
      longest_edge_(contacts.longest_edge),
      largest_skins_(contacts.largest_skins()),
      particles_(size_of(contacts.particle)),
      triangles_(size_of(contacts.triangle)),
      bodies_(contacts.bodies),
      end_(first) {
  require_turns(particles_, triangles_, meetings(), limits);
  if (meetings() * options_.rounds > std::numeric_limits<int>::max()) {
    throw Error(ErrorCode::not_supported, "expected contacts times rounds of at most 2147483647, got up to " +
                                              std::to_string(meetings()) + " contacts in " +
                                              std::to_string(options_.rounds) + " rounds; use fewer rounds");
  }
  while (buckets_ < 2 * triangles_) buckets_ *= 2;
  const auto take = [this](std::int64_t rows) {
    const std::int64_t row = end_;
    end_ += rows;
    return row;
  };
  const auto take_words = [&](std::int64_t words) { return 4 * take((words + 3) / 4); };
  surface_ = take(particles_);
  rest_ = take(2 * particles_);
  triangle_ = take(triangles_);
  law_ = take(triangles_);
  range_ = take(1);
  moved_ = take(particles_);
  surface_velocity_ = take(particles_);
  push_ = take(particles_);
  ball_ = take(triangles_);
  meeting_ = take(4 * meetings());
  bucket_first_ = take_words(buckets_ + 1);
  bucket_next_ = take_words(buckets_);
  bucket_list_ = take_words(triangles_);
  bucket_of_ = take_words(triangles_);
  raw_ = take_words(std::max(triangles_, 4 * meetings()));
  owner_ = take_words(std::max(triangles_, 4 * meetings()));
  queue_first_ = take_words(particles_ + 1);
  queue_next_ = take_words(particles_);
  queue_list_ = take_words(4 * meetings());
  live_ = take_words(meetings());
  live_count_ = take_words(2);
  turn_ = take_words(particles_);
  ticket_ = take_words(4 * meetings());
  if (4 * end_ > std::numeric_limits<int>::max()) {
    throw Error(ErrorCode::not_supported, "contacts of " + std::to_string(particles_) +
                                              " particles of the surfaces of " + std::to_string(bodies_) +
                                              " bodies take more than the 2147483647 words a shader counts to; use " +
                                              "fewer of them, or the backend \"cpu\"");
  }
}

void ComputeContacts::write(const FloatContacts& contacts, StorageBuffer& rows) const {
  std::vector<Int4> particles = contacts.particle;
  for (Int4& particle : particles) particle[0] = tables_->place_of()[static_cast<std::size_t>(particle[0])];
  rows.write(16 * surface_, particles.data(), 16 * size_of(particles));
  rows.write(16 * rest_, contacts.rest.data(), 16 * size_of(contacts.rest));
  rows.write(16 * triangle_, contacts.triangle.data(), 16 * size_of(contacts.triangle));
  rows.write(16 * law_, contacts.triangle_law.data(), 16 * size_of(contacts.triangle_law));
}

void ComputeContacts::place(Kernel& kernel) const {
  const auto set = [&](const char* name, std::int64_t value) { kernel.set(name, static_cast<int>(value)); };
  const auto set_real = [&](const char* name, double value) { kernel.set(name, static_cast<float>(value)); };
  pushed_.place(kernel);
  set("surface_count", particles_);
  set("triangle_count", triangles_);
  set("body_count", bodies_);
  set("bucket_count", buckets_);
  set("surface_place", surface_);
  set("surface_rest_place", rest_);
  set("triangle_place", triangle_);
  set("triangle_law_place", law_);
  set("contact_range_place", range_);
  set("surface_moved_place", moved_);
  set("surface_velocity_place", surface_velocity_);
  set("surface_push_place", push_);
  set("triangle_ball_place", ball_);
  set("meeting_place", meeting_);
  set("bucket_first", bucket_first_);
  set("bucket_next", bucket_next_);
  set("bucket_list", bucket_list_);
  set("bucket_of", bucket_of_);
  set("raw_list", raw_);
  set("owner_list", owner_);
  set("queue_first", queue_first_);
  set("queue_next", queue_next_);
  set("queue_list", queue_list_);
  set("live_list", live_);
  set("live_count", live_count_);
  set("turn_list", turn_);
  set("ticket_list", ticket_);
  set("rounds", options_.rounds);
  set("touches_itself", options_.self ? 1 : 0);
  set_real("friction", options_.friction);
  set_real("skin", options_.margin);
  set_real("facing_share", ContactSurface::facing_share);
  set_real("usual_skin", ContactSurface::usual_skin);
  set_real("skin_factor", ContactSurface::skin_factor);
  set_real("depth_factor", ContactSurface::depth_factor);
  set_real("parted_share", ContactSurface::parted_share);
  set_real("largest_parting", ContactSurface::largest_parting);
  set_real("longest_edge", longest_edge_);
  set_real("largest_skins", largest_skins_);
}

}  // namespace phymul::gl

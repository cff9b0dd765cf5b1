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

/// The uniforms of contact_law.glsl, contact_nearest.glsl and contact_range.glsl.
void note_constants(const FloatContacts& contacts, StorageRows& rows) {
  const auto real = [&rows](const char* name, double value) { rows.note(name, static_cast<float>(value)); };
  rows.note("surface_count", static_cast<int>(contacts.particle.size()));
  rows.note("body_count", static_cast<int>(contacts.bodies));
  rows.note("rounds", contacts.options.rounds);
  rows.note("touches_itself", contacts.options.self ? 1 : 0);
  real("friction", contacts.options.friction);
  real("skin", contacts.options.margin);
  real("facing_share", ContactSurface::facing_share);
  real("usual_skin", ContactSurface::usual_skin);
  real("skin_factor", ContactSurface::skin_factor);
  real("depth_factor", ContactSurface::depth_factor);
  real("parted_share", ContactSurface::parted_share);
  real("largest_parting", ContactSurface::largest_parting);
  real("longest_edge", contacts.longest_edge);
  real("largest_skins", contacts.largest_skins());
}

}  // namespace

ComputeContacts::ComputeContacts(const FloatContacts& contacts, const ComputeTables& tables,
                                 const ComputeLimits& limits, StorageRows& rows)
    : particles_(size_of(contacts.particle)),
      triangles_(size_of(contacts.triangle)),
      bodies_(contacts.bodies),
      rounds_(contacts.options.rounds) {
  require_turns(particles_, triangles_, meetings(), limits);
  if (meetings() * rounds_ > std::numeric_limits<int>::max()) {
    throw Error(ErrorCode::not_supported, "expected contacts times rounds of at most 2147483647, got up to " +
                                              std::to_string(meetings()) + " contacts in " + std::to_string(rounds_) +
                                              " rounds; use fewer rounds");
  }
  rows.add("surface_place", tables.placed(contacts.particle, 1));
  rows.add("surface_rest_place", contacts.rest);
  rows.add("triangle_place", contacts.triangle);
  rows.add("triangle_law_place", contacts.triangle_law);
  rows.take("contact_range_place", 1);
  rows.take("surface_moved_place", particles_);
  rows.take("surface_velocity_place", particles_);
  rows.take("surface_push_place", particles_);
  rows.take("triangle_ball_place", triangles_);
  rows.take("meeting_place", 4 * meetings());
  std::int64_t count = 1;
  while (count < 2 * triangles_) count *= 2;
  const std::int64_t entries = 4 * meetings(), raw = rows.take_words("raw_list", std::max(triangles_, entries)),
                     owner = rows.take_words("owner_list", std::max(triangles_, entries));
  rows.take_words("bucket_next", count);
  rows.take_words("queue_next", particles_);
  buckets_ = {.first = rows.take_words("bucket_first", count + 1),
              .owners = count,
              .raw = raw,
              .owner = owner,
              .to = rows.take_words("bucket_list", triangles_),
              .rank = rows.take_words("bucket_of", triangles_)};
  queues_ = {.first = rows.take_words("queue_first", particles_ + 1),
             .owners = particles_,
             .raw = raw,
             .owner = owner,
             .to = rows.take_words("queue_list", entries),
             .rank = rows.take_words("ticket_list", entries)};
  rows.take_words("live_list", meetings());
  rows.take_words("live_count", 2);
  rows.take_words("turn_list", particles_);
  rows.note("triangle_count", static_cast<int>(triangles_));
  rows.note("bucket_count", static_cast<int>(count));
  note_constants(contacts, rows);
  if (4 * rows.end() > std::numeric_limits<int>::max()) {
    throw Error(ErrorCode::not_supported, "contacts of " + std::to_string(particles_) +
                                              " particles of the surfaces of " + std::to_string(bodies_) +
                                              " bodies take more than the 2147483647 words a shader counts to; use " +
                                              "fewer of them, or the backend \"cpu\"");
  }
}

}  // namespace phymul::gl

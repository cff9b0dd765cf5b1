// SPDX-License-Identifier: MIT
#include "compute_loads.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

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
  const auto real = [&rows](const char* name, double value) { rows.note(name, to_float(value)); };
  rows.note("surface_count", static_cast<int>(contacts.particle.size()));
  rows.note("body_count", static_cast<int>(contacts.bodies));
  rows.note("rounds", contacts.options.rounds);
  rows.note("touches_itself", contacts.options.self ? 1 : 0);
  real("friction", contacts.options.friction);
  const double margin = contacts.options.margin;
  real("skin", margin > 0.0 ? std::max(margin, double{std::numeric_limits<float>::min()}) : 0.0);
  real("facing_share", ContactSurface::facing_share);
  real("usual_skin", ContactSurface::usual_skin);
  real("skin_factor", ContactSurface::skin_factor);
  real("depth_factor", ContactSurface::depth_factor);
  real("parted_share", ContactSurface::parted_share);
  real("largest_parting", ContactSurface::largest_parting);
  real("least_mobility", ContactSurface::least_mobility);
  real("longest_edge", contacts.longest_edge);
  real("largest_skins", contacts.largest_skins());
}

}  // namespace

ComputeTools::ComputeTools(const FloatTools& tools, bool acts, const ComputeTables& tables, StorageRows& rows)
    : tables_(&tables),
      count_(tools.count()),
      acts_(acts),
      any_grid_(acts && tools.any_grid()),
      frames_row_(rows.take("tool_frames_place", static_cast<std::int64_t>(tools.most_frames()))),
      held_row_(rows.add("tool_held_place", tables.by_place(tools.held()))) {
  rows.note("tool_count", count_);
  if (!acts_) return;
  rows.add("tool_laws_place", tools.laws());
  rows.add("tool_rest_place", tables.by_place(tools.rest(), FloatTools::rest_rows));
  rows.add("tool_grid_place", tools.grid_values());
  sums_row_ = rows.take("tool_sums_place", std::int64_t{4} * tables.places() * count_);
  parts_row_ = rows.take({}, std::int64_t{4} * most_parts * count_);
  total_row_ = rows.take({}, std::int64_t{4} * count_);
}

void ComputeTools::write_held(const FloatTools& tools, StorageBuffer& buffer) const {
  buffer.write_rows(held_row_, tables_->by_place(tools.held()));
}

void ComputeTools::write_frames(const FloatTools& tools, StorageBuffer& buffer) const {
  buffer.write_rows(frames_row_, tools.frames());
}

ComputeJoints::ComputeJoints(FloatJoints joints, const ComputeTables& tables, StorageRows& rows)
    : joints_(std::move(joints)) {
  rows.add("joint_springs_place", joints_.springs());
  rows.add("joint_anchors_place", tables.placed(joints_.anchors(), 1));
  rows.add("joint_places_place", joints_.places());
  laws_row_ = rows.add("joint_laws_place", joints_.laws());
  rows.add("joint_ranges_place", tables.by_place(joints_.ranges()));
  rows.add("joint_ends_place", joints_.ends());
  state_row_ = rows.take({}, ComputeState::pairs * state_rows());
  rows.note("joint_count", joints_.count());
}

void ComputeJoints::follow(StorageBuffer& buffer) {
  if (joints_.follow()) buffer.write_rows(laws_row_, joints_.laws());
}

ComputeVolumes::ComputeVolumes(const FloatVolumes& volumes, const ComputeTables& tables, StorageRows& rows)
    : count_(volumes.count()), facet_sums_(volumes.levels.front()[1]) {
  const auto sums = static_cast<std::int64_t>(volumes.nodes.size());
  rows.add("kept_laws_place", volumes.laws);
  rows.add("kept_ranges_place", tables.by_place(volumes.ranges, 1, Int4{0, 0, -1, 0}));
  rows.add("kept_around_place", tables.placed(volumes.around, 3));
  rows.add("kept_facets_place", tables.placed(volumes.facets, 4));
  rows.add("kept_edges_place", volumes.edges);
  rows.add("kept_nodes_place", volumes.nodes);
  rows.add("kept_levels_place", volumes.levels);
  rows.take("kept_along_place", tables.places());
  rows.take("kept_sums_place", sums);
  roots_row_ = rows.add("kept_roots_place", std::vector<Float4>(static_cast<std::size_t>(count_), Float4{}));
  rows.note("kept_count", count_);
  rows.note("kept_level_count", static_cast<int>(volumes.levels.size()));
  rows.note("kept_first_total", static_cast<int>(sums) - count_);
}

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

static_assert(sizeof(OpenRow) == 3 * sizeof(Float4), "rows of gather_kernel.glsl");

ComputeOpenStep::ComputeOpenStep(const ComputeTables& tables, StorageRows& rows)
    : tables_(&tables),
      asked_row_(rows.take("gather_rows_place", tables.kind().particles)),
      gathered_row_(rows.take({}, std::int64_t{3} * tables.kind().particles)),
      push_row_(rows.take("push_rows_place", tables.kind().particles)),
      force_row_(rows.take("push_forces_place", tables.kind().particles)),
      shift_row_(rows.take("push_shifts_place", tables.kind().particles)) {
  const auto count = static_cast<std::size_t>(tables.kind().particles);
  rows_.reserve(count);
  pushes_.reserve(count);
  values_.reserve(count);
}

void ComputeOpenStep::set_gathered(std::span<const Index> rows, StorageBuffer& buffer) {
  asked_count_ = static_cast<int>(rows.size());
  rows_.clear();
  for (const Index row : rows) rows_.push_back({tables_->place_of()[static_cast<std::size_t>(row)], 0, 0, 0});
  if (!rows_.empty()) buffer.write_rows(asked_row_, rows_);
}

void ComputeOpenStep::read(std::span<OpenRow> rows, const StorageBuffer& buffer) const {
  if (!rows.empty()) buffer.read(gathered_row_, 3 * static_cast<std::int64_t>(rows.size()), rows.data());
}

void ComputeOpenStep::set_pushes(std::span<const Push> pushes, StorageBuffer& buffer) {
  push_count_ = static_cast<int>(pushes.size());
  if (pushes.empty()) return;
  pushes_.assign(pushes.begin(), pushes.end());
  for (Push& push : pushes_) push.particle = tables_->place_of()[static_cast<std::size_t>(push.particle)];
  std::ranges::sort(pushes_, {}, &Push::particle);
  rows_.clear();
  for (const Push& push : pushes_) rows_.push_back({push.particle, 0, 0, 0});
  buffer.write_rows(push_row_, rows_);
  const auto write = [&](std::int64_t row, Float4 Push::*part) {
    values_.clear();
    for (const Push& push : pushes_) values_.push_back(push.*part);
    buffer.write_rows(row, values_);
  };
  write(force_row_, &Push::force);
  write(shift_row_, &Push::shift);
}

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

// SPDX-License-Identifier: MIT
#include "fragment_scene.h"

#include <utility>

namespace phymul::gl {
namespace {

constexpr std::array<const char*, 4> sum_inputs{"forces", "torques", "last_forces", "last_torques"};

}  // namespace

Reduction::Reduction(int rows, int branch, std::vector<Result> results, const char* what, int lists)
    : rows_(rows), lists_(lists), results_(std::move(results)) {
  do {
    rows = (rows + branch - 1) / branch;
    Level& level = levels_.emplace_back();
    level.rows = rows;
    for (const Result& result : results_) {
      level.results.push_back(Texture::target(std::int64_t{lists_} * rows, result.format, what));
    }
    std::vector<Attachment> attachments;
    for (const Texture& texture : level.results) attachments.push_back({&texture});
    level.target = Framebuffer(attachments);
  } while (rows > 1);
}

void Reduction::draw(Pass& first, Pass& further) {
  int source = rows_;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const Level& level = levels_[k];
    Pass& pass = k == 0 ? first : further;
    for (std::size_t r = 0; k > 0 && r < results_.size(); ++r) {
      pass.input(results_[r].input, levels_[k - 1].results[r]);
    }
    pass.set("source_count", source);
    pass.set("result_count", level.rows);
    pass.set_rows(level.results.front(), lists_ * level.rows);
    pass.draw(level.target);
    source = level.rows;
  }
}

FragmentLoads::FragmentLoads(const Scene& scene, int instants, const FragmentTables& tables)
    : table_(scene, instants, tables.materials()) {
  if (kind().scaled) {
    factors_ =
        Texture::target(static_cast<std::int64_t>(table_.factors().size()), TexelFormat::r32f, "stiffness_factor");
  }
  if (!kind().any()) return;
  tables_.add("load_index", table_.index());
  tables_.add("load_parts", table_.parts());
  values_ = Texture::target(static_cast<std::int64_t>(table_.values().size()), TexelFormat::r32f, "load_values");
}

void FragmentLoads::evaluate(const std::vector<double>& instants) {
  table_.evaluate(instants);
  if (table_.scale()) factors_.upload(std::span<const float>(table_.factors()));
  const std::size_t modes = static_cast<std::size_t>(table_.mode_count());
  if (values_) values_.upload(std::span<const float>(table_.values().data(), instants.size() * modes));
}

void FragmentLoads::bind(Pass& pass) const {
  if (!values_) return;
  tables_.bind(pass);
  pass.input("load_values", values_);
  pass.set("load_count", table_.mode_count());
}

FragmentTools::FragmentTools(const FloatTools& tools, bool acts)
    : any_grid_(tools.any_grid()), count_(tools.count()), particles_(static_cast<int>(tools.held().size())) {
  tables_.add("tool_laws", tools.laws());
  tables_.add("tool_rest", tools.rest());
  if (any_grid_) tables_.add("tool_grid", tools.grid_values());
  held_ = Texture::table(std::span<const Float4>(tools.held()), "tool_held");
  frames_ = Texture::target(static_cast<std::int64_t>(tools.most_frames()), "tool_frames");
  if (!acts) return;
  added_.emplace(particles_, rows_to_one,
                 std::vector<Reduction::Result>{{sum_inputs[0]}, {sum_inputs[1]}, {sum_inputs[2]}, {sum_inputs[3]}},
                 "forces on tools", count_);
  const std::int64_t rows = std::int64_t{count_} * particles_;
  for (Texture& texture : last_) texture = Texture::target(rows, "forces on tools");
  for (std::size_t turn = 0; turn < sums_.size(); ++turn) {
    for (Texture& texture : sums_[turn]) texture = Texture::target(rows, "forces on tools");
    targets_[turn] = Framebuffer({{&sums_[turn][0]}, {&sums_[turn][1]}, {&last_[0]}, {&last_[1]}});
  }
}

void FragmentTools::set_held(const FloatTools& tools) {
  held_.upload(std::span<const Float4>(tools.held()));
}

void FragmentTools::set_frames(const FloatTools& tools) {
  frames_.upload(tools.frames());
}

void FragmentTools::bind(Pass& pass) const {
  tables_.bind(pass);
  pass.input("tool_frames", frames_);
  pass.input("tool_held", held_);
  pass.set("tool_count", count_);
}

void FragmentTools::tell(Pass& pass) {
  pass.input("tool_forces", sums_[static_cast<std::size_t>(turn_)][0]);
  pass.input("tool_torques", sums_[static_cast<std::size_t>(turn_)][1]);
  turn_ = 1 - turn_;
  pass.set("particle_rows", particles_);
  pass.set_rows(last_[0], count_ * particles_);
  pass.draw(targets_[static_cast<std::size_t>(turn_)]);
}

void FragmentTools::sum(Pass& added) {
  const auto& newest = sums_[static_cast<std::size_t>(turn_)];
  const std::array<const Texture*, 4> source{&newest[0], &newest[1], &last_[0], &last_[1]};
  for (std::size_t k = 0; k < source.size(); ++k) added.input(sum_inputs[k], *source[k]);
  added_->draw(added);
}

void FragmentTools::copy(std::size_t offset) const {
  for (int k = 0; k < 4; ++k) {
    const std::size_t at = offset + static_cast<std::size_t>(k) * texels() * sizeof(Float4);
    added_->target().read(k, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(at));  // an offset in the buffer
  }
}

FragmentVolumes::FragmentVolumes(const FloatVolumes& volumes)
    : count_(volumes.count()), particles_(static_cast<int>(volumes.ranges.size())) {
  tables_.add("kept_laws", volumes.laws);
  tables_.add("kept_ranges", volumes.ranges);
  tables_.add("kept_around", volumes.around);
  tables_.add("kept_facets", volumes.facets);
  tables_.add("kept_edges", volumes.edges);
  tables_.add("kept_nodes", volumes.nodes);
  for (Texture& texture : free_) texture = Texture::target(particles_, "free steps");
  along_ = Texture::target(particles_, "ways of kept volumes");
  free_target_ = Framebuffer({{&free_[0]}, {&free_[1]}, {&free_[2]}});
  along_target_ = Framebuffer({{&along_}});
  for (const Int4& nodes : volumes.levels) {
    Level& level = levels_.emplace_back();
    level.first_node = nodes[0];
    level.rows = nodes[1] - nodes[0];
    level.sums = Texture::target(level.rows, "sums of kept volumes");
    level.target = Framebuffer({{&level.sums}});
  }
  for (std::size_t turn = 0; turn < roots_.size(); ++turn) {
    roots_[turn] = Texture::target(count_, "ways of kept volumes");
    root_targets_[turn] = Framebuffer({{&roots_[turn]}});
  }
}

void FragmentVolumes::bind(Pass& pass) const {
  tables_.bind(pass);
  pass.input("kept_along", along_);
  pass.input("free_displacement", free_[0]);
  pass.input("free_velocity", free_[1]);
  pass.input("free_acceleration", free_[2]);
}

void FragmentVolumes::follow_gradient(Pass& along) {
  along.set_rows(along_, particles_);
  along.draw(along_target_);
}

void FragmentVolumes::sum(Pass& facets, Pass& sums) {
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    Pass& pass = k == 0 ? facets : sums;
    if (k == 0) {
      pass.input("displacement", free_[0]);
    } else {
      pass.input("kept_sums", levels_[k - 1].sums);
      pass.set("kept_first_source", levels_[k - 1].first_node);
    }
    pass.set("kept_first_node", levels_[k].first_node);
    pass.set_rows(levels_[k].sums, levels_[k].rows);
    pass.draw(levels_[k].target);
  }
}

void FragmentVolumes::find_roots(Pass& roots, int batch_step) {
  roots.input("kept_sums", levels_.back().sums);
  roots.input("kept_roots", roots_[turn_]);
  turn_ = 1 - turn_;
  roots.set("kept_first_total", 0);
  roots.set("kept_step", batch_step);
  roots.set_rows(roots_[turn_], count_);
  roots.draw(root_targets_[turn_]);
}

void FragmentVolumes::bind_roots(Pass& step) const {
  step.input("kept_roots", roots_[turn_]);
}

void FragmentVolumes::copy(std::size_t offset) const {
  root_targets_[turn_].read(0, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(offset));  // an offset in the buffer
}

FragmentJoints::FragmentJoints(FloatJoints joints)
    : state(joints.count(), static_cast<int>(FragmentLayers::host_texels), "forces of joints"),
      joints_(std::move(joints)),
      laws_(Texture::table(std::span<const Float4>(joints_.laws()), "joint_laws")) {
  springs_.add("joint_springs", joints_.springs());
  springs_.add("joint_anchors", joints_.anchors());
  springs_.add("joint_places", joints_.places());
  ends_.add("joint_ranges", joints_.ranges());
  ends_.add("joint_ends", joints_.ends());
}

void FragmentJoints::follow() {
  if (joints_.follow()) laws_.upload(std::span<const Float4>(joints_.laws()));
}

void FragmentJoints::bind(Pass& pass) const {
  springs_.bind(pass);
  pass.input("joint_laws", laws_);
}

void FragmentJoints::bind_gathering(Pass& pass) const {
  ends_.bind(pass);
  pass.input("joint_state", state.texture(0));
}

FragmentOpenStep::FragmentOpenStep(Index particles, const Texture& measured)
    : force_(Texture::target(particles, "forces before a step's motion")),
      velocity_(Texture::target(particles, "velocities before a step's motion")),
      withheld_(Texture::target(particles, "withheld forces")),
      target_({{&force_}, {&velocity_}, {&withheld_}, {&measured}}),
      asked_(Texture::target(particles, TexelFormat::rgba32i, "rows to gather")),
      gathered_{Texture::target(particles, "gathered displacements"), Texture::target(particles, "gathered velocities"),
                Texture::target(particles, "gathered forces")},
      gathered_target_({{&gathered_[0]}, {&gathered_[1]}, {&gathered_[2]}}),
      push_rows_(Texture::target(particles, TexelFormat::rgba32i, "rows that are pushed")),
      push_forces_(Texture::target(particles, "forces of the host")),
      push_shifts_(Texture::target(particles, "shifts of the host")) {
  const auto texels = static_cast<std::size_t>(gathered_target_.shape().texels());
  rows_.reserve(texels);
  texels_.resize(texels);
  more_texels_.reserve(texels);
}

void FragmentOpenStep::bind(Pass& pass) const {
  pass.input("pushed_force", force_);
  pass.input("free_velocity", velocity_);
  pass.input("pushed_shift", withheld_);
}

void FragmentOpenStep::bind_pushes(Pass& pass) const {
  pass.input("push_rows", push_rows_);
  pass.input("push_forces", push_forces_);
  pass.input("push_shifts", push_shifts_);
}

void FragmentOpenStep::set_gathered(std::span<const Index> rows) {
  asked_count_ = static_cast<int>(rows.size());
  rows_.clear();
  for (const Index row : rows) rows_.push_back({row, 0, 0, 0});
  if (!rows_.empty()) asked_.upload(std::span<const Int4>(rows_));
}

void FragmentOpenStep::gather(Pass& pass) const {
  if (asked_count_ == 0) return;
  pass.input("gather_rows", asked_);
  pass.set_rows(gathered_[0], asked_count_);
  pass.draw(gathered_target_);
}

void FragmentOpenStep::read(std::span<OpenRow> rows) {
  if (rows.empty()) return;
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  const auto take = [&](int k, Float4 OpenRow::*part) {
    gathered_target_.read(k, GL_RGBA, GL_FLOAT, texels_.data(), static_cast<std::int64_t>(rows.size()));
    for (std::size_t row = 0; row < rows.size(); ++row) rows[row].*part = texels_[row];
  };
  take(0, &OpenRow::displacement);
  take(1, &OpenRow::velocity);
  take(2, &OpenRow::withheld);
}

void FragmentOpenStep::set_pushes(std::span<const Push> pushes) {
  push_count_ = static_cast<int>(pushes.size());
  if (pushes.empty()) return;
  rows_.clear();
  for (const Push& push : pushes) rows_.push_back({push.particle, 0, 0, 0});
  push_rows_.upload(std::span<const Int4>(rows_));
  more_texels_.clear();
  for (const Push& push : pushes) more_texels_.push_back(push.force);
  push_forces_.upload(std::span<const Float4>(more_texels_));
  more_texels_.clear();
  for (const Push& push : pushes) more_texels_.push_back(push.shift);
  push_shifts_.upload(std::span<const Float4>(more_texels_));
}

}  // namespace phymul::gl

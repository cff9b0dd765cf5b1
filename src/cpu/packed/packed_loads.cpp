// SPDX-License-Identifier: MIT
#include "packed_loads.h"

#include <cstring>

#include "body_sleep.h"

namespace phymul::cpu {

PackedLoads::Sums::Sums(const std::vector<Index>& offset, const std::vector<LoadModes::Part>& parts,
                        const PackedBody& body)
    : parts_(parts), at_(4 * static_cast<std::size_t>(body.places), 0.0f) {
  for (std::size_t place = 0; place < body.order.size(); ++place) {
    const Index i = body.order[place];
    if (offset[i] < offset[i + 1]) rows_.push_back({body.quad_of(place), offset[i], offset[i + 1]});
  }
}

void PackedLoads::Sums::evaluate(const std::vector<double>& value, std::uint8_t* changed) {
  if (value == evaluated_) return;
  evaluated_ = value;  // of the same size but for the first time
  for (const Row& row : rows_) {
    Vec3 sum = Vec3::Zero();
    for (Index k = row.first; k < row.last; ++k) sum += value[parts_[k].mode] * parts_[k].vector;
    for (int a = 0; a < 3; ++a) {
      const auto now = static_cast<float>(sum[a]);
      if (changed != nullptr && now != at_[4 * row.quad + a]) changed[SleepBlocks::of_quad(row.quad)] = 1;
      at_[4 * row.quad + a] = now;
    }
  }
}

PackedLoads::PackedLoads(const Scene& scene, const PackedBody& body) {
  LoadModes modes = scene.modes();
  acceleration_ = std::move(modes.acceleration);
  steady_gravity_ = gravity_ = modes.gravity;
  value_.assign(static_cast<std::size_t>(modes.count), 0.0);
  if (!modes.force_offset.empty()) force_ = Sums(modes.force_offset, modes.force, body);
  if (modes.fixed.empty()) return;
  target_ = Sums(modes.target_offset, modes.target, body);
  fixed_.assign(static_cast<std::size_t>(body.places), 0);
  for (std::size_t place = 0; place < body.order.size(); ++place) fixed_[place] = modes.fixed[body.order[place]];
}

void PackedLoads::act_at(const Scene& scene, double time, std::uint8_t* changed) {
  if (acceleration_.empty() && force_.empty()) return;
  scene.mode_values(time, value_);
  gravity_ = steady_gravity_;
  for (const LoadModes::Part& part : acceleration_) gravity_ += value_[part.mode] * part.vector;
  if (!force_.empty()) force_.evaluate(value_, changed);
}

void PackedLoads::impose_at(const Scene& scene, double time, std::uint8_t* changed) {
  if (target_.empty()) return;
  scene.mode_values(time, value_);
  target_.evaluate(value_, changed);
}

void PackedLoads::point(simd::Move& move) const {
  move.load = force_.empty() ? nullptr : force_.data();
  move.target = target_.empty() ? nullptr : target_.data();
  move.fixed = target_.empty() ? nullptr : fixed_.data();
  for (int a = 0; a < 3; ++a) move.gravity[a] = static_cast<float>(gravity_[a]);
}

void PackedJoints::follow(JointSet& joints, StiffJoints* stiff, const ToolSet& tools, const PackedBody& body) {
  at_.clear();
  reached_.clear();
  load_.clear();
  if (joints.empty()) return;
  const std::vector<std::size_t> place_of = places_of(body);
  for (const JointSet::Point& point : joints.points()) {
    const std::size_t place = place_of[point.particle];
    At& at = at_.emplace_back();
    at.quad = body.quad_of(place);
    for (int axis = 0; axis < 3; ++axis) at.velocity[static_cast<std::size_t>(axis)] = velocity_at(body, place, axis);
  }
  if (stiff != nullptr) {
    for (const StiffJoints::Reached& reached : stiff->reached()) {
      reached_.push_back({body.quad_of(place_of[reached.particle]), place_of[reached.particle]});
    }
  }
  ways_.reserve(tools.count());
  load_.assign(4 * static_cast<std::size_t>(body.places), 0.0f);
}

void PackedJoints::act(JointSet& joints, const ToolSet& tools, const TopologyTextures& topology, double dt,
                       simd::Move& move, std::uint8_t* changed) {
  const auto* const u = reinterpret_cast<const float*>(move.u);
  for (std::size_t row = 0; row < at_.size(); ++row) {
    const At& at = at_[row];
    JointSet::Point& point = joints.points()[row];
    const float* const own = u + 4 * at.quad;
    point.position = topology.rest[point.particle] + Vec3(own[0], own[1], own[2]);
    point.velocity = Vec3(move.v[at.velocity[0]], move.v[at.velocity[1]], move.v[at.velocity[2]]);
  }
  tools.ways(dt, ways_);
  joints.act(ways_, dt);

  if (move.load != nullptr) {
    std::memcpy(load_.data(), move.load, sizeof(float) * load_.size());
  } else {
    for (const Place& reached : reached_) std::memset(&load_[4 * reached.quad], 0, 4 * sizeof(float));
  }
  for (std::size_t row = 0; row < at_.size(); ++row) {
    At& at = at_[row];
    float* const load = &load_[4 * at.quad];
    const Eigen::Vector3f force = joints.points()[row].force.cast<float>();
    for (int a = 0; a < 3; ++a) {
      if (changed != nullptr && force[a] != at.force[a]) changed[SleepBlocks::of_quad(at.quad)] = 1;
      at.force[a] = force[a];
      load[a] = (move.load != nullptr ? load[a] : 0.0f) + force[a];
    }
  }
  move.load = reinterpret_cast<const char*>(load_.data());
}

template <class Acceleration>
void PackedJoints::solve(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d,
                         const simd::Move& move, const Acceleration& acceleration, bool later, char* loads) {
  const std::span<StiffJoints::Reached> reached = stiff.reached();
  for (std::size_t row = 0; row < reached_.size(); ++row) {
    const auto [quad, place] = reached_[row];
    reached[row].acceleration = acceleration(4 * quad, static_cast<double>(move.inverse_mass[place]));
    for (int axis = 0; axis < 3; ++axis) {
      if (move.fixed != nullptr && (move.fixed[place] >> axis & 1) != 0) reached[row].acceleration[axis] = 0.0;
    }
  }
  stiff.act(scene, joints, dt, d, later);
  auto* const to = reinterpret_cast<float*>(loads);
  for (std::size_t row = 0; row < reached_.size(); ++row) {
    for (std::size_t a = 0; a < 3; ++a) to[4 * reached_[row].quad + a] += static_cast<float>(reached[row].force[a]);
  }
}

namespace {

Vec3 vector_at(const char* quads, std::size_t at) {
  const auto* const own = reinterpret_cast<const float*>(quads) + at;
  return {own[0], own[1], own[2]};
}

}  // namespace

void PackedJoints::solve(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d,
                         const char* force, simd::Move& move) {
  const Vec3 gravity(move.gravity[0], move.gravity[1], move.gravity[2]);
  const double largest = move.largest_acceleration;
  const auto all = [&](std::size_t at, double inverse_mass) -> Vec3 {
    Vec3 elastic = vector_at(force, at);
    const double size = inverse_mass * elastic.norm();
    if (size > largest) elastic *= largest / size;  // as the moving kernel does
    return inverse_mass * (elastic + vector_at(move.load, at)) + gravity;
  };
  solve(stiff, joints, scene, dt, d, move, all, false, reinterpret_cast<char*>(load_.data()));
}

void PackedJoints::solve_pushes(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d,
                                const simd::Move& move, char* loads) {
  const auto pushes = [&](std::size_t at, double inverse_mass) -> Vec3 {
    return inverse_mass * (vector_at(loads, at) - vector_at(move.load, at));
  };
  solve(stiff, joints, scene, dt, d, move, pushes, true, loads);
}

}  // namespace phymul::cpu

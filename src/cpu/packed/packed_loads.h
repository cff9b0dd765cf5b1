// SPDX-License-Identifier: MIT
//
// What acts on a body, in the arrays that the moving kernel reads: the loads of a scene, and its joints. Displacements
// and velocities of particles where the vector kernels keep them: u [places + 1][4] by quad, m, and v
// [slices][3][lanes], m/s.
#pragma once

#include <phymul/load_frame.h>
#include <phymul/scene.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "interaction/stiff_joints.h"
#include "interaction/tool_set.h"
#include "packed_body.h"

namespace phymul::cpu {

/// [particles] the place of each in PackedBody::order.
inline std::vector<std::size_t> places_of(const PackedBody& body) {
  std::vector<std::size_t> place_of(body.order.size());
  for (std::size_t place = 0; place < place_of.size(); ++place) place_of[body.order[place]] = place;
  return place_of;
}

inline std::size_t velocity_at(const PackedBody& body, std::size_t place, int axis) {
  const auto lanes = static_cast<std::size_t>(body.lanes);
  return (3 * (place / lanes) + static_cast<std::size_t>(axis)) * lanes + place % lanes;
}

inline Vec3 displacement(const PackedBody& body, const Floats& u, std::size_t place) {
  const float* at = &u[4 * body.quad_of(place)];
  return {at[0], at[1], at[2]};
}

inline Vec3 velocity(const PackedBody& body, const Floats& v, std::size_t place) {
  return {v[velocity_at(body, place, 0)], v[velocity_at(body, place, 1)], v[velocity_at(body, place, 2)]};
}

/// The kernel knows that there is one; it is sought here, in the model's order.
inline Index first_runaway(const PackedBody& body, const Floats& u, const Floats& v, double speed) {
  Index first = std::numeric_limits<Index>::max();
  const double greatest = std::min(speed, std::sqrt(static_cast<double>(std::numeric_limits<float>::max())));
  for (std::size_t place = 0; place < body.order.size(); ++place) {
    const Vec3 at = displacement(body, u, place);
    const bool reached = at.allFinite() && at.squaredNorm() <= std::numeric_limits<float>::max();
    // A little less than the bound: the kernel rounds its squares.
    if (!reached || !(velocity(body, v, place).norm() <= greatest * (1.0 - 1e-6))) {
      first = std::min(first, body.order[place]);
    }
  }
  return first;
}

/// The loads of a scene in the arrays the moving kernel reads. A scene without forces, or without imposed positions,
/// has no array for them; constant loads are written once.
class PackedLoads {
 public:
  PackedLoads(const Scene& scene, const PackedBody& body);

  /// Forces and accelerations, at the old time. `changed`: null, or [SleepBlocks] to be set to 1 for the blocks of
  /// particles whose force is another than at the last call.
  void act_at(const Scene& scene, double time, std::uint8_t* changed);
  void impose_at(const Scene& scene, double time, std::uint8_t* changed);  ///< positions, at the new time; likewise

  void point(simd::Move& move) const;

 private:
  /// Sums of value[mode] * vector over each particle that has any.
  class Sums {
   public:
    Sums() = default;
    Sums(const std::vector<Index>& offset, const std::vector<LoadModes::Part>& parts, const PackedBody& body);
    bool empty() const { return at_.empty(); }
    const char* data() const { return reinterpret_cast<const char*>(at_.data()); }
    void evaluate(const std::vector<double>& value, std::uint8_t* changed);

   private:
    struct Row {
      std::size_t quad;
      Index first, last;  // parts_
    };
    std::vector<Row> rows_;
    std::vector<LoadModes::Part> parts_;
    std::vector<double> evaluated_;  // the values of at_
    Floats at_;                      // [places][4] by quad
  };

  std::vector<LoadModes::Part> acceleration_;
  Vec3 steady_gravity_, gravity_;
  std::vector<double> value_;
  Sums force_, target_;
  Offsets fixed_;  // [places] or empty
};

/// Joints in the fast backend: their forces, in double precision, are added to the loads that the moving kernel reads.
class PackedJoints {
 public:
  /// After a change of the scene. `stiff`: SolverBackend::stiff_joints(). Empties what it does not need.
  void follow(JointSet& joints, StiffJoints* stiff, const ToolSet& tools, const PackedBody& body);

  /// Before a moving pass of dt, s, if there are joints: adds their forces to move.load, in an array of its own.
  /// `changed`: null, or marks for blocks of particles (SleepBlocks) whose forces are not those of the last call.
  void act(JointSet& joints, const ToolSet& tools, const TopologyTextures& topology, double dt, simd::Move& move,
           std::uint8_t* changed);

  /// Adds to load_ what the implicit joints change of the forces in `force`, [places][4] N by quad, and the loads of
  /// `move`.
  void solve(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d, const char* force,
             simd::Move& move);
  /// The same of what tools have added to move.load, to `loads`, which have both.
  void solve_pushes(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d,
                    const simd::Move& move, char* loads);

 private:
  struct At {
    std::size_t quad;                     // of displacements and loads
    std::array<std::size_t, 3> velocity;  // rows of it
    std::array<float, 3> force{};         // N, of the last call
  };
  struct Place {
    std::size_t quad, place;
  };
  template <class Acceleration>
  void solve(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d,
             const simd::Move& move, const Acceleration& acceleration, bool later, char* loads);

  std::vector<At> at_;          // by JointSet::points()
  std::vector<Place> reached_;  // by StiffJoints::reached()
  std::vector<ToolWay> ways_;
  Floats load_;  // [places][4] by quad, N; empty without joints
};

}  // namespace phymul::cpu

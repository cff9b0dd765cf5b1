// SPDX-License-Identifier: MIT
//
// A needle in tissue: the nodes of its hole are material points, held on the shaft sideways (which bends by that unless
// it is stiff), rubbed by it lengthwise, and pushed ahead by the tip. All are impulses on where a step would take the
// particles, each within its limit; node after node, several times over (projected Gauss-Seidel, as for friction in M.
// Jean, "The non-smooth contact dynamics method", Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257).
//
// Where a needle's shaft is, and how it bends: a beam clamped in the hub under forces across it (Euler and Bernoulli;
// the closed form of a cantilever under one force, and the sum over the forces). So there is nothing to discretise, and
// no stiffness that a step would have to resolve.
#pragma once

#include <phymul/joint.h>
#include <phymul/model.h>
#include <phymul/needle.h>
#include <phymul/tool.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "predicted_step.h"

namespace phymul {

/// The unbent shaft in the world: a coordinate along it, m from the tip, and the point of the shaft that is nearest to
/// one of the world. Its line or circle continues ahead of the tip and behind the tail: a circle on either side over
/// half of what the shaft leaves of it.
class ShaftLine {
 public:
  ShaftLine(const Needle& needle, const ToolPose& pose);
  /// Straight, from a tip along a unit vector.
  ShaftLine(const Vec3& tip, const Vec3& axis) : tip_(tip), axis_(axis) {}

  double along(const Vec3& x) const;
  Vec3 place(double along) const;
  Vec3 axis(double along) const;                    ///< unit tangent there, toward the tail
  Vec3 aside(const Vec3& x) const;                  ///< m: from the nearest point of the shaft
  const Quaternion& turn() const { return turn_; }  ///< of the tool's frame
  double arc_radius() const { return arc_radius_; }
  double round() const { return round_; }  ///< m, of the whole circle; infinite: straight
  Vec3 centre() const { return tip_ + arc_radius_ * (turn_ * Vec3::UnitX()); }

 private:
  Vec3 tip_, axis_;  // at the tip
  Quaternion turn_{1, 0, 0, 0};
  double arc_radius_ = 0.0, ahead_ = 0.0, round_ = HUGE_VAL;  // m; 0: straight. m ahead of the tip where it ends
};

/// m/N: how far a force across the shaft `from` m from the tip moves its place `at` m from the tip. Places beyond the
/// hub do not move, those ahead of the tip move as it does. 0 where the needle is stiff.
double shaft_compliance(const Needle& needle, double at, double from);

/// m, in the tool's frame.
Vec3 shaft_deflection(const Needle& needle, std::span<const ShaftLoad> loads, double along);

/// Whether what is `along` m from the tip toward the hub is ahead of it by more than what forces leave open: where the
/// tip does not cut, they bring the last node to 0 but for some 1e-3 of a step's motion, either side, so that a bound
/// of 0 would be decided by rounding. A tenth of the radius is far more than that, and a part of the tip itself.
bool is_ahead_of_tip(const Needle& needle, double along);

class NeedlePath {
 public:
  NeedlePath(const Needle& needle, double friction, const Model& model);

  /// `force`: what it takes from the particles is added there. `end`: of a needle that was let go, where the tissue
  /// takes it. `placed`: it was put at `start`, so that it passed nothing.
  void act(TouchedParticles& touched, const ToolPose& start, bool placed, ToolPose& end, ToolForce& force);
  void accept();                         ///< the step counts
  void remember() { before_ = state_; }  ///< before act() and set_free() of a step
  void drop() { state_ = before_; }      ///< the step does not count

  const NeedleState& state() const { return state_; }
  int gave_way() const { return gave_way_; }  ///< punctures below Needle::puncture, in accepted steps
  void restore(NeedleState state);
  void set_free(bool free) { state_.free = free; }
  /// What has left the shaft at its tail in the last act(), in order, m: places at the step's start.
  const std::vector<std::pair<Anchor, Vec3>>& passed() const { return passed_; }
  void follow_body(const Model& model);  ///< cells were removed or brought back: surface, and nodes of the hole
  void follow_stiffness(const Model& model, std::span<const double> factors);  ///< Scene::stiffness_factors()

 private:
  /// How an impulse on one node moves another: they share particles.
  struct Reached {
    std::size_t node = 0;
    double inverse_mass = 0.0;  // sum w w' / m over particles that are not held, 1/kg
    Vec3 along_axes{0, 0, 0};   // 1/kg, the same over those whose coordinate is free
  };
  /// A node in one step.
  struct Coupled {
    std::vector<std::size_t> slots;
    std::vector<Reached> reached;       // itself included
    Vec3 end{0, 0, 0};                  // m: where it will be, by the impulses so far
    double inverse_mass = 0.0;          // sum w^2 / m, 1/kg
    double along = 0.0;                 // m from the tip toward the hub, at the step's start
    double length = 0.0;                // m of shaft that rubs here
    double limit = 0.0;                 // N s of friction
    double rubbed = 0.0, pushed = 0.0;  // N s given so far: along the shaft toward the hub; by the tip, forward
    Vec3 sideways{0, 0, 0};             // N s
    Vec3 axis{0, 0, 0};                 // of the shaft there, at the step's end
    Vec3 arm{0, 0, 0};                  // m, from centre_, on the shaft at the step's start
    bool slides = false;
  };

  // Where the holes go, by the positions at the step's start: needle_path.cpp.
  void follow(const TouchedParticles& touched, const ShaftLine& line, bool placed);
  void pass_tail(const PredictedStep& step, const ShaftLine& line, bool placed);
  bool withdraw(const PredictedStep& step, const ShaftLine& line);
  bool enter(const PredictedStep& step, const ShaftLine& line);
  bool come_out(const PredictedStep& step, const ShaftLine& line);
  void lengthen(const PredictedStep& step, const ShaftLine& line);
  void add_nodes(const PredictedStep& step, const ShaftLine& line, double until);
  bool add_node(const PredictedStep& step, const Vec3& x, std::int32_t body);
  void enter_at_tip(const PredictedStep& step, const ShaftLine& line);
  void let_go_of_removed();
  void forget();
  std::size_t last_hole() const;  // row of its first node
  // Where the shaft's line goes through the surface.
  struct Crossing {
    double along = 0.0;    // m
    bool outward = false;  // toward the tail
    std::int32_t body = 0;
  };
  const std::vector<Crossing>& crossings(const PredictedStep& step, const ShaftLine& line, double from, double to);
  void look_around_shaft(const PredictedStep& step, const ShaftLine& line, double from, double to);
  NeedleNode node_at(const PredictedStep& step, const Vec3& x, std::int32_t body);
  static Vec3 place(const NeedleNode& node, const PredictedStep& step);
  double bears(const NeedleNode& node) const;
  Vec3 shaft_at(const ShaftLine& line, double along) const;
  ShaftLine near_tip(const ShaftLine& line) const;

  // What acts on it: needle_coupling.cpp, needle_forces.cpp. k: row of a node.
  void couple(TouchedParticles& touched, const ShaftLine& start);
  ToolPose carried(TouchedParticles& touched, const ToolPose& start);
  ToolPose balanced(const ToolPose& end, double dt) const;
  void couple_nodes(TouchedParticles& touched);
  void share_out_length();
  void limit(double turned, double dt);
  void hold_sideways(std::size_t k, const ShaftLine& end, double dt);
  void couple_sideways(double dt);
  void hold_on_bent(const ShaftLine& end, double dt);
  Vec3 limited(std::size_t k, const Vec3& sideways) const;
  void rub(std::size_t k, const ShaftLine& end, double dt);
  void push_ahead(const ShaftLine& end, double dt);
  void twist(std::size_t k, TouchedParticles& touched, const ShaftLine& end, double turned);
  void settle(TouchedParticles& touched, ToolPose& end_pose);
  void give(std::size_t k, const Vec3& impulse, double dt);
  void hand_over(TouchedParticles& touched);
  Vec3 place_at_end(std::size_t k, TouchedParticles& touched) const;
  bool on_shaft(std::size_t node) const;

  /// By how much nodes count as softer than they are: two that move as one leave no system singular.
  static constexpr double slack = 1e-9;

  Needle needle_;
  double friction_ = 0.0, spread_ = 0.0;
  double support_radius_ = 0.0;  // m: of the weights that spread a force so far
  std::vector<double> bearing_;  // [N] Pa: needle_bearing()
  std::vector<double> factors_;  // that it is of
  double most_push_ = 0.0;       // N, of the tip in this step
  int gave_way_ = 0;
  bool gives_way_ = false;                    // in this step
  std::vector<std::array<Index, 3>> facets_;  // outward
  std::vector<Index> surface_;                // their particles
  std::vector<std::uint8_t> sides_;           // [N] of look_around_shaft()
  std::vector<std::int32_t> body_of_;         // [N] of connected bodies; below 0: it has no mass
  std::vector<Crossing> crossings_;
  std::vector<std::pair<Anchor, Vec3>> passed_;
  NeedleState state_, before_;
  std::vector<Coupled> coupled_;  // per node of the hole, and some that wait for more
  std::vector<Index> found_;
  std::vector<double> share_of_;                     // [slot] 1/kg
  std::vector<std::pair<std::size_t, Vec3>> given_;  // slot, impulse: of this step

  // Of a free needle.
  Vec3 centre_{0, 0, 0};               // m, mean of the nodes that carry it
  Eigen::Matrix<double, 6, 6> rigid_;  // kg, kg m, kg m^2: what these resist to its moving and turning

  // Of a shaft that bends. Rows are those of held_.
  std::vector<std::size_t> held_;  // nodes held sideways in this step; of a free needle, that carry it
  // As many of them as are held; the rest is room.
  Eigen::MatrixXd compliance_;  // m/N, of the shaft
  Eigen::MatrixXd gives_;       // m / (N s), of the shaft and the tissue; then its lower triangular factor
  Eigen::Matrix<double, Eigen::Dynamic, 3> off_;
  std::vector<ShaftLoad> loads_;  // of this step
};

}  // namespace phymul

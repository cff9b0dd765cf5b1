// SPDX-License-Identifier: MIT
//
// A needle in tissue: the nodes of its hole are material points, held on the shaft sideways (which bends by that unless
// it is stiff), rubbed by it lengthwise, and pushed ahead by the tip. All are impulses on where a step would take the
// particles, each within its limit; node after node, several times over (projected Gauss-Seidel, as for friction in M.
// Jean, "The non-smooth contact dynamics method", Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257).
#pragma once

#include <phymul/model.h>
#include <phymul/needle.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "predicted_step.h"
#include "tool_frame.h"

namespace phymul {

class NeedlePath {
 public:
  NeedlePath(const Needle& needle, double friction, const Model& model);

  /// `force`: what it takes from the particles is added there.
  void act(TouchedParticles& touched, const ToolPose& start, const ToolPose& end, ToolForce& force);
  void accept();  ///< the step counts

  const NeedleState& state() const { return state_; }
  int gave_way() const { return gave_way_; }        ///< punctures below Needle::puncture, in accepted steps
  double length() const { return needle_.length; }  ///< m
  void restore(NeedleState state) { state_ = std::move(state); }
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
    bool slides = false;
  };
  /// Tip and axis, which points to the hub, of the unbent shaft.
  struct Line {
    explicit Line(const ToolPose& pose)
        : tip(pose.position), axis(pose.orientation * Vec3::UnitZ()), turn(pose.orientation) {}
    double along(const Vec3& x) const { return axis.dot(x - tip); }
    Vec3 aside(const Vec3& x) const { return x - tip - along(x) * axis; }
    Vec3 tip, axis;
    Quaternion turn;  // of the tool's frame
  };

  // Where the hole goes, by the positions at the step's start: needle_path.cpp.
  void follow(const TouchedParticles& touched, const Line& line);
  bool enter(const PredictedStep& step, const Line& line);
  void look_around_shaft(const PredictedStep& step, const Line& line);
  void lengthen(const PredictedStep& step, const Line& line);
  struct Crossing {
    double way = -1.0;     // m to the surface; negative: none
    bool outward = false;  // goes out there
  };
  Crossing nearest_surface(const PredictedStep& step, const Vec3& x, const Vec3& direction) const;
  NeedleNode node_at(const PredictedStep& step, const Vec3& x);
  static Vec3 place(const NeedleNode& node, const PredictedStep& step);
  double bears(const NeedleNode& node) const;
  Vec3 shaft_at(const Line& line, double along) const;

  // What acts on it: needle_coupling.cpp, needle_forces.cpp. k: row of a node.
  void couple(TouchedParticles& touched, const Line& start, double turned);
  void couple_nodes(TouchedParticles& touched);
  void share_out_length();
  void limit(double turned, double dt);
  void hold_sideways(std::size_t k, const Line& end, double dt);
  void couple_sideways(double dt);
  void hold_on_bent(const Line& end, double dt);
  void rub(std::size_t k, const Line& end, double dt);
  void push_ahead(const Line& end, double dt);
  void twist(std::size_t k, TouchedParticles& touched, const Line& end, double turned);
  void settle(TouchedParticles& touched, const Line& end);
  void give(std::size_t k, const Vec3& impulse, double dt);
  void hand_over(TouchedParticles& touched, const Line& end);
  Vec3 place_at_end(std::size_t k, TouchedParticles& touched) const;
  bool on_shaft(std::size_t node) const;

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
  std::vector<std::uint8_t> removed_;         // [N] whether it has no mass
  NeedleState state_;
  std::vector<Coupled> coupled_;  // per node of the hole, and some that wait for more
  std::vector<Index> found_;
  std::vector<double> share_of_;                     // [slot] 1/kg
  std::vector<std::pair<std::size_t, Vec3>> given_;  // slot, impulse: of this step

  // Of a shaft that bends. Rows are those of held_.
  std::vector<std::size_t> held_;  // nodes held sideways in this step
  // As many of them as are held; the rest is room.
  Eigen::MatrixXd compliance_;  // m/N, of the shaft
  Eigen::MatrixXd gives_;       // m / (N s), of the shaft and the tissue; then its lower triangular factor
  Eigen::Matrix<double, Eigen::Dynamic, 3> off_;
  std::vector<ShaftLoad> loads_;  // of this step
};

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// A tool with ToolContact::surface against the points of a body's surface, in one step.
//
// A point s moves as the mean of its particles i by shares w_si, and an impulse J_s on it gives w_si J_s to each.
// Several rounds follow each other. In a round every point that touches is pressed as a particle is (touch_in_step),
// all from the same state, with the inverse mass
//   a_s = sum_i w_si L_i / (L_s m_i),   L_i = sum_s w_si L_s,   L_s = area that the point stands for times its depth.
// Particles are so split among the points that share them (R. Tonge, F. Benevolenti, A. Voroshilov, Mass Splitting for
// Jitter-Free Parallel Rigid Body Simulation, 2012). With the loads L as weights, Gershgorin's theorem says that no
// eigenvalue of the matrix that takes the depths before a round to those after it is negative or above 1, whatever the
// number of points and the triangles' shape. So a round does not overshoot, its result does not depend on the order of
// points, and what lies evenly deep comes out in one round. Because a point that begins to touch has no load, the force
// is continuous as a tool slides. The next step starts from what the last round leaves.
//
// Friction acts on the particles, after every second round, as in touch_in_step: against all sliding of a particle, up
// to Coulomb's limit by what all rounds have pressed it with. So what sticks does not creep. (Friction of a point in a
// round could use that round's press alone. Shallow points would slide where deep ones have limit to spare, a little in
// each step, without end.)
//
// A flat face presses a triangle that lies before it at its corners: so under a plate a particle is one point, as with
// ToolContact::particles. A triangle over a box's edges is one constraint, the root of the integral of its squared
// depth phi (depth_in), whose gradient pushes all its corners: as the nearest faces' parts of that integral have it,
// which at an edge is along the triangle's normal. In place of a point's mass it has
//   1 / sum_i |g_i|^2 L_i / (L_si m_i),   g_i = integral of phi n w_i,   L_si = integral of phi w_i.
// Cut triangles, boxes with a margin, and what moves far in a step are pressed at all points, as by other tools. A box
// is thin to what would pass its middle in a step, as light particles would that are pressed hard: it is then as if the
// box were thicker on the side that the triangle does not come from.
//
// Which triangles a tool may touch is found with some room to spare and kept while body and tool use it up.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "contact_points.h"
#include "contact_tool.h"
#include "predicted_step.h"
#include "tool_frame.h"

namespace phymul {

/// Whether a step is much shorter than the last one. What a step leaves inside goes with the square of its length. The
/// short steps that follow would push out what is deeper with a blow. As if the tool had been put over it, it comes out
/// without one, in rounds that look anew for what touches, until no more is left than a short step leaves.
constexpr bool lets_surface_out(double dt, double last_dt) {
  return dt < 0.7 * last_dt;
}

constexpr int most_again = 50;  ///< times that they look anew

/// Rounds in a step, and in one that moves a body out of a tool that was put over it: what those leave would come out
/// with speed.
constexpr int rounds_of_surface(bool placed) {
  return placed ? 60 : 6;
}

/// Times in a step that triangles over a box's edges are looked at. How they are in the box depends on their places: in
/// those that only elastic forces would take particles to, they are deeper than they come to be. Pushed from there
/// alone, they are driven along the edge, and tissue flutters about it without end.
constexpr int looks_at_box = 3;

/// Whether a particle below the surface was in the tool before this step. One that was not is stopped as with
/// ToolContact::particles: where a body is hit hard, its surface alone does not keep the rest out of the tool.
inline bool is_deep_in(const ShapeIn<double>& shape, const Vector3<double>& start) {
  return distance_to(shape, start).phi < -0.01 * shape.thickness;
}

class SurfacePress {
 public:
  /// Allocates; act() does not.
  SurfacePress(const ContactSurface& surface, const Model& model, const Tool& tool);

  /// Places changed otherwise than step by step.
  void forget() { gone_ = NAN; }

  /// Whether the particle is on the surface, or of a body that has none.
  bool has(Index row) const { return points_.patch_first[row] < points_.patch_first[row + 1]; }
  /// Impulses go to `touched`, and what they took to `force`.
  void act(const ShapeIn<double>& shape, const ContactLaw<double>& law, const ToolFrame& start, const ToolFrame& end,
           TouchedParticles& touched, ToolForce& force);

 private:
  struct Corner {  // a particle, in the tool's frame
    // m, of its way in this step, with the impulses of past rounds; N s, of this round. Beside each other, because each
    // point of each round needs these alone.
    Vec3 to{0, 0, 0}, impulse{0, 0, 0};
    Vec3 shift{0, 0, 0};  // kg m, of this round
    Vec3 from{0, 0, 0};   // m; with shifts
    Index row = -1;
    std::optional<std::size_t> slot{};       // once it has a load
    double inverse_mass = 0.0;               // 1/kg, 0 where it is imposed or held; likewise
    std::uint8_t fixed = 0;                  // TouchedParticles::Touched; likewise
    double area = 0.0;                       // m^2, that it stands for where triangles are pressed at their corners
    double load = 0.0;                       // m^3: sum over what touches of its part of that load
    Vec3 pressed{0, 0, 0}, rubbed{0, 0, 0};  // N s, of all rounds: by points and triangles, and by friction
    Vec3 given{0, 0, 0}, shifted{0, 0, 0};   // N s; m: of all rounds, what it could take
  };
  struct Corners {  // of a patch, in corners_
    std::array<std::size_t, 4> row{};
    int count = 0;
    std::span<const std::size_t> rows() const { return {row.data(), static_cast<std::size_t>(count)}; }
  };
  struct Met {  // a patch that may touch in this step
    Corners corner{};
    const ContactPoints::Patch* patch = nullptr;
    bool is_triangle = false;        // of three particles
    std::optional<BoxPlanes> box{};  // of a triangle that does not go through the box
  };
  struct Crowd {                           // of a point
    double inverse_mass = 0.0, crowd = 0;  // 1/kg: a_s; and the same without the particles' inverse masses
  };
  struct Pressed {  // a point that touches where points were found
    Corners corner{};
    ContactPoints::Shares share{};  // of them
    double load = 0.0;              // m^3: its area times its depth
    Crowd crowd{};
  };
  struct Below {  // a triangle over a box's edges, where it was looked at
    Corners corner{};
    DepthInBox in{};
    double out = 0.0;           // m^4: what the sum of in.push times the corners' places is when it is out
    double before = 0.0;        // of its depth, what it had before this step
    double inverse_mass = 0.0;  // m^6/kg, of in.push
    double gain = 0.0;          // N s/m^4
  };

  Corners corners_of(Index patch, const ToolFrame& start, const ToolFrame& end, const TouchedParticles& touched);
  bool may_touch(const ShapeIn<double>& shape, const Corners& of, double room) const;
  bool knows_near(const ShapeIn<double>& shape, const ToolFrame& start, const ToolFrame& end,
                  const TouchedParticles& touched) const;
  void find_near(const ShapeIn<double>& shape, const ToolFrame& start, const ToolFrame& end,
                 const TouchedParticles& touched);
  bool is_short(const Corners& of, double thickness) const;
  std::array<Vec3, 3> places(const Corners& of, Vec3 Corner::*place) const {  // of a triangle
    return {corners_[of.row[0]].*place, corners_[of.row[1]].*place, corners_[of.row[2]].*place};
  }
  /// Of a box, as the triangle meets them in this step; empty: it may go through the box.
  std::optional<BoxPlanes> planes_for(const ShapeIn<double>& box, const Corners& of, bool placed) const;
  bool is_before_one_face(const BoxPlanes& box, const Corners& of) const;
  /// Of a point of the patch: the mean of its corners' `from` or `to`.
  Vec3 mean(const ContactPoints::Shares& share, const Corners& of, Vec3 Corner::*place) const;
  void meet(const ShapeIn<double>& shape, const ToolFrame& start, const ToolFrame& end, const TouchedParticles& touched,
            bool placed);
  void find(const ShapeIn<double>& shape, const Corners& of, const ContactPoints::Shares& share, double area);
  void find_points(const ShapeIn<double>& shape, const ContactLaw<double>& law, TouchedParticles& touched);
  double press(const ShapeIn<double>& shape, const ContactLaw<double>& law, const Pressed& point, double dt);
  void look_below(const BoxPlanes& box, const Corners& of, double area, bool comes_out);
  double press_below(const Below& below);
  double press_all(const ShapeIn<double>& shape, const ContactLaw<double>& law, const ToolFrame& start,
                   const ToolFrame& end, TouchedParticles& touched, ToolForce& force);
  void hand_over(double compliance, const ToolFrame& end, const TouchedParticles& touched);
  void rub(double friction, const ToolFrame& end, const TouchedParticles& touched);
  static Vec3 give(Corner& corner, const Vec3& impulse, const Vec3& shift, const ToolFrame& end,
                   const TouchedParticles& touched);

  ContactPoints points_;
  std::vector<Index> corner_of_;  // [N] of corners_, -1: not in this step
  std::vector<Corner> corners_;
  std::vector<Met> met_;
  std::vector<std::size_t> loaded_;  // of corners_: that have had a load in this step
  std::vector<Pressed> pressed_;
  std::vector<Below> below_;

  // Of the last find_near().
  std::vector<Index> near_;          // patches, ascending
  double room_ = 0.0;                // m, that body and tool may use up
  double lever_ = 0.0;               // m: no corner was farther from the tool's position
  ToolFrame then_{ToolPose{}};       // of its step's end
  double gone_ = NAN, going_ = 0.0;  // m, of its step
};

}  // namespace phymul

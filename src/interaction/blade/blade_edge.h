// SPDX-License-Identifier: MIT
//
// The edge of a blade in tissue: points along it hold the tissue that they have reached until the force per length of
// edge is the toughness; then they slide on in it. Cells part as wholes, so that a cut is ahead of the edge by a part
// of a cell: there the edge holds the next tissue that is whole. Impulses on where a step would take the particles,
// each within its limit, point after point, several times over (projected Gauss-Seidel, as in needle_path.h).
#pragma once

#include <phymul/blade.h>
#include <phymul/model.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "interaction/predicted_step.h"
#include "interaction/tool_frame.h"
#include "interaction/tool_shape.h"

namespace phymul {

class BladeEdge {
 public:
  BladeEdge(const Blade& blade, const Model& model);  ///< refers to the model

  /// `force`: what it takes from the particles is added there.
  void act(TouchedParticles& touched, const ToolPose& start, const ToolPose& end, ToolForce& force);
  void accept();      ///< the step counts
  void begin_call();  ///< of steps: the first one looks for tissue

  std::vector<BladePoint> state() const;
  void restore(const std::vector<BladePoint>& state);
  void follow_body();  ///< cells were cut, removed or brought back
  bool holds() const { return !points_.empty(); }
  double reach() const { return longest_; }  ///< m: it looks for tissue so far around

 private:
  /// Barycentric coordinates; in a triangle three, and the distance of a place from it along the edge, in points of it.
  using Weights = Eigen::Vector4d;
  static constexpr double in_site = -1e-9;  // least of them
  static constexpr Index no_place = std::numeric_limits<Index>::max();
  using Key = std::array<Index, 4>;  // places of a cell's vertices, ascending; of a triangle no_place last
  /// A tetrahedron of the mesh at rest, or a triangle of a wall, with all rows that cuts have made of it, whose
  /// vertices are in one order.
  struct Site {
    Index row = -1;
    Key key{};
    double thickness = 0.0;  // m, of a wall
    std::vector<Index> further{};
    std::array<Index, 4> beyond{-1, -1, -1, -1};  // the site across the side opposite each vertex
    std::size_t corners() const { return thickness > 0.0 ? 3 : 4; }
  };
  struct Point {
    Index place = -1;  // along the edge
    Index site = -1;
    Weights front = Weights::Zero();
    double ahead = 0.0;        // m, of the edge
    bool slides = false;       // BladePoint
    Vec3 line = Vec3::Zero();  // in this step
  };
  /// A point in one step.
  struct Acting {
    Vec3 front{0, 0, 0};                                    // m, where the blade wants it at the step's end
    Vec3 way{0, 0, 0};                                      // in which it cuts there
    double limit = 0.0;                                     // N s
    std::vector<std::pair<std::size_t, double>> corners{};  // slots, each once, and weights
    double inverse_mass = 0.0;                              // 1/kg, of the point along the way that it cuts
    double impulse = 0.0;                                   // N s so far
  };

  void build();
  Key key_of(const Cell& cell);
  Index place_of(Index particle);
  Index site_of(const Key& key) const;  // -1: none
  template <class Visit>
  void each_part(const Site& site, Visit visit) const;
  bool has_tissue(const Site& site) const;
  bool is_whole(const Site& site) const;
  using Corners = std::array<Vec3, 4>;
  template <class PlaceOf>
  Corners corners_of(const Site& site, const PlaceOf& place_of) const;
  static double least_of(const Site& site, const Weights& weights);  // not below in_site: it is inside
  /// Of the points of the edge one is in a wall that it crosses: from where it crosses so many points on. Not halves,
  /// so that of a wall half way between two points, as where all is symmetric, one has it and not, by rounding, none.
  static Index points_to(const Weights& weights) { return static_cast<Index>(std::lround(weights[3] - 1e-3)); }
  static bool is_at(const Site& site, const Weights& weights) {
    return site.thickness == 0.0 || (std::abs(weights[3]) < 1.0 && points_to(weights) == 0);
  }
  /// `line`: along the edge; in walls a place is that where this line through x crosses them.
  Weights weights_in(const Site& site, const Corners& corners, const Vec3& x, const Vec3& line) const;
  /// The site that has x at the step's end, from `site` on through tissue; -1: none.
  Index walk(const TouchedParticles& touched, Index site, const Vec3& x, const Vec3& line, Weights& weights) const;
  void go_on(const TouchedParticles& touched, const Vec3& edge, const Vec3& way, Point& point) const;
  void slide(const TouchedParticles& touched, const Vec3& edge, const Vec3& way, double by, Point& point) const;
  double along(Index place) const;  // m, from the middle of the edge
  Vec3 edge_at(const ToolFrame& frame, Index place) const;
  Vec3 way_at(const ToolFrame& frame, Index place) const;
  Vec3 line_at(const ToolFrame& frame, Index place) const;
  double length_in(const TouchedParticles& touched, const Site& site, const Point& point, double of_edge) const;
  void follow_walls(const TouchedParticles& touched, const ToolFrame& end);
  void cut(TouchedParticles& touched, const ToolFrame& end, ToolForce& force);
  bool take_corners(TouchedParticles& touched, const Site& site, const Weights& weights, Acting& acting) const;
  bool has_sides() const { return blade_.height > 0.0 && blade_.friction > 0.0; }
  void lay_out_sides();
  void find_sides(const TouchedParticles& touched, const ToolFrame& end);
  void look_for_sides(const TouchedParticles& touched, const ToolFrame& end);
  void add_sides(std::vector<BladePoint>& state) const;
  void rub(TouchedParticles& touched, const ToolFrame& start, const ToolFrame& end, ToolForce& force);
  void look_around(const TouchedParticles& touched, const Vec3& low, const Vec3& high, double ahead);
  void find_tissue(const TouchedParticles& touched, const ToolFrame& end);
  bool couple(TouchedParticles& touched, const Point& point, const ToolFrame& end, Acting& acting) const;

  Blade blade_;
  BladeCurve curve_;
  const Model& model_;
  double spacing_ = 0.0, longest_ = 0.0;  // m, of the mesh, and its longest edge
  Index count_ = 0;                       // points along the edge
  std::vector<Site> sites_;
  std::map<std::array<double, 3>, Index> place_at_;  // numbers of places at rest: copies are at one
  std::vector<Index> place_of_;                      // [N] of particles as far as they were asked for, else -1
  VecList rest_;                                     // m, by place
  std::vector<std::vector<Index>> sites_at_;         // by place
  Index rows_ = 0;                                   // of Model::cells: behind them are those of cuts alone
  std::vector<Index> site_of_row_;                   // [rows_] at least, -1
  std::vector<Index> divided_;                       // sites with further rows
  std::vector<Point> points_, next_;                 // by place along the edge
  std::vector<Acting> acting_;                       // of next_
  bool looks_ = true;
  std::vector<Index> found_, around_;  // particles, sites
  std::vector<char> is_around_;        // by site
  std::vector<Index> pushed_;          // particles, in this step
  struct Near {
    Index site = -1;
    Corners corners{};  // m, at the step's end
    Vec3 low = Vec3::Constant(HUGE_VAL), high = Vec3::Constant(-HUGE_VAL);
  };
  std::vector<Near> near_;

  /// A point of the sides, in the middle of its part of them.
  struct Side {
    struct Tissue {
      Index site = -1;  // -1: none
      Weights at = Weights::Zero();
    };
    Vec3 place{0, 0, 0}, normal{0, 0, 0};  // m, in the tool's frame
    Tissue now{}, next{};
    Acting acting{};
    Vec3 impulse{0, 0, 0};  // N s so far
  };
  std::vector<Side> sides_;    // column by column along the edge
  std::size_t side_rows_ = 1;  // of a column, from the edge on
};

/// Calls visit(particles) for the rows of the site in which tissue is left.
template <class Visit>
void BladeEdge::each_part(const Site& site, Visit visit) const {
  if (model_.cells[site.row].share > 0.0) visit(model_.cells[site.row].particles);
  for (const Index row : site.further) {
    if (model_.cells[row].share > 0.0) visit(model_.cells[row].particles);
  }
}

/// Means over its parts of their particles, whose places `place_of(particle)` has.
template <class PlaceOf>
BladeEdge::Corners BladeEdge::corners_of(const Site& site, const PlaceOf& place_of) const {
  Corners corners;
  corners.fill(Vec3::Zero());
  double parts = 0.0;
  each_part(site, [&](const std::vector<Index>& particles) {
    for (std::size_t v = 0; v < particles.size(); ++v) corners[v] += place_of(particles[v]);
    parts += 1.0;
  });
  for (Vec3& corner : corners) corner /= parts;
  if (site.thickness > 0.0) corners[3] = corners[0];
  return corners;
}

}  // namespace phymul

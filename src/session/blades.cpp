// SPDX-License-Identifier: MIT
//
// What the blades of a scene cut: cells, and triangles of walls, of whose section with the blade's plane the edge has
// passed the middle.
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "interaction/moved_tool.h"
#include "interaction/tool_frame.h"
#include "interaction/tool_shape.h"
#include "model/cell_geometry.h"
#include "model/cut_cells.h"
#include "simulation_parts.h"

namespace phymul {
namespace {

/// Of a spacing: a particle that is so near to a blade's plane as to a cut of a cell beside it is as near as to the
/// cut, so that strokes go on in older ones and a cut keeps its surface while tissue moves.
constexpr double same_cut = 0.5;
/// Of a spacing: the same where the cut ends at the particle, because tissue that parts can be drawn aside by more.
constexpr double same_front = 1.5;
/// Of distances of a cell's corners from a cut and from a blade: the correlation above which the two are one cut.
constexpr double parallel = 0.8;
/// Of a blade, that are looked at in one call: what is left to later calls becomes less.
constexpr std::size_t most_sweeps = 2;
/// What is one sweep: the edge turns by at most so much, rad, and drifts aside by so many spacings.
constexpr double same_heading = 0.02, same_track = 0.25;

/// Whether the edge goes straight on to there.
bool goes_on(const Snapshot::Sweep& sweep, const ToolPose& to, double spacing) {
  if (sweep.to.orientation.angularDistance(to.orientation) > same_heading) return false;
  const ToolFrame frame(sweep.to);
  const Vec3 way = frame.inside(to.position), back = frame.inside(sweep.from.position);
  const auto drifts = [&](const Vec3& at) { return at.head<2>().norm() > same_track * spacing; };
  return way.z() <= 0.0 && back.z() >= 0.0 && !drifts(way) && !drifts(back);
}

/// The edge of a blade at the end of a sweep, and where it has been since its beginning, along its curve.
class EdgeNow {
 public:
  /// `again`: it has been here before, and tissue that is behind it since then holds it no more.
  EdgeNow(const Blade& blade, const Snapshot::Sweep& sweep, bool again, const Model& model, const BodyEdit& edit,
          const VecList& position, const std::vector<BladePoint>& points)
      : blade_(blade),
        again_(again),
        curve_(blade),
        model_(model),
        edit_(edit),
        points_(points),
        frame_(sweep.to),
        position_(position),
        spacing_(edit.spacing()),
        place_(position.size(), Vec3::Constant(NAN)),
        distance_(position.size(), NAN),
        beyond_(position.size(), unknown) {
    const ToolFrame before(sweep.from);
    for (const double share : {-0.5, 0.0, 0.5}) {
      const Vec3 edge = curve_.unrolled(frame_.inside(before.outside(curve_.at(share * curve_.length()))));
      behind_ = std::max(behind_, edge.z());
    }
    behind_ += spacing_;
  }

  /// Rows of cells that its plane crosses around it and whose middle it can have passed, ascending.
  std::vector<Index> cells() const {
    const std::vector<unsigned char> sides = sides_of_all();
    std::vector<Index> found;
    for (Index row = 0; row < static_cast<Index>(edit_.corners().size()); ++row) {
      const BodyEdit::Corners& own = edit_.corners()[row];
      if (own[0] < 0 || (own[1] >= 0 && (sides[own[0]] & sides[own[1]] & sides[own[2]] & sides[own[3]]) != 0)) continue;
      const Cell& cell = model_.cells[row];
      unsigned beyond = unknown;  // sides that all its particles are beyond
      for (const Index k : cell.particles) beyond &= sides_beyond(k);
      if (beyond != 0 || cell.share == 0.0 || is_cut_here(cell)) continue;
      double first = HUGE_VAL, last = -HUGE_VAL;
      for (const Index k : cell.particles) {
        first = std::min(first, distance(k));
        last = std::max(last, distance(k));
      }
      if (first <= 0.0 && last >= 0.0) found.push_back(row);
    }
    return found;
  }

  double distance(Index i) const {
    if (std::isnan(distance_[i])) distance_[i] = found_distance(i);
    return distance_[i];
  }

  static constexpr double ahead = -HUGE_VAL;
  /// m, by which the middle of a cell's section is behind the edge; `ahead`: the edge has not passed it.
  double behind(Index row, const Eigen::Vector4d& middle) const {
    Vec3 q = Vec3::Zero();
    const std::vector<Index>& particles = model_.cells[row].particles;
    for (std::size_t v = 0; v < particles.size(); ++v) q += middle[static_cast<Eigen::Index>(v)] * place(particles[v]);
    const bool passed = std::abs(q.x()) < 0.5 * curve_.length() && q.z() > -lead_of_front * spacing_ &&
                        q.z() < behind_ && std::abs(q.y()) < same_front * spacing_ && overcomes(q);
    return passed ? q.z() : ahead;
  }

  /// Those of `cells` that it has passed, first the ones farthest behind.
  std::vector<Index> passed_first(const std::vector<Index>& cells) const {
    std::vector<std::pair<double, Index>> order;
    for (const Index row : cells) {
      const std::vector<Index>& particles = model_.cells[row].particles;
      CellCut cut{};
      std::ranges::transform(particles, cut.begin(), [&](Index i) { return distance(i); });
      const auto middle = middle_of_section(cut, particles.size());
      const double way = middle ? behind(row, *middle) : ahead;
      if (way > ahead) order.emplace_back(-way, row);
    }
    std::ranges::sort(order);
    std::vector<Index> found;
    for (const auto& [way, row] : order) found.push_back(row);
    return found;
  }

 private:
  /// m, as BladeCurve::unrolled().
  const Vec3& place(Index i) const {
    if (std::isnan(place_[i].x())) place_[i] = curve_.unrolled(frame_.inside(position_[i]));
    return place_[i];
  }

  /// [N] one bit a side: of a box that has all that sides_beyond() looks at, without unrolling an arc.
  std::vector<unsigned char> sides_of_all() const {
    Blade edge = blade_;
    edge.height = 0.0;
    const ToolExtent extent = extent_of({.shape = edge});
    // A place in a tetrahedron is within sqrt(3/8) of its longest edge of a corner (Jung's theorem); the rest of the
    // edge is for cells that are stretched.
    const double around = edit_.longest_edge();
    const Vec3 low = extent.low.array() - around, high = extent.high + Vec3(around, around, behind_ + around);
    std::vector<unsigned char> sides(position_.size());
    for (std::size_t i = 0; i < sides.size(); ++i) sides[i] = beyond(low, high, frame_.inside(position_[i]));
    return sides;
  }

  static unsigned char beyond(const Vec3& low, const Vec3& high, const Vec3& at) {
    unsigned sides = 0;
    for (int a = 0; a < 3; ++a) sides |= (at[a] < low[a] ? 1U : 0U) << a | (at[a] > high[a] ? 8U : 0U) << a;
    return static_cast<unsigned char>(sides);
  }

  /// Of the box that cells must reach into, one bit a side. Without the cuts around, which can move the plane by a few
  /// spacings.
  unsigned sides_beyond(Index i) const {
    if (beyond_[i] != unknown) return beyond_[i];
    const Vec3 low(-0.5 * curve_.length(), -same_front * spacing_, -lead_of_front * spacing_);
    const Vec3 high(0.5 * curve_.length(), same_front * spacing_, behind_);
    return beyond_[i] = beyond(low, high, place(i));
  }

  /// Whether tissue at this place has got all the force that it can bear; or the edge has gone by and holds none there,
  /// because it comes out of the body.
  bool overcomes(const Vec3& at) const {
    if (blade_.toughness == 0.0 || (again_ && at.z() > same_cut * spacing_)) return true;
    const BladePoint* nearest = nullptr;
    for (const BladePoint& point : points_) {
      if (point.ahead < 0.0) continue;  // of the sides
      const double apart = std::abs(point.along - at.x());
      if (apart < spacing_ && (nearest == nullptr || apart < std::abs(nearest->along - at.x()))) nearest = &point;
    }
    return nearest == nullptr ? at.z() > 0.0 : nearest->slides;
  }

  /// m, of the particles of a cell with cuts from the blade's plane; of a triangle 0 in the last place, as in its cuts.
  Eigen::Vector4d distances(const Cell& cell) const {
    Eigen::Vector4d own = Eigen::Vector4d::Zero();
    for (std::size_t v = 0; v < cell.particles.size(); ++v) {
      own[static_cast<Eigen::Index>(v)] = place(cell.particles[v]).y();
    }
    return own;
  }

  /// Whether a cut of the cell is this one, although tissue has moved since.
  bool is_cut_here(const Cell& cell) const {
    if (cell.cuts.empty()) return false;
    const Eigen::Vector4d own = distances(cell);
    return std::ranges::any_of(cell.cuts, [&](const CellCut& cut) {
      const Eigen::Vector4d values(cut.data());
      const double product = values.dot(own);
      return product * product > parallel * parallel * values.squaredNorm() * own.squaredNorm();
    });
  }

  /// Whether the cuts of a cell end at a particle: it belongs to both parts of the cell.
  bool ends_at(Index i, Index row) const {
    const Vec3 centre = cell_centre(model_.cells[row], model_.rest);
    return std::ranges::any_of(edit_.cells_of()[i], [&](Index other) {
      return other != row && !model_.cells[other].cuts.empty() &&
             cell_centre(model_.cells[other], model_.rest) == centre;
    });
  }

  double found_distance(Index i) const {
    const double own = place(i).y();
    double nearest = 1.0, of_cut = own;
    for (const Index row : edit_.cells_of()[i]) {
      const Cell& cell = model_.cells[row];
      if (cell.cuts.empty()) continue;
      const Eigen::Vector4d y = distances(cell), corners(1.0, 1.0, 1.0, cell.particles.size() == 4 ? 1.0 : 0.0);
      for (const CellCut& cut : cell.cuts) {
        const Eigen::Vector4d values(cut.data());
        const std::ptrdiff_t at = std::ranges::find(cell.particles, i) - cell.particles.begin();
        const double value = values.dot(y) < 0.0 ? -values[at] : values[at];
        const double off = std::abs(value - own) / spacing_;
        // Both without their means: how they are inclined.
        const Eigen::Vector4d a = values - values.sum() / corners.sum() * corners;
        const Eigen::Vector4d b = y - y.sum() / corners.sum() * corners;
        const bool same = off > same_cut && off < same_front && std::abs(a.dot(b)) > parallel * a.norm() * b.norm() &&
                          ends_at(i, row);
        const double share = off / (same ? same_front : same_cut);
        if (share >= nearest) continue;
        nearest = share;
        of_cut = value;
      }
    }
    if (nearest < 1.0) return of_cut;
    return is_at_the_surface(i, own) ? 0.0 : own;
  }

  bool is_at_the_surface(Index i, double own) const {
    for (const Index row : edit_.cells_of()[i]) {
      for (const Index j : model_.cells[row].particles) {
        if (j != i && !(std::abs(own) < on_cut_surface * (model_.rest[i] - model_.rest[j]).norm())) return false;
      }
    }
    return true;
  }

  const Blade& blade_;
  const bool again_;
  const BladeCurve curve_;
  const Model& model_;
  const BodyEdit& edit_;
  const std::vector<BladePoint>& points_;
  const ToolFrame frame_;
  const VecList& position_;  // [N] m
  const double spacing_;
  double behind_ = 0.0;  // m, that the edge may have gone since the last time
  static constexpr unsigned char unknown = 0xff;
  mutable VecList place_;                      // [N] m, NaN: not asked for yet
  mutable std::vector<double> distance_;       // [N] m, likewise
  mutable std::vector<unsigned char> beyond_;  // [N] sides_beyond()
};

}  // namespace

void Simulation::Parts::cut_with_blades(StepReport& report) {
  if (report.steps == 0) return;  // a blade that was teleported is not there yet
  std::vector<Snapshot::Sweep> left;
  for (const SceneTool& tool : scene.tools()) {
    if (!std::holds_alternative<Blade>(tool.tool.shape)) continue;
    const SeenBlade seen{solver().tool_pose(tool.name), tool.places};
    const auto known = blades_seen.try_emplace(tool.id, SeenBlade{first_pose(tool), tool.places});
    const SeenBlade last = std::exchange(known.first->second, seen);
    std::vector<Snapshot::Sweep> own;
    std::ranges::copy_if(sweeps, std::back_inserter(own), [&](const auto& sweep) { return sweep.tool == tool.name; });
    const std::size_t before = own.size();
    const bool teleported = last.places != seen.places;  // then it has passed nothing before
    if (before > 0 && !teleported && goes_on(own.back(), seen.pose, body_edit().spacing())) {
      own.back().to = seen.pose;
    } else {
      own.push_back({tool.name, teleported ? tool.pose : last.pose, seen.pose});
    }
    auto most = options.tick_budget > 0 ? static_cast<std::size_t>(options.tick_budget) : SIZE_MAX;
    std::size_t done = 0, later = 0;
    while (done < std::min(own.size(), most_sweeps) && most > 0) {
      later = cut_along(tool, own[done], done < before, most, report);
      if (later > 0) break;
      ++done;
    }
    left.insert(left.end(), own.begin() + static_cast<std::ptrdiff_t>(done), own.end());
    report.cut_later += static_cast<int>(std::max(later, own.size() - done));
  }
  sweeps = std::move(left);
}

std::size_t Simulation::Parts::cut_along(const SceneTool& tool, const Snapshot::Sweep& sweep, bool again,
                                         std::size_t& most, StepReport& report) {
  const State now = solver().read();
  const auto own = std::ranges::find(now.tools, tool.name, &ToolState::name);
  if (own == now.tools.end()) return 0;
  const EdgeNow edge(std::get<Blade>(tool.tool.shape), sweep, again, model, body_edit(), now.position, own->blade);
  std::vector<Index> cells = edge.cells();
  if (keeps_body()) {
    report.uncut += static_cast<int>(cells.size());
    return 0;
  }
  if (most < cells.size()) cells = edge.passed_first(cells);
  std::size_t refused = 0, later = 0;
  BodyCut found = body_edit().find_cut(
      {.cells = cells,
       .distance = [&](Index i) { return edge.distance(i); },
       .passed = [&](Index row, const auto& middle) { return edge.behind(row, middle) > edge.ahead; },
       .who = "the blade",
       .refused = &refused,
       .most = most,
       .later = &later});
  // Where there is no room for a part of them, there is none for the others.
  if (found.empty()) refused += std::exchange(later, 0);
  report.uncut += static_cast<int>(refused);
  if (found.empty()) return 0;
  const std::size_t parted = cells.size() - refused - later;
  most -= std::min(most, parted);
  make_cut(std::move(found), parted, report);
  return later;
}

}  // namespace phymul

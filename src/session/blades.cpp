// SPDX-License-Identifier: MIT
//
// What the blades of a scene cut: cells, and triangles of walls, of whose section with the blade's plane the edge has
// passed the middle.
#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
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
/// The edge of a blade at one instant, and where it has been since the last time, along its curve.
class EdgeNow {
 public:
  EdgeNow(const Blade& blade, const ToolPose& pose, const ToolPose& last, const Model& model, const BodyEdit& edit,
          const std::vector<Snapshot::CutLater>& waiting, const VecList& position,
          const std::vector<BladePoint>& points)
      : blade_(blade),
        curve_(blade),
        model_(model),
        edit_(edit),
        points_(points),
        frame_(pose),
        position_(position),
        spacing_(edit.spacing()),
        place_(position.size(), Vec3::Constant(NAN)),
        distance_(position.size(), NAN),
        beyond_(position.size(), unknown) {
    for (const auto& [cell, cut] : waiting) waiting_.emplace(cell, cut);
    const ToolFrame before(last);
    for (const double share : {-0.5, 0.0, 0.5}) {
      const Vec3 edge = curve_.unrolled(frame_.inside(before.outside(curve_.at(share * curve_.length()))));
      behind_ = std::max(behind_, edge.z());
    }
    behind_ += spacing_;
  }

  /// Rows of cells that its plane crosses around it and whose middle it can have passed, ascending.
  std::vector<Index> cells() const {
    Blade edge = blade_;
    edge.height = 0.0;
    const ToolExtent extent = extent_of({.shape = edge});
    // A place in a tetrahedron is within sqrt(3/8) of its longest edge of a corner (Jung's theorem); the rest of the
    // edge is for cells that are stretched.
    const double around = edit_.longest_edge();
    const Vec3 low = extent.low.array() - around, high = extent.high + Vec3(around, around, behind_ + around);
    const Vec3 middle = frame_.outside(0.5 * (low + high));
    const double reach = 0.5 * (high - low).norm();
    std::vector<Index> found;
    std::vector<char> seen(model_.cells.size(), 0);
    for (std::size_t i = 0; i < position_.size(); ++i) {
      if (!((position_[i] - middle).squaredNorm() < reach * reach)) continue;
      const Vec3 q = frame_.inside(position_[i]);
      if ((q.array() < low.array()).any() || (q.array() > high.array()).any()) continue;
      for (const Index row : edit_.cells_of()[i]) {
        if (std::exchange(seen[row], 1) != 0) continue;
        const Cell& cell = model_.cells[row];
        unsigned beyond = unknown;  // sides that all its particles are beyond
        for (const Index k : cell.particles) beyond &= sides_beyond(k);
        if (beyond != 0 || cell.share == 0.0 || is_cut_here(row)) continue;
        double first = HUGE_VAL, last = -HUGE_VAL;
        for (const Index k : cell.particles) {
          first = std::min(first, distance(k));
          last = std::max(last, distance(k));
        }
        if (first <= 0.0 && last >= 0.0) found.push_back(row);
      }
    }
    std::ranges::sort(found);
    return found;
  }

  double distance(Index i) const {
    if (std::isnan(distance_[i])) distance_[i] = found_distance(i);
    return distance_[i];
  }

  bool passed(Index row, const Eigen::Vector4d& middle) const {
    const Vec3 q = at(row, middle);
    return std::abs(q.x()) < 0.5 * curve_.length() && q.z() > -lead_of_front * spacing_ && q.z() < behind_ &&
           std::abs(q.y()) < same_front * spacing_ && overcomes(q);
  }

  /// Adds those of `cells` that it has passed, with their cuts, first the ones farthest behind. How many cannot part:
  /// cut too often, or neither tetrahedra nor of walls, or beside such a cell.
  int add_passed(const std::vector<Index>& cells, std::vector<Snapshot::CutLater>& to) const {
    int refused = 0;
    std::vector<std::pair<double, Snapshot::CutLater>> passed_cells;
    for (const Index row : cells) {
      const std::vector<Index>& particles = model_.cells[row].particles;
      CellCut cut{};
      if (particles.size() > cut.size()) {
        ++refused;
        continue;
      }
      std::ranges::transform(particles, cut.begin(), [&](Index i) { return distance(i); });
      const auto middle = middle_of_section(cut, particles.size());
      if (!middle || !passed(row, *middle)) continue;
      if (std::ranges::any_of(particles, [&](Index i) { return is_beside_others(i); })) {
        ++refused;
        continue;
      }
      const std::vector<CellCut>& before = model_.cells[row].cuts;
      if (!before.empty() && divides(cut)) {
        std::vector<CellCut> all = before;
        all.push_back(cut);
        const double share = tissue_share(all, particles.size()) / tissue_share(before, particles.size());
        if (share < no_share || share > 1.0 - no_share) continue;  // what is left of it lies on one side
        if (std::ranges::count_if(before, divides) >= static_cast<std::ptrdiff_t>(most_cuts_of_cell)) {
          ++refused;
          continue;
        }
      }
      passed_cells.push_back({-at(row, *middle).z(), {row, cut}});
    }
    std::ranges::sort(passed_cells, {}, [](const auto& own) { return std::pair(own.first, own.second.cell); });
    for (const auto& [way, own] : passed_cells) to.push_back(own);
    return refused;
  }

 private:
  /// m, as place(): of a point of a cell.
  Vec3 at(Index row, const Eigen::Vector4d& weights) const {
    Vec3 q = Vec3::Zero();
    const std::vector<Index>& particles = model_.cells[row].particles;
    for (std::size_t v = 0; v < particles.size(); ++v) q += weights[static_cast<Eigen::Index>(v)] * place(particles[v]);
    return q;
  }

  /// Whether cells there are neither tetrahedra nor of walls. A particle is copied for all cells around it.
  bool is_beside_others(Index i) const {
    return std::ranges::any_of(edit_.cells_of()[i], [&](Index row) {
      return model_.cells[row].share > 0.0 && model_.cells[row].particles.size() > std::tuple_size_v<CellCut>;
    });
  }

  /// Calls visit(CellCut) for the cuts that a cell has, and those that it waits for.
  template <class Visit>
  void each_cut(Index row, const Visit& visit) const {
    for (const CellCut& cut : model_.cells[row].cuts) visit(cut);
    const auto [first, end] = waiting_.equal_range(row);
    for (auto own = first; own != end; ++own) visit(own->second);
  }

  /// m, as BladeCurve::unrolled().
  const Vec3& place(Index i) const {
    if (std::isnan(place_[i].x())) place_[i] = curve_.unrolled(frame_.inside(position_[i]));
    return place_[i];
  }

  /// Of the box that cells must reach into, one bit a side. Without the cuts around, which can move the plane by a few
  /// spacings.
  unsigned sides_beyond(Index i) const {
    if (beyond_[i] != unknown) return beyond_[i];
    const Vec3 low(-0.5 * curve_.length(), -same_front * spacing_, -lead_of_front * spacing_);
    const Vec3 high(0.5 * curve_.length(), same_front * spacing_, behind_);
    unsigned sides = 0;
    for (int a = 0; a < 3; ++a) sides |= (place(i)[a] < low[a] ? 1U : 0U) << a | (place(i)[a] > high[a] ? 8U : 0U) << a;
    return beyond_[i] = static_cast<unsigned char>(sides);
  }

  /// Whether tissue at this place has got all the force that it can bear; or the edge has gone by and holds none there,
  /// because it comes out of the body.
  bool overcomes(const Vec3& at) const {
    if (blade_.toughness == 0.0) return true;
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
  bool is_cut_here(Index row) const {
    if (model_.cells[row].cuts.empty() && !waiting_.contains(row)) return false;
    const Eigen::Vector4d own = distances(model_.cells[row]);
    bool found = false;
    each_cut(row, [&](const CellCut& cut) {
      const Eigen::Vector4d values(cut.data());
      const double product = values.dot(own);
      found = found || product * product > parallel * parallel * values.squaredNorm() * own.squaredNorm();
    });
    return found;
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
      if (cell.cuts.empty() && !waiting_.contains(row)) continue;
      const Eigen::Vector4d y = distances(cell), corners(1.0, 1.0, 1.0, cell.particles.size() == 4 ? 1.0 : 0.0);
      each_cut(row, [&](const CellCut& cut) {
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
        if (share >= nearest) return;
        nearest = share;
        of_cut = value;
      });
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
  const BladeCurve curve_;
  const Model& model_;
  const BodyEdit& edit_;
  const std::vector<BladePoint>& points_;
  const ToolFrame frame_;
  const VecList& position_;  // [N] m
  const double spacing_;
  std::unordered_multimap<Index, CellCut> waiting_;
  double behind_ = 0.0;  // m, that the edge may have gone since the last time
  static constexpr unsigned char unknown = 0xff;
  mutable VecList place_;                      // [N] m, NaN: not asked for yet
  mutable std::vector<double> distance_;       // [N] m, likewise
  mutable std::vector<unsigned char> beyond_;  // [N] sides_beyond()
};

}  // namespace

void Simulation::Parts::cut_with_blades(StepReport& report) {
  if (report.steps == 0) return;  // a blade that was teleported is not there yet
  for (const SceneTool& tool : scene.tools()) {
    const auto* const blade = std::get_if<Blade>(&tool.tool.shape);
    if (blade == nullptr) continue;
    const State now = solver().read();
    const auto own = std::ranges::find(now.tools, tool.name, &ToolState::name);
    if (own == now.tools.end()) continue;
    const SeenBlade seen{solver().tool_pose(tool.name), tool.places};
    const auto known = blades_seen.try_emplace(tool.id, SeenBlade{first_pose(tool), tool.places});
    const SeenBlade last = std::exchange(known.first->second, seen);
    // One that was teleported has passed nothing before.
    const EdgeNow edge(*blade, seen.pose, last.places == seen.places ? last.pose : tool.pose, model, body_edit(),
                       waiting, now.position, own->blade);
    const std::vector<Index> cells = edge.cells();
    if (keeps_body()) {
      report.uncut += static_cast<int>(cells.size());
      continue;
    }
    if (options.tick_budget > 0) {
      report.uncut += edge.add_passed(cells, waiting);
      continue;
    }
    std::size_t refused = 0;
    BodyCut found =
        body_edit().find_cut({.cells = cells,
                              .distance = [&](Index i) { return edge.distance(i); },
                              .passed = [&](Index row, const auto& middle) { return edge.passed(row, middle); },
                              .who = "the blade",
                              .refused = &refused});
    report.uncut += static_cast<int>(refused);
    if (!found.empty()) make_cut(std::move(found), cells.size() - refused, report);
  }
  if (!waiting.empty()) cut_waiting(report);
}

void Simulation::Parts::cut_waiting(StepReport& report) {
  const std::size_t most = options.tick_budget > 0 ? static_cast<std::size_t>(options.tick_budget) : SIZE_MAX;
  std::vector<Index> cells;
  std::unordered_map<Index, double> distance;  // m, by particle
  // One surface, with one distance of each particle: another one waits for the next call.
  const auto fits = [&](const Snapshot::CutLater& own) {
    const std::vector<Index>& particles = model.cells[own.cell].particles;
    for (std::size_t v = 0; v < particles.size(); ++v) {
      const auto known = distance.find(particles[v]);
      if (known != distance.end() && !(std::abs(known->second - own.cut[v]) < same_cut * body_edit().spacing())) {
        return false;
      }
    }
    return std::ranges::find(cells, own.cell) == cells.end();
  };
  std::size_t taken = 0, refused = 0;
  for (; taken < waiting.size() && cells.size() < most && fits(waiting[taken]); ++taken) {
    const auto& [row, cut] = waiting[taken];
    const Cell& cell = model.cells[row];
    if (cell.share == 0.0) continue;  // removed since
    for (std::size_t v = 0; v < cell.particles.size(); ++v) distance.try_emplace(cell.particles[v], cut[v]);
    cells.push_back(row);
  }
  std::vector<Snapshot::CutLater> kept = waiting;
  waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(taken));
  std::ranges::sort(cells);
  try {
    BodyCut found = body_edit().find_cut({.cells = cells,
                                          .distance = [&](Index i) { return distance.at(i); },
                                          .passed = [](Index, const auto&) { return true; },
                                          .who = "the blade",
                                          .refused = &refused});
    if (!found.empty()) {
      report.uncut += static_cast<int>(refused);
      make_cut(std::move(found), cells.size() - refused, report);
    } else if (refused > 0) {  // as the others would be
      report.uncut += static_cast<int>(refused + std::exchange(waiting, {}).size());
    }
  } catch (...) {
    waiting = std::move(kept);
    throw;
  }
}

/// What a cut has parted waits for its other cuts with both parts.
void Simulation::Parts::follow_waiting(const BodyCuts& before) {
  const auto cells = static_cast<Index>(model.cells.size());
  std::erase_if(waiting, [&](const Snapshot::CutLater& own) { return own.cell >= cells; });
  const BodyCuts& cuts = topology->cuts;
  const auto first = std::ranges::mismatch(before, cuts).in2;
  Index row = cells;
  for (auto cut = first; cut != cuts.end(); ++cut) row -= static_cast<Index>((*cut)->added.size());
  for (auto cut = first; cut != cuts.end(); ++cut) {
    for (const BodyCut::Added& added : (*cut)->added) {
      for (std::size_t k = 0, count = waiting.size(); k < count; ++k) {
        if (waiting[k].cell == added.of) waiting.push_back({row, waiting[k].cut});
      }
      ++row;
    }
  }
}

}  // namespace phymul

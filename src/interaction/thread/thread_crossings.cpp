// SPDX-License-Identifier: MIT
#include "thread_crossings.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace phymul {
namespace {

/// Of an overlap at the step's start, that comes out in the step: all of it would fling the threads.
constexpr double parted_at_a_time = 0.1;
/// Of the sum of radii: so much farther apart two segments may still be and count, since what moves others moves them.
constexpr double beside_share = 0.25;
/// Of the sum of radii: by so little less they may be apart after the last iteration.
constexpr double met_share = 1e-3;
/// Of the sum of radii: a place of one segment that came so near to one of the other had to stop where it came in,
/// unless it went round by less than the angle of this cosine.
constexpr double through_share = 0.9, round_share = 0.5;
/// Of the sum of radii: a vector that is shorter has no direction.
constexpr double tiny_share = 1e-6;
/// Squared sine of an angle, below which two segments lie along each other.
constexpr double along_each_other = 0.05;
constexpr int most_sweeps = 100;
/// Of the largest force: sweeps that change forces by less are the last ones.
constexpr double swept_share = 1e-6;

/// Shares of the places of two segments that are closest to each other (C. Ericson, Real-Time Collision Detection,
/// 2005, 5.1.9). `apart`: from the second one's first node to the first one's.
std::array<double, 2> closest_shares(const Vec3& d1, const Vec3& d2, const Vec3& apart) {
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), b = d1.dot(d2), c = d1.dot(apart), f = d2.dot(apart);
  if (!(a > 0.0)) return {0.0, e > 0.0 ? std::clamp(f / e, 0.0, 1.0) : 0.0};
  if (!(e > 0.0)) return {std::clamp(-c / a, 0.0, 1.0), 0.0};
  const double whole = a * e - b * b;
  const double s = whole > 0.0 ? std::clamp((b * f - c * e) / whole, 0.0, 1.0) : 0.0;
  const double t = (b * s + f) / e;
  if (t < 0.0) return {std::clamp(-c / a, 0.0, 1.0), 0.0};
  if (t > 1.0) return {std::clamp((b - c) / a, 0.0, 1.0), 1.0};
  return {s, t};
}

/// m: how near to 0 a point comes between two places.
double nearest_between(const Vec3& from, const Vec3& to) {
  const Vec3 way = to - from;
  const double squared = way.squaredNorm();
  const double share = squared > 0.0 ? std::clamp(-from.dot(way) / squared, 0.0, 1.0) : 0.0;
  return (from + share * way).norm();
}

/// The direction in which a point that comes nearer than `least` to 0 between two places first does.
Vec3 entry(const Vec3& from, const Vec3& to, double least) {
  const Vec3 way = to - from;
  const double a = way.squaredNorm(), b = from.dot(way), c = from.squaredNorm() - least * least;
  const double root = b * b - a * c;
  const double share = c > 0.0 && a > 0.0 && root > 0.0 ? std::clamp((-b - std::sqrt(root)) / a, 0.0, 1.0) : 0.0;
  return (from + share * way).normalized();
}

}  // namespace

/// Of neighbouring pairs that have the place where a segment begins in common, one has it.
bool ThreadCrossings::has_before(const Pair& pair, std::size_t side) const {
  const Strand& strand = strands_[pair.strand[side]];
  const Index before = pair.segment[side] - 1;
  if (before < 0 || strand.rod->is_broken(before)) return false;
  return side == 0 || pair.strand[0] != pair.strand[1] || !is_neighbour(strand, pair.segment[0], before);
}

/// Appends where two segments touch after the last iteration, or did at the step's start.
void ThreadCrossings::measure(std::size_t number, std::vector<Cross>& found) const {
  const Pair& pair = near_[number];
  const Strand &one = strands_[pair.strand[0]], &other = strands_[pair.strand[1]];
  const Index p = pair.segment[0], q = pair.segment[1];
  const double least = one.radius + other.radius;
  // Starts, and ways, of both nodes of each.
  const Vec3 &x0 = one.rod->place(p), &x1 = one.rod->place(p + 1), &y0 = other.rod->place(q),
             &y1 = other.rod->place(q + 1);
  const Vec3 u0 = one.rod->way(p), u1 = one.rod->way(p + 1), v0 = other.rod->way(q), v1 = other.rod->way(q + 1);
  const Vec3 from0 = x0 - y0, dx = x1 - x0, dy = y1 - y0;
  const Vec3 to0 = from0 + (u0 - v0), ex = dx + (u1 - u0), ey = dy + (v1 - v0);
  {
    const Vec3 from = from0 + 0.5 * (dx - dy), to = to0 + 0.5 * (ex - ey);
    const double halves = 0.5 * (ex.norm() + ey.norm() + (ex - dx).norm() + (ey - dy).norm());
    const double near = halves + (1.0 + beside_share) * least + (to - from).norm();
    if (to.squaredNorm() > near * near) return;
  }
  if (one.rod->is_broken(p) || other.rod->is_broken(q)) return;
  const auto [s0, t0] = closest_shares(dx, dy, from0);
  const double at_start = (from0 + s0 * dx - t0 * dy).norm();
  if (!(at_start > 0.0)) return;  // on no side of each other
  const double left = (1.0 - parted_at_a_time) * std::max(0.0, least - at_start);
  std::array<std::array<double, 2>, 2> places{closest_shares(ex, ey, to0)};
  std::size_t count = 1;
  const double crossed = ex.cross(ey).squaredNorm(), product = ex.squaredNorm() * ey.squaredNorm();
  const bool is_along = !(crossed > along_each_other * product);
  if (is_along && product > 0.0) {
    double low = -to0.dot(ex) / ex.squaredNorm(), high = (ey - to0).dot(ex) / ex.squaredNorm();
    if (low > high) std::swap(low, high);
    low = std::max(low, 0.0);
    high = std::min(high, 1.0);
    if (low < high) {
      count = 0;
      for (const double s : {low, high}) {
        places[count++] = {s, std::clamp((to0 + s * ex).dot(ey) / ey.squaredNorm(), 0.0, 1.0)};
      }
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    const auto [s, t] = places[k];
    if ((s == 0.0 && has_before(pair, 0)) || (t == 0.0 && has_before(pair, 1))) continue;
    const Vec3 from = from0 + s * dx - t * dy, to = to0 + s * ex - t * ey;
    const double length = to.norm(), started = from.norm();
    const bool is_crossed = !is_along && s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0;
    Cross cross{.pair = number, .place = static_cast<int>(k), .share = {s, t}};
    if (!(started > 0.0)) continue;
    if (is_crossed && length > tiny_share * least) {
      cross.normal = (from.dot(to) < 0.0 ? -1.0 : 1.0) / length * to;
    } else {
      cross.normal = entry(from, to, least);
      const bool went_round = cross.normal.dot(to) > round_share * length ||
                              !(nearest_between(from, to) < through_share * std::min(least, started));
      if (length > tiny_share * least && went_round) cross.normal = to / length;
    }
    cross.missing = least - left - cross.normal.dot(to);
    if (cross.missing < -beside_share * least) continue;
    cross.need = cross.normal.dot(to - from) + cross.missing;
    cross.compliance = 1.0 / std::min(one.stiffest, other.stiffest);
    cross.friction = std::sqrt(one.friction * other.friction);
    found.push_back(cross);
  }
}

Vec3 ThreadCrossings::way(const Cross& cross) const {
  Vec3 sum = Vec3::Zero();
  for (const std::size_t side : {0, 1}) {
    const ThreadRod& rod = *strands_[near_[cross.pair].strand[side]].rod;
    const ThreadRod::Point at{near_[cross.pair].segment[side], cross.share[side]};
    const Vec3 own = at.weight(0) * rod.way(at.segment) + at.weight(1) * rod.way(at.segment + 1);
    sum += side == 0 ? own : Vec3(-own);
  }
  return sum;
}

bool ThreadCrossings::update() {
  bool changes = false;
  before_.swap(crosses_);
  crosses_.clear();
  for (std::size_t pair = first_; pair < end_; ++pair) measure(pair, crosses_);
  auto known = before_.begin();
  const auto order = [](const Cross& cross) { return std::pair(cross.pair, cross.place); };
  for (Cross& cross : crosses_) {
    while (known != before_.end() && order(*known) < order(cross)) ++known;
    if (known != before_.end() && order(*known) == order(cross)) cross.force = known->force;
    const auto& strand = near_[cross.pair].strand;
    const double least = strands_[strand[0]].radius + strands_[strand[1]].radius;
    changes = changes || cross.missing > met_share * least + cross.compliance * cross.force.norm();
  }
  return changes;
}

/// Gauss and Seidel's sweeps over the crossings, each of which takes the force that its own way asks for: none along
/// the normal that draws them together, and none across that is above Coulomb's.
void ThreadCrossings::find_forces() {
  const std::size_t count = crosses_.size();
  ways_.clear();
  for (const Cross& cross : crosses_) ways_.push_back(way(cross));
  const auto change = [&](std::size_t c, const Vec3& by) {
    for (std::size_t k = 0; k < count; ++k) ways_[k] += answers_[k * count + c] * by;
  };
  for (std::size_t c = 0; c < count; ++c) {
    if (crosses_[c].force != Vec3::Zero()) change(c, crosses_[c].force);
  }
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double most = 0.0, changed = 0.0;
    for (std::size_t c = 0; c < count; ++c) {
      Cross& cross = crosses_[c];
      const Mat3& own = answers_[c * count + c];
      const Vec3 &n = cross.normal, before = cross.force;
      const double press = n.dot(before);
      const double missing = cross.need - n.dot(ways_[c]) - cross.compliance * press;
      const double now = std::max(0.0, press + missing / (n.dot(own * n) + cross.compliance));
      Vec3 across = Vec3::Zero();
      const double limit = cross.friction * now;
      if (limit > 0.0) {
        const Vec3 t = n.unitOrthogonal(), b = n.cross(t);
        Eigen::Matrix<double, 3, 2> plane;
        plane << t, b;
        const Eigen::Vector2d had = plane.transpose() * before;
        const Eigen::Vector2d slid =
            plane.transpose() * (ways_[c] + (now - press) * (own * n)) + cross.compliance * had;
        const Eigen::Matrix2d answer = plane.transpose() * own * plane + cross.compliance * Eigen::Matrix2d::Identity();
        Eigen::Vector2d wanted = had - answer.inverse() * slid;
        if (wanted.norm() > limit) {
          wanted = had - slid / answer.trace();
          if (wanted.norm() > limit) wanted *= limit / wanted.norm();
        }
        across = plane * wanted;
      }
      cross.force = now * n + across;
      const Vec3 by = cross.force - before;
      if (by != Vec3::Zero()) change(c, by);
      most = std::max(most, cross.force.norm());
      changed = std::max(changed, by.norm());
    }
    if (!(changed > swept_share * most)) break;
  }
}

void ThreadCrossings::couple() {
  if (crosses_.empty()) return;
  const std::size_t count = crosses_.size();
  columns_.resize(std::max(columns_.size(), count));
  const auto point = [&](const Cross& cross, std::size_t side) {
    return ThreadRod::Point{near_[cross.pair].segment[side], cross.share[side]};
  };
  for (std::size_t c = 0; c < count; ++c) {
    const Cross& cross = crosses_[c];
    const auto& strand = near_[cross.pair].strand;
    const ThreadRod::Point first = point(cross, 0), second = point(cross, 1);
    const bool is_self = strand[0] == strand[1];
    strands_[strand[0]].rod->respond(first, is_self ? &second : nullptr, columns_[c][0].response);
    columns_[c][0].strand = strand[0];
    columns_[c][1].strand = strand[1];
    if (is_self) {
      columns_[c][1].response.clear();
    } else {
      strands_[strand[1]].rod->respond(second, nullptr, columns_[c][1].response);
    }
  }
  answers_.assign(count * count, Mat3::Zero());
  for (std::size_t c = 0; c < count; ++c) {
    const auto& strand = near_[crosses_[c].pair].strand;
    for (const std::size_t side : {0, 1}) {
      const ThreadRod::Point at = point(crosses_[c], side);
      for (std::size_t k = 0; k < count; ++k) {
        for (const std::size_t other : {0, 1}) {
          const Column& column = columns_[k][other];
          if (column.strand != strand[side] || column.response.empty()) continue;
          Mat3& answer = answers_[c * count + k];
          for (const std::size_t end : {0, 1}) {
            const double weight = (side == other ? 1.0 : -1.0) * at.weight(end);
            const std::size_t row = 4 * (static_cast<std::size_t>(at.segment) + end);
            for (int a = 0; a < 3; ++a) answer.row(a) += weight * column.response[row + a].transpose();
          }
        }
      }
    }
  }
  find_forces();
  for (std::size_t c = 0; c < count; ++c) {
    const Vec3& force = crosses_[c].force;
    if (force == Vec3::Zero()) continue;
    for (const std::size_t side : {0, 1}) {
      const Column& column = columns_[c][side];
      if (!column.response.empty()) strands_[column.strand].rod->add(column.response, side == 0 ? force : Vec3(-force));
    }
  }
}

bool ThreadCrossings::add_forces(std::size_t strand, VecList& forces) const {
  bool any = false;
  for (const Cross& cross : crosses_) {
    const Pair& pair = near_[cross.pair];
    for (const std::size_t side : {0, 1}) {
      if (pair.strand[side] != strand) continue;
      any = true;
      const ThreadRod::Point at{pair.segment[side], cross.share[side]};
      for (const std::size_t end : {0, 1}) {
        forces[static_cast<std::size_t>(at.segment) + end] += (side == 0 ? 1.0 : -1.0) * at.weight(end) * cross.force;
      }
    }
  }
  return any;
}

}  // namespace phymul

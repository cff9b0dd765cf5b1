// SPDX-License-Identifier: MIT
#include "thread_crossings.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace phymul {
namespace {

/// Of an overlap at the step's start, that comes out in the step, and of the sum of radii in a second: all of it at
/// once would fling the threads.
constexpr double parted_at_a_time = 0.1, parted_in_a_second = 200.0;
/// Of the sum of radii: so much farther apart two segments may still be and count, since what moves others moves them.
constexpr double beside_share = 0.25;
/// Of the sum of radii: by so little less they may be apart after the last iteration; it grows with each one.
constexpr double met_share = 2e-3, met_growth = 1.7;
/// Of the sum of radii: a place of one segment that came so near to one of the other had to stop where it came in,
/// unless it went round by less than the angle of this cosine.
constexpr double through_share = 0.9, round_share = 0.5;
/// Of the sum of radii: a vector that is shorter has no direction.
constexpr double tiny_share = 1e-6;
/// Squared sine of an angle, below which two segments lie along each other.
constexpr double along_each_other = 0.05;
constexpr int most_sweeps = 20;  // of a round
/// Sweeps that change ways by less are the last ones: of what is missing before, and of the sum of radii; the latter
/// grows with each sweep.
constexpr double swept_of_missing = 0.1, swept_share = 1e-6, swept_growth = 1.5;

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

/// The force N n + T of least 1/2 (f - y)^T A (f - y) + f^T g with N >= 0 and |T| <= friction N: a step against the
/// gradient g from y, by a diagonal A. By axes of a place, of which the first is n.
Vec3 projected(const Vec3& y, const Vec3& g, const Vec3& a, double friction) {
  const double press = y[0] - g[0] / a[0], limit = friction * press;
  if (!(press > 0.0)) return Vec3::Zero();
  // (A + more) T = A y - g, of the length of the limit: Newton's method for 1 / |T| comes from below.
  const double r1 = a[1] * y[1] - g[1], r2 = a[2] * y[2] - g[2];
  double more = 0.0, size = 0.0;
  Vec3 force(press, 0.0, 0.0);
  for (int k = 0; k < 10 && limit > 0.0; ++k) {
    force[1] = r1 / (a[1] + more);
    force[2] = r2 / (a[2] + more);
    size = std::sqrt(force[1] * force[1] + force[2] * force[2]);
    if (!(size > (1.0 + 1e-6) * limit)) break;
    const double slope = force[1] * force[1] / (a[1] + more) + force[2] * force[2] / (a[2] + more);
    more += (size / limit - 1.0) * size * size / slope;
  }
  if (size > limit) force.tail<2>() *= limit / size;
  return force;
}

}  // namespace

void ThreadCrossings::begin(std::size_t first) {
  const auto group = [this](const Pair& pair) { return group_[pair.strand[0]]; };
  const auto range = std::ranges::equal_range(near_, first, {}, group);
  first_ = first;
  begin_ = static_cast<std::size_t>(range.begin() - near_.begin());
  end_ = static_cast<std::size_t>(range.end() - near_.begin());
  crosses_.clear();
  met_ = met_share / met_growth;
  steepest_ = 1.0;
}

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
  const Vec3 apart = to0 + 0.5 * (ex - ey), gone = apart - from0 - 0.5 * (dx - dy);
  const double halves = 0.5 * (ex.norm() + ey.norm() + (ex - dx).norm() + (ey - dy).norm());
  if (apart.norm() > halves + (1.0 + beside_share) * least + gone.norm()) return;
  if (one.rod->is_broken(p) || other.rod->is_broken(q)) return;
  const auto [s0, t0] = closest_shares(dx, dy, from0);
  const double at_start = (from0 + s0 * dx - t0 * dy).norm();
  if (!(at_start > 0.0)) return;  // on no side of each other
  const double within = std::max(0.0, least - at_start);
  const double left = within - std::min(parted_at_a_time * within, dt_ * parted_in_a_second * least);
  std::array<std::array<double, 2>, 3> places{closest_shares(ex, ey, to0)};
  const auto is_inside = [](const auto& at) { return std::ranges::min(at) > 0.0 && std::ranges::max(at) < 1.0; };
  std::size_t first = 0, count = 1;
  const double crossed = ex.cross(ey).squaredNorm(), product = ex.squaredNorm() * ey.squaredNorm();
  const bool is_along = !(crossed > along_each_other * product);
  if (is_along && product > 0.0) {
    double low = -to0.dot(ex) / ex.squaredNorm(), high = (ey - to0).dot(ex) / ex.squaredNorm();
    if (low > high) std::swap(low, high);
    low = std::max(low, 0.0);
    high = std::min(high, 1.0);
    if (low < high) {
      first = is_inside(places[0]) ? 0 : 1;
      for (const double s : {low, high}) {
        places[count++] = {s, std::clamp((to0 + s * ex).dot(ey) / ey.squaredNorm(), 0.0, 1.0)};
      }
    }
  }
  for (std::size_t k = first; k < count; ++k) {
    const auto [s, t] = places[k];
    if ((s == 0.0 && has_before(pair, 0)) || (t == 0.0 && has_before(pair, 1))) continue;
    const Vec3 from = from0 + s * dx - t * dy, to = to0 + s * ex - t * ey;
    const double length = to.norm(), started = from.norm();
    const bool is_crossed = !is_along && is_inside(places[k]);
    if (!(started > 0.0)) continue;
    Cross cross;
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
    cross.pair = number;
    cross.place = static_cast<int>(k);
    cross.rod = {one.rod, other.rod};
    cross.at = {ThreadRod::Point{p, s}, ThreadRod::Point{q, t}};
    cross.least = least;
    cross.need = cross.normal.dot(to - from) + cross.missing;
    cross.compliance = 1.0 / std::min(one.stiffest, other.stiffest);
    cross.friction = std::sqrt(one.friction * other.friction);
    found.push_back(cross);
  }
}

bool ThreadCrossings::update() {
  met_ *= met_growth;
  bool changes = false;
  before_.swap(crosses_);
  crosses_.clear();
  is_coupled_ = false;
  for (std::size_t pair = begin_; pair < end_; ++pair) measure(pair, crosses_);
  auto known = before_.begin();
  const auto order = [](const Cross& cross) { return std::pair(cross.pair, cross.place); };
  for (Cross& cross : crosses_) {
    while (known != before_.end() && order(*known) < order(cross)) ++known;
    if (known != before_.end() && order(*known) == order(cross)) cross.force = known->force;
    for (const std::size_t side : {0, 1}) {
      const std::size_t node = first_node(near_[cross.pair].strand[side]) + cross.at[side].segment;
      pressed_[node] = pressed_[node + 1] = 1;
    }
    changes = changes || cross.missing > met_ * cross.least + cross.compliance * cross.force.norm();
  }
  return changes;
}

template <class Each>
void ThreadCrossings::each_rod(Each each) const {
  for (std::size_t s = first_; s < strands_.size(); ++s) {
    if (group_[s] == first_) each(*strands_[s].rod);
  }
}

/// Axes and answers of each place alone, and its force of the round before.
void ThreadCrossings::find_frames() {
  free_.clear();
  force_.clear();
  for (Cross& cross : crosses_) {
    const auto& [one, other] = cross.rod;
    const Mat3 own = one->answer(cross.at[0]) + other->answer(cross.at[1]);
    const Vec3 n = cross.normal, t = n.unitOrthogonal(), b = n.cross(t);
    const double angle = 0.5 * std::atan2(2.0 * t.dot(own * b), t.dot(own * t) - b.dot(own * b));
    const Vec3 across = std::cos(angle) * t + std::sin(angle) * b;
    cross.frame << n, across, n.cross(across);
    for (int a = 0; a < 3; ++a) cross.answer[a] = cross.frame.col(a).dot(own * cross.frame.col(a)) + cross.compliance;
    free_.push_back(cross.frame.transpose() * (one->way(cross.at[0]) - other->way(cross.at[1])) -
                    Vec3(cross.need, 0, 0));
    force_.push_back(projected(cross.frame.transpose() * cross.force, Vec3::Zero(), cross.answer, cross.friction));
  }
}

void ThreadCrossings::respond(const VecList& forces, VecList& open) {
  each_rod([](ThreadRod& rod) { rod.clear_response(); });
  for (std::size_t c = 0; c < crosses_.size(); ++c) {
    if (forces[c] == Vec3::Zero()) continue;
    const Cross& cross = crosses_[c];
    const Vec3 force = cross.frame * forces[c];
    cross.rod[0]->push(cross.at[0], force);
    cross.rod[1]->push(cross.at[1], -force);
  }
  each_rod([](ThreadRod& rod) { rod.respond(); });
  open.clear();
  for (std::size_t c = 0; c < crosses_.size(); ++c) {
    const Cross& cross = crosses_[c];
    const Vec3 way = cross.rod[0]->response(cross.at[0]) - cross.rod[1]->response(cross.at[1]);
    open.push_back(free_[c] + cross.frame.transpose() * way + cross.compliance * forces[c]);
  }
}

void ThreadCrossings::find_forces() {
  respond(force_, open_);
  ahead_ = force_;
  open_ahead_ = open_;
  double speed = 1.0, settled = 0.0, share = swept_share;
  for (const Cross& cross : crosses_) settled = std::max(settled, swept_of_missing * cross.missing);
  bool has_swept = false;
  for (int sweep = 0; sweep < most_sweeps && !has_swept; ++sweep, share *= swept_growth) {
    next_.clear();
    for (std::size_t c = 0; c < crosses_.size(); ++c) {
      const Cross& cross = crosses_[c];
      next_.push_back(projected(ahead_[c], open_ahead_[c], steepest_ * cross.answer, cross.friction));
    }
    respond(next_, open_next_);
    double own = 0.0, all = 0.0, back = 0.0;
    has_swept = true;
    for (std::size_t c = 0; c < crosses_.size(); ++c) {
      const Vec3 change = next_[c] - ahead_[c];
      if (change == Vec3::Zero()) continue;
      const Vec3 by_own = crosses_[c].answer.cwiseProduct(change);
      own += change.dot(by_own);
      all += change.dot(open_next_[c] - open_ahead_[c]);
      back -= by_own.dot(next_[c] - force_[c]);
      has_swept = has_swept && steepest_ * by_own.norm() <= std::max(settled, share * crosses_[c].least);
    }
    if (!has_swept && all > (1.0 + 1e-9) * steepest_ * own) {  // too far, so not at all
      steepest_ = std::max(1.5 * steepest_, all / own);
      ahead_ = force_;
      open_ahead_ = open_;
      speed = 1.0;
      continue;
    }
    if (back > 0.0) speed = 1.0;
    const double faster = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * speed * speed)), further = (speed - 1.0) / faster;
    speed = faster;
    for (std::size_t c = 0; c < crosses_.size(); ++c) {
      ahead_[c] = next_[c] + further * (next_[c] - force_[c]);
      open_ahead_[c] = open_next_[c] + further * (open_next_[c] - open_[c]);
    }
    force_.swap(next_);
    open_.swap(open_next_);
  }
}

void ThreadCrossings::couple() {
  is_coupled_ = true;
  if (crosses_.empty()) return;
  find_frames();
  find_forces();
  respond(force_, open_);
  each_rod([](ThreadRod& rod) { rod.add_response(); });
  for (std::size_t c = 0; c < crosses_.size(); ++c) crosses_[c].force = crosses_[c].frame * force_[c];
}

void ThreadCrossings::give_forces() const {
  // Those of the last iteration, at its places.
  for (const Cross& cross : is_coupled_ ? crosses_ : before_) {
    for (const std::size_t side : {0, 1}) {
      const ThreadRod::Point& at = cross.at[side];
      const Vec3 force = side == 0 ? cross.force : Vec3(-cross.force);
      for (const int end : {0, 1}) cross.rod[side]->touch(at.segment + end, at.weight(end) * force);
    }
  }
}

}  // namespace phymul

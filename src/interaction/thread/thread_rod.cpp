// SPDX-License-Identifier: MIT
#include "thread_rod.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace phymul {
namespace {

/// Of a segment: by no more does the way that Newton starts with change it. Farther and it may turn round.
constexpr double most_changed = 0.5;
/// Of a segment's length, by which it may differ from what its tension says. One iteration comes nearer in all but
/// violent motions, in which steps of one gain energy without end.
constexpr double settled = 1e-2;
constexpr int most_iterations = 12;

}  // namespace

ThreadRod::ThreadRod(const SceneThread& thread)
    : stretch_(axial_stiffness(thread.thread)),
      bend_(bending_stiffness(thread.thread)),
      segment_(thread.thread.length / (thread.nodes() - 1)),
      node_mass_(thread.thread.density * std::numbers::pi * thread.thread.radius * thread.thread.radius * segment_),
      damping_(thread.thread.damping),
      breaking_force_(thread.thread.breaking_force) {
  const auto n = static_cast<std::size_t>(thread.nodes());
  state_.name = thread.name;
  for (std::size_t i = 0; i < n; ++i) {
    state_.position.push_back(thread.start + static_cast<double>(i) * segment_ * thread.direction);
  }
  state_.velocity.assign(n, Vec3::Zero());
  state_.rest_length.assign(n - 1, segment_);
  state_.tension.assign(n - 1, 0.0);
  state_.broken.assign(n - 1, 0);
  for (VecList* list : {&place_, &free_way_, &way_, &mass_}) list->resize(n);
  along_.resize(n - 1);
  given_.resize(n);
  tension_.resize(n - 1);
  matrix_.resize((4 * n + band) * row);  // rows of zeros for respond()
  value_.resize(4 * n);
  if (!thread.thread.touches) return;
  for (VecList* list : {&state_.touch, &touch_}) list->reserve(n);
  response_.resize(4 * n);
}

void ThreadRod::begin(double dt, const Vec3& gravity) {
  dt_ = dt;
  const double kept = 1.0 / (1.0 + damping_ * dt);
  for (std::size_t i = 0; i < place_.size(); ++i) {
    place_[i] = state_.position[i];
    mass_[i].setConstant(i == 0 || i + 1 == place_.size() ? 0.5 * node_mass_ : node_mass_);
    free_way_[i] = dt * (kept * state_.velocity[i] + dt * gravity);
    given_[i] = 0;
  }
  tension_ = state_.tension;
  force_.fill(Vec3::Zero());
  touch_.clear();
}

void ThreadRod::load(Index node, const Vec3& force) {
  free_way_[node] += dt_ * dt_ * force.cwiseQuotient(mass_[node]);
}

void ThreadRod::give(Index node, const Vec3& way) {
  free_way_[node] = way;
  given_[node] = 7;
}

void ThreadRod::attach(Index node, const Vec3& place, const Vec3& way, const Vec3& inverse_mass) {
  place_[node] = place;
  for (int a = 0; a < 3; ++a) {
    if (inverse_mass[a] > 0.0) {
      const double own = mass_[node][a], body = 1.0 / inverse_mass[a];
      free_way_[node][a] = (own * free_way_[node][a] + body * way[a]) / (own + body);
      mass_[node][a] = own + body;
    } else {
      free_way_[node][a] = way[a];
      given_[node] |= static_cast<std::uint8_t>(1 << a);
    }
  }
}

/// The way of the last step, or all that is given. A way by dt^2 f / m would turn segments round.
void ThreadRod::start_newton() {
  for (std::size_t i = 0; i < place_.size(); ++i) way_[i] = dt_ * state_.velocity[i];
  double share = 1.0;
  for (std::size_t k = 0; k + 1 < place_.size(); ++k) {
    const double change = (way_[k + 1] - way_[k]).norm();
    if (share * change > most_changed * segment_) share = most_changed * segment_ / change;
  }
  for (std::size_t i = 0; i < place_.size(); ++i) {
    for (int a = 0; a < 3; ++a) way_[i][a] = given_[i] >> a & 1 ? free_way_[i][a] : share * way_[i][a];
  }
}

void ThreadRod::assemble(std::span<const Push> pushes) {
  std::ranges::fill(matrix_, 0.0);
  const double per_step = 1.0 / (dt_ * dt_);
  for (std::size_t i = 0; i < place_.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      const double inertia = per_step * mass_[i][a];
      entry(4 * i + a, 4 * i + a) = inertia;
      value_[4 * i + a] = inertia * (free_way_[i][a] - way_[i][a]);
    }
    value_[4 * i + 3] = 0.0;
  }
  entry(value_.size() - 1, value_.size() - 1) = 1.0;  // no segment after the last node
  for (const Push& push : pushes) {
    const Vec3 force = push.at(way_[push.node]);
    const std::size_t x = 4 * static_cast<std::size_t>(push.node);
    for (std::size_t a = 0; a < 3; ++a) {
      value_[x + a] += force[a];
      for (std::size_t b = 0; b <= a; ++b) entry(x + a, x + b) += push.stiffness(a, b);
    }
  }
  if (bend_ > 0.0) add_bending();
  add_segments();
  impose();
}

/// Energy EI |t' - t|^2 / (2 l) of neighbouring directions t: with equal lengths EI |x'' - 2 x' + x|^2 / (2 l^3).
void ThreadRod::add_bending() {
  const double k = bend_ / (segment_ * segment_ * segment_);
  for (std::size_t i = 1; i + 1 < place_.size(); ++i) {
    if (!bends(i)) continue;
    const Vec3 force = k * ((place_[i + 1] - place_[i]) - (place_[i] - place_[i - 1]) +
                            ((way_[i + 1] - way_[i]) - (way_[i] - way_[i - 1])));
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t x = 4 * (i - 1) + a;
      value_[x] -= force[a];
      value_[x + 4] += 2.0 * force[a];
      value_[x + 8] -= force[a];
      entry(x, x) += k;
      entry(x + 4, x) -= 2.0 * k;
      entry(x + 4, x + 4) += 4.0 * k;
      entry(x + 8, x) += k;
      entry(x + 8, x + 4) -= 2.0 * k;
      entry(x + 8, x + 8) += k;
    }
  }
}

void ThreadRod::add_segments() {
  const double compliance = segment_ / stretch_;
  for (std::size_t k = 0; k + 1 < place_.size(); ++k) {
    const std::size_t x = 4 * k, t = x + 3;
    const Vec3 d = (place_[k + 1] - place_[k]) + (way_[k + 1] - way_[k]);
    const double length = d.norm();
    along_[k] = length > 0.0 ? Vec3(d / length) : Vec3(Vec3::Zero());
    if (state_.broken[k] || !(length > 0.0)) {
      entry(t, t) = -1.0;
      value_[t] = tension_[k];  // to 0
      continue;
    }
    const double across = std::max(tension_[k], 0.0) / length;
    for (std::size_t a = 0; a < 3; ++a) {
      const double pull = along_[k][a] * tension_[k];
      value_[x + a] += pull;
      value_[x + 4 + a] -= pull;
      entry(t, x + a) = -along_[k][a];
      entry(x + 4 + a, t) = along_[k][a];
      for (std::size_t b = 0; b < 3; ++b) {
        const double h = across * ((a == b ? 1.0 : 0.0) - along_[k][a] * along_[k][b]);
        if (b <= a) {
          entry(x + a, x + b) += h;
          entry(x + 4 + a, x + 4 + b) += h;
        }
        entry(x + 4 + a, x + b) -= h;
      }
    }
    entry(t, t) = -compliance;
    value_[t] = -(length - segment_ - compliance * tension_[k]);
  }
}

void ThreadRod::impose() {
  for (std::size_t i = 0; i < place_.size(); ++i) {
    for (std::size_t a = 0; given_[i] != 0 && a < 3; ++a) {
      if ((given_[i] >> a & 1) == 0) continue;
      const std::size_t r = 4 * i + a;
      for (std::size_t c = r - std::min<std::size_t>(r, band); c < r; ++c) entry(r, c) = 0.0;
      for (std::size_t below = r + 1; below < std::min(r + row, value_.size()); ++below) entry(below, r) = 0.0;
      entry(r, r) = 1.0;
      value_[r] = 0.0;
    }
  }
}

/// LDL^T by columns: the rows below a pivot take their share of it at once.
void ThreadRod::factor_and_solve() {
  const std::size_t n = value_.size();
  for (std::size_t j = 0; j < n; ++j) {
    const double inverse = 1.0 / matrix_[j * row + band], value = value_[j];
    const std::size_t below = std::min<std::size_t>(band, n - 1 - j);
    double column[row];  // of the pivot, as of now
    for (std::size_t i = 1; i <= below; ++i) column[i] = matrix_[(j + i) * row + band - i];
    for (std::size_t i = 1; i <= below; ++i) {
      if (column[i] == 0.0) continue;
      double* const own = &matrix_[(j + i) * row + band - i];
      const double share = inverse * column[i];
      for (std::size_t k = 1; k <= i; ++k) own[k] -= share * column[k];
      own[0] = share;
      value_[j + i] -= share * value;
    }
    value_[j] = inverse * value;
  }
  for (std::size_t j = n; j-- > 0;) {
    const std::size_t below = std::min<std::size_t>(band, n - 1 - j);
    double sum = value_[j];
    for (std::size_t i = 1; i <= below; ++i) sum -= matrix_[(j + i) * row + band - i] * value_[j + i];
    value_[j] = sum;
  }
}

void ThreadRod::iterate(std::span<const Push> pushes) {
  assemble(pushes);
  factor_and_solve();
  for (std::size_t i = 0; i < place_.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a) way_[i][a] += value_[4 * i + a];
    if (i + 1 < place_.size()) tension_[i] += value_[4 * i + 3];
  }
  for (std::size_t k = 0; k < tension_.size(); ++k) {
    if (state_.broken[k]) tension_[k] = 0.0;
  }
}

void ThreadRod::touch(Index node, const Vec3& force) {
  if (touch_.empty()) touch_.assign(place_.size(), Vec3::Zero());
  touch_[node] += force;
}

void ThreadRod::clear_response() {
  low_ = value_.size();
  response_.assign(value_.size(), 0.0);
}

void ThreadRod::push(const Point& point, const Vec3& force) {
  low_ = std::min(low_, 4 * static_cast<std::size_t>(point.segment));
  for (const std::size_t end : {0, 1}) {
    const std::size_t node = static_cast<std::size_t>(point.segment) + end;
    for (std::size_t a = 0; a < 3; ++a) {
      if ((given_[node] >> a & 1) == 0) response_[4 * node + a] += point.weight(end) * force[a];
    }
  }
}

/// The last values are kept apart and subtracted in their order, so that a row need wait for one of them only.
void ThreadRod::respond() {
  const std::size_t n = value_.size();
  std::array<double, band> last{};
  const auto keep = [&](double& value, double sum) {
    for (std::size_t i = 1; i < band; ++i) last[i - 1] = last[i];
    last[band - 1] = value = sum;
  };
  for (std::size_t j = low_; j < n; ++j) {
    const double* const own = &matrix_[j * row];
    double sum = response_[j];
    for (std::size_t i = 0; i < band; ++i) sum -= own[i] * last[i];
    keep(response_[j], sum);
  }
  last.fill(0.0);
  for (std::size_t j = n; j-- > 0;) {
    const double* const pivot = &matrix_[j * row + band];
    double sum = response_[j] / *pivot;
    for (std::size_t i = 0; i < band; ++i) sum -= pivot[(band - i) * band] * last[i];
    keep(response_[j], sum);
  }
}

Vec3 ThreadRod::response(const Point& point) const {
  const double* const at = &response_[4 * static_cast<std::size_t>(point.segment)];
  return point.weight(0) * Vec3(at[0], at[1], at[2]) + point.weight(1) * Vec3(at[4], at[5], at[6]);
}

void ThreadRod::add_response() {
  for (std::size_t i = 0; i < place_.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a) way_[i][a] += response_[4 * i + a];
    if (i + 1 < place_.size() && !state_.broken[i]) tension_[i] += response_[4 * i + 3];
  }
}

/// Of the node with what is before it: of a longer thread with both sides it is less, everywhere by about as much.
Mat3 ThreadRod::answer(const Point& point) const {
  Mat3 answer = Mat3::Zero();
  for (const std::size_t end : {0, 1}) {
    const std::size_t node = static_cast<std::size_t>(point.segment) + end;
    Mat3 lower = Mat3::Identity();
    Vec3 inverse = Vec3::Zero();
    for (std::size_t a = 0; a < 3; ++a) {
      const double* const own = &matrix_[(4 * node + a) * row + band];
      if ((given_[node] >> a & 1) == 0) inverse[a] = 1.0 / own[0];
      for (std::size_t b = 0; b < a; ++b) lower(a, b) = *(own - (a - b));
    }
    const Mat3 back = lower.inverse();
    answer += point.weight(end) * point.weight(end) * back.transpose() * inverse.asDiagonal() * back;
  }
  return answer;
}

bool ThreadRod::has_settled() const {
  for (std::size_t k = 0; k < tension_.size(); ++k) {
    const double length = ((place_[k + 1] - place_[k]) + (way_[k + 1] - way_[k])).norm();
    const double missing = length - segment_ * (1.0 + tension_[k] / stretch_);
    if (!state_.broken[k] && !(std::abs(missing) <= settled * segment_)) return false;
  }
  return true;
}

void ThreadRod::solve() {
  start_newton();
  for (int k = 0; k < most_iterations; ++k) {
    iterate();
    if (has_settled()) break;
  }
}

Vec3 ThreadRod::force_at(ThreadTip tip) const {
  const bool first = tip == ThreadTip::first;
  const std::size_t n = place_.size(), end = first ? 0 : n - 1, segment = first ? 0 : n - 2;
  Vec3 force = (first ? 1.0 : -1.0) * tension_[segment] * along_[segment];
  if (n < 3 || !bends(first ? 1 : n - 2)) return force;
  const auto at = [&](std::size_t i) { return Vec3(place_[i] + way_[i]); };
  const std::size_t next = first ? 1 : n - 2, after = first ? 2 : n - 3;
  return force - bend_ / (segment_ * segment_ * segment_) * ((at(after) - at(next)) - (at(next) - at(end)));
}

bool ThreadRod::is_finite() const {
  for (std::size_t i = 0; i < place_.size(); ++i) {
    if (!Vec3(place_[i] + way_[i]).allFinite() || !Vec3(way_[i] / dt_).allFinite()) return false;
  }
  return std::ranges::all_of(tension_, [](double tension) { return std::isfinite(tension); }) &&
         (force_[0] + force_[1]).allFinite();
}

void ThreadRod::accept() {
  for (std::size_t i = 0; i < place_.size(); ++i) {
    state_.position[i] = place_[i] + way_[i];
    state_.velocity[i] = way_[i] / dt_;
  }
  state_.tension = tension_;
  state_.force = force_;
  state_.touch = touch_;
  const auto most = std::ranges::max_element(tension_);
  if (*most > breaking_force_) state_.broken[most - tension_.begin()] = 1;  // then nothing pulls the others
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// The knots of a sewn thread. A sewn thread that grows by the passages that a needle makes, and a clip that closes.
#include <algorithm>

#include "thread_path.h"

namespace phymul {
namespace {

/// Whether another one is of the same passages: of a Knot or a KnotState.
template <class Tied>
auto ties_as(const Tied& knot) {
  return [&knot](const auto& other) { return other.a == knot.a && other.b == knot.b; };
}

}  // namespace

/// Thread for a knot comes from the free tails, half from each, or more from the one that has more.
void ThreadPath::take_from_tails(double length) {
  double &first = next_.rest_length.front(), &last = next_.rest_length.back();
  const double of_first = is_anchored(0) ? 0.0 : first, of_last = is_anchored(1) ? 0.0 : last;
  const double least = std::max(length - of_last, 0.0);
  const double taken = std::min(of_first, std::max(std::min(0.5 * length, of_first), least));
  first -= taken;
  last -= std::min(length - taken, of_last);
}

/// And goes back there, but for what the tails lacked: the thread does not grow.
void ThreadPath::give_to_tails(double length) {
  double left = thread_.length;
  for (const double rest : next_.rest_length) left -= rest;
  for (const KnotState& knot : next_.knots) left -= knot.rest_length;
  const double given = std::clamp(left + length, 0.0, length);  // the knot is one of them
  const double share = is_anchored(0) ? 0.0 : is_anchored(1) ? 1.0 : 0.5;
  next_.rest_length.front() += share * given;
  if (!is_anchored(1)) next_.rest_length.back() += (1.0 - share) * given;
}

/// Their thread goes back to the tails.
template <class Is>
void ThreadPath::drop_knots(const Is& is) {
  for (KnotState& known : next_.knots) {
    if (!is(known)) continue;
    give_to_tails(known.rest_length);
    known.rest_length = 0.0;
  }
  std::erase_if(next_.knots, is);
}

/// Knots that broke and were tied again: the next step makes new ones. At once, because a state tells of that.
void ThreadPath::tie_again(const std::vector<Knot>& knots) {
  for (const Knot& knot : knots) {
    if (std::ranges::count(control_.knots, knot.call, &Knot::call) > 0) continue;
    next_ = state_;
    drop_knots([&](const KnotState& known) { return known.broken && ties_as(knot)(known); });
    state_ = next_;
  }
}

void ThreadPath::take_over_knots() {
  drop_knots([&](const KnotState& known) { return std::ranges::none_of(control_.knots, ties_as(known)); });
  for (const Knot& knot : control_.knots) {
    if (static_cast<std::size_t>(knot.b) >= passages_.size()) continue;  // a needle may make it
    const std::size_t a = point_of(knot.a), b = point_of(knot.b);
    auto own = std::ranges::find_if(next_.knots, ties_as(knot));
    if (own == next_.knots.end()) {
      const double rest = a > 0 && b > 0 ? (start_[b] - start_[a]).norm() : 0.0;
      own = next_.knots.insert(own, {.a = knot.a, .b = knot.b, .rest_length = rest});
      take_from_tails(rest);
    }
    own->broken = own->broken || a == 0 || b == 0;
  }
  for (const KnotState& knot : next_.knots) {
    if (knot.broken) continue;
    const std::size_t a = point_of(knot.a), b = point_of(knot.b);
    const int throws = std::ranges::find_if(control_.knots, ties_as(knot))->throws;
    locked_[a - 1] = locked_[b - 1] = 1;
    pieces_.push_back({.a = a, .b = b, .rest = knot.rest_length, .most = throws * thread_.throw_holding});
  }
}

namespace {

constexpr std::size_t most_sewn = 100;  // passages: a step solves them together

}  // namespace

/// Of a thread that was just made.
void ThreadPath::restore(const ThreadState& state) {
  passages_.insert(passages_.end(), state.sewn.begin(), state.sewn.end());
  state_ = state;
}

/// What lies between the passage and the tip comes from the segment there, so that no thread is lost. Passages that are
/// nearer to each other than the thread is thick are one.
void ThreadPath::append(const Anchor& anchor, const Vec3& place, const Vec3& tip) {
  const bool first = passages_.empty();
  if (passages_.size() >= most_sewn || (!state_.broken.empty() && state_.broken.back() != 0)) return;
  const VecList& known = state_.position;
  if (known.size() > 2 && (known[known.size() - 2] - place).norm() < 2.0 * thread_.radius) return;
  if (!before_) before_ = state_;
  passages_.push_back(anchor);
  state_.sewn.push_back(anchor);
  if (first) {
    state_.rest_length = {thread_.length};
    state_.tension = {0.0};
    state_.broken = {0};
    state_.position = {place, tip};
    state_.anchored[1] = true;
  }
  if (state_.rest_length.empty()) return;  // before the first step, which numbers all
  std::vector<double>& rest = state_.rest_length;
  const double tail = std::min((tip - place).norm(), rest.back());
  rest.back() -= tail;
  rest.push_back(tail);
  state_.tension.push_back(0.0);
  state_.broken.push_back(0);
  state_.position.insert(state_.position.end() - 1, place);
  state_.passages.push_back(static_cast<Index>(passages_.size()) - 1);
  state_.slides.push_back(0);
}

bool ThreadPath::drop() {
  if (!before_) return false;
  passages_.resize(passages_.size() - (state_.sewn.size() - before_->sewn.size()));
  state_ = *std::move(before_);
  before_.reset();
  return true;
}

/// As long as the way, so that it is not taut where it is held again; what that takes comes from the other tail.
void ThreadPath::loosen(std::size_t tip) {
  std::vector<double>& rest = next_.rest_length;
  const std::size_t at = tip * (rest.size() - 1), other = rest.size() - 1 - at;
  const double by = (place_[at + 1] - place_[at]).norm() - rest[at];
  if (!(by > 0.0)) return;
  rest[at] += by;
  if (!is_anchored(1 - tip)) rest[other] = std::max(rest[other] - by, 0.0);
}

/// Closes a clip: the segment next to the tip goes to its length in the steps of the call, and its thread to the tail;
/// of a segment between two clamps to that of the first, which lets it through again.
void ThreadPath::draw(std::size_t tip, int steps_left) {
  std::vector<double>& rest = next_.rest_length;
  if (!is_clamped(tip) || next_.anchored[tip] || rest.size() < 3) return;
  double& segment = tip == 0 ? rest[1] : rest[rest.size() - 2];
  const double by = (segment - control_.ends[tip].gap) / steps_left;
  next_.anchored[tip] = steps_left == 1;
  if (control_.ends[tip].gap < 0.0 || !(by > 0.0)) return;
  segment -= by;
  (tip == 0 || (rest.size() == 3 && is_clamped(0)) ? rest.front() : rest.back()) += by;
}

}  // namespace phymul

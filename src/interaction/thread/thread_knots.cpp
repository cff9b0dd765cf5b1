// SPDX-License-Identifier: MIT
//
// The knots of a sewn thread.
#include <algorithm>
#include <cmath>

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

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// A sewn thread that grows by the passages that a needle makes, and a clip that closes.
#include <algorithm>

#include "thread_path.h"

namespace phymul {
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

// SPDX-License-Identifier: MIT
#include "thread_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace phymul {
namespace {

constexpr double least_rest = 1e-6;     // m: a shorter segment would be as stiff as none
constexpr double most_exponent = 40.0;  // of friction: more holds anything
constexpr double least_length = 1e-12;  // m: points nearer than that have no direction

}  // namespace

ThreadPath::ThreadPath(const SceneThread& thread)
    : thread_(thread.thread), stretch_(axial_stiffness(thread.thread)), passages_(thread.passages) {
  state_.name = thread.name;
}

bool has_tissue(const Anchor& anchor, std::span<const double> mass) {
  return std::ranges::all_of(anchor.particles, [&](Index i) { return mass[i] > 0.0; });
}

void ThreadPath::follow(const ThreadControl& control, std::span<const double> mass) {
  for (const std::size_t tip : {0, 1}) {
    const ThreadEnd &now = control.ends[tip], &before = control_.ends[tip];
    const bool in_body = !now.anchor.particles.empty() || !before.anchor.particles.empty();
    // ThreadState::anchored says of a clamp that it has closed.
    if (now.hold != before.hold || now.gap != before.gap || now.holding != before.holding || now.call != before.call ||
        (in_body && now.anchor != before.anchor)) {
      if (known_) state_.anchored[tip] = false;
    }
  }
  control_.ends = control.ends;
  if (known_) tie_again(control.knots);
  known_ = true;
  control_ = control;
  for (std::size_t p = state_.passages.size(); p-- > 0;) {
    if (has_tissue(passages_[state_.passages[p]], mass)) continue;
    next_ = state_;
    remove(p);
    ++next_.torn;
    state_ = next_;
  }
}

std::vector<Index> ThreadPath::particles() const {
  std::vector<Index> all;
  for (const Anchor& anchor : passages_) all.insert(all.end(), anchor.particles.begin(), anchor.particles.end());
  for (const ThreadEnd& end : control_.ends) {
    all.insert(all.end(), end.anchor.particles.begin(), end.anchor.particles.end());
  }
  return all;
}

Vec3 ThreadPath::place(TouchedParticles& touched, std::size_t point, bool end) const {
  Vec3 sum = Vec3::Zero();
  const Anchor& anchor = *anchors_[point];
  for (std::size_t k = 0; k < anchor.particles.size(); ++k) {
    const TouchedParticles::Touched& particle = touched[touched.slot(anchor.particles[k])];
    sum += anchor.weights[k] * (end ? particle.end(touched.dt()) : particle.position);
  }
  return sum;
}

/// Points at their predicted places, and the first rest lengths.
void ThreadPath::begin(TouchedParticles& touched, const std::array<Outside, 2>& tips, int steps_left) {
  next_ = state_;
  next_.force.fill(Vec3::Zero());
  pieces_.clear();
  if (passages_.empty()) return;
  if (next_.rest_length.empty()) {
    for (std::size_t row = 0; row < passages_.size(); ++row) {
      if (has_tissue(passages_[row], touched.mass())) next_.passages.push_back(static_cast<Index>(row));
    }
    const std::size_t left = next_.passages.size();
    next_.torn = static_cast<int>(passages_.size() - left);
    if (left == 0) return;
    next_.slides.assign(left, 0);
    next_.rest_length.assign(left + 1, -1.0);
    next_.tension.assign(left + 1, 0.0);
    next_.broken.assign(left + 1, 0);
  }
  const std::size_t last = next_.passages.size() + 1;
  anchors_.assign(last + 1, nullptr);
  start_.resize(last + 1);
  place_.resize(last + 1);
  for (std::size_t p = 1; p < last; ++p) anchors_[p] = &passages_[next_.passages[p - 1]];
  for (const std::size_t tip : {0, 1}) {
    const Anchor& anchor = control_.ends[tip].anchor;
    if (is_anchored(tip) && !anchor.particles.empty()) anchors_[tip * last] = &anchor;
  }
  for (std::size_t i = 0; i <= last; ++i) {
    if (anchors_[i] == nullptr) continue;
    start_[i] = place(touched, i, false);
    place_[i] = place(touched, i, true);
  }
  for (const std::size_t tip : {0, 1}) {
    if (anchors_[tip * last] != nullptr) continue;
    const std::size_t next = tip == 0 ? 1 : last - 1;
    start_[tip * last] = is_anchored(tip) ? tips[tip].start : start_[next];
    place_[tip * last] = is_anchored(tip) ? tips[tip].end : place_[next];
  }
  set_first_lengths();
  for (const std::size_t tip : {0, 1}) {
    draw(tip, steps_left);
    if (is_anchored(tip) && tips[tip].is_loose) loosen(tip);
  }
  if (!next_.passages.empty()) list_pieces(tips);
}

/// Segments are as long as their way; the tails get the rest.
void ThreadPath::set_first_lengths() {
  std::vector<double>& rest = next_.rest_length;
  const auto way = [&](std::size_t k) { return (start_[k + 1] - start_[k]).norm(); };
  if (rest.front() < 0.0) {
    double left = thread_.length;
    for (std::size_t k = 1; k + 1 < rest.size(); ++k) left -= rest[k] = way(k);
    rest.front() = rest.back() = std::max(0.5 * left, 0.0);
  }
  for (const std::size_t tip : {0, 1}) {
    double& tail = tip == 0 ? rest.front() : rest.back();
    if (is_anchored(tip) && !next_.anchored[tip] && !next_.passages.empty()) tail = way(tip * (rest.size() - 1));
    if (!is_clamped(tip)) next_.anchored[tip] = is_anchored(tip);
  }
}

std::size_t ThreadPath::point_of(Index row) const {
  const auto own = std::ranges::find(next_.passages, row);
  return own == next_.passages.end() ? 0 : static_cast<std::size_t>(own - next_.passages.begin()) + 1;
}

void ThreadPath::list_pieces(const std::array<Outside, 2>& tips) {
  const std::size_t passages = next_.passages.size();
  locked_.assign(passages, 0);
  holding_.assign(passages, 0.0);
  for (std::size_t k = 0; k <= passages; ++k) {
    pieces_.push_back({.a = k, .b = k + 1, .rest = next_.rest_length[k], .given = next_.broken[k] ? 0.0 : -1.0});
  }
  for (const std::size_t tip : {0, 1}) {
    const ThreadEnd& end = control_.ends[tip];
    ThreadPiece& tail = pieces_[tip * passages];
    if (is_anchored(tip) && tips[tip].is_loose) tail.given = 0.0;
    if (end.hold == TipHold::anchored) continue;
    const double force = end.force.norm();
    tail.given = next_.broken[tip * passages] ? 0.0 : force;
    if (force > 0.0) tail.along = (tip == 0 ? -1.0 : 1.0) / force * end.force;
    if (end.hold == TipHold::fixed) locked_[tip * (passages - 1)] = 1;
    if (end.hold == TipHold::clamped) holding_[tip * (passages - 1)] = end.holding;
  }
  take_over_knots();
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    ThreadPiece& piece = pieces_[k];
    piece.compliance = std::max(piece.rest, least_rest) / stretch_;
    if ((k == 0 && !is_anchored(0)) || (k == passages && !is_anchored(1))) continue;
    const Vec3 d = start_[piece.b] - start_[piece.a];
    const double length = d.norm();
    if (length > least_length) piece.along = d / length;
    piece.longer = (place_[piece.b] - place_[piece.a]).norm() - piece.rest;
  }
}

void ThreadPath::put_segments(ThreadTensions& all) {
  if (next_.passages.empty()) return;
  first_point_ = all.points.size();
  first_piece_ = all.pieces.size();
  all.points.insert(all.points.end(), anchors_.begin(), anchors_.end());
  for (std::size_t k = 0; k < next_.rest_length.size(); ++k) {
    if (k > 0) {
      const Vec3 &before = pieces_[k - 1].along, &after = pieces_[k].along;
      const double wrap = std::atan2(before.cross(after).norm(), before.dot(after));  // 0 if one has no direction
      all.bends.push_back({.slides = next_.slides[k - 1],
                           .locked = locked_[k - 1] != 0,
                           .growth = std::exp(std::min(thread_.friction * wrap, most_exponent)),
                           .channel = thread_.channel_friction + holding_[k - 1]});
    } else if (first_piece_ > 0) {
      all.bends.push_back({});
    }
    all.pieces.push_back(pieces_[k]);
    all.pieces.back().a += first_point_;
    all.pieces.back().b += first_point_;
  }
}

void ThreadPath::put_knots(ThreadTensions& all) {
  first_knot_ = all.pieces.size();
  for (std::size_t k = next_.rest_length.size(); k < pieces_.size(); ++k) {
    all.pieces.push_back(pieces_[k]);
    all.pieces.back().a += first_point_;
    all.pieces.back().b += first_point_;
  }
}

void ThreadPath::take(TouchedParticles& touched, const ThreadTensions& all) {
  if (next_.passages.empty()) return;
  const std::size_t segments = next_.rest_length.size();
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const ThreadPiece& solved = all.pieces[k < segments ? first_piece_ + k : first_knot_ + k - segments];
    pieces_[k].tension = solved.tension;
    pieces_[k].lacks = solved.lacks;
    pieces_[k].given = solved.given;
    if (k > 0 && k < segments) next_.slides[k - 1] = all.bends[first_piece_ + k - 1].slides;
  }
  push(touched);
  move_rest_length();
  note_events();
}

bool ThreadPath::is_finite() const {
  double sum = 0.0;  // of numbers that are 0 or more
  for (const std::vector<double>* list : {&next_.rest_length, &next_.tension}) {
    for (const double value : *list) sum += value;
  }
  for (const KnotState& knot : next_.knots) sum += knot.rest_length + knot.tension + knot.slip;
  return std::isfinite(sum) && std::ranges::all_of(next_.position, [](const Vec3& at) { return at.allFinite(); }) &&
         (next_.force[0] + next_.force[1]).allFinite();
}

bool ThreadPath::is_free_row(Index row) const {
  for (const std::size_t tip : {std::size_t{0}, std::size_t{1}}) {
    const Index outer = tip == 0 ? next_.passages.front() : next_.passages.back();
    if (control_.ends[tip].hold == TipHold::fixed && row == outer) return false;
  }
  return std::ranges::none_of(next_.knots,
                              [&](const KnotState& knot) { return !knot.broken && (knot.a == row || knot.b == row); });
}

void ThreadPath::push(TouchedParticles& touched) {
  force_.assign(place_.size(), Vec3::Zero());
  for (const ThreadPiece& piece : pieces_) {
    force_[piece.a] += piece.tension * piece.along;
    force_[piece.b] -= piece.tension * piece.along;
  }
  for (std::size_t i = 0; i < force_.size(); ++i) {
    if (anchors_[i] == nullptr) continue;
    for (std::size_t k = 0; k < anchors_[i]->particles.size(); ++k) {
      TouchedParticles::Touched& particle = touched[touched.slot(anchors_[i]->particles[k])];
      TouchedParticles::pull(particle, touched.dt() * anchors_[i]->weights[k] * force_[i]);
    }
  }
  next_.position.resize(place_.size());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    next_.position[i] = anchors_[i] != nullptr ? place(touched, i, true) : place_[i];
  }
  for (const std::size_t tip : {0, 1}) {
    next_.force[tip] = is_anchored(tip) ? force_[tip * (force_.size() - 1)] : Vec3(Vec3::Zero());
  }
}

/// Within each group, so that the sum stays. A slack group stays as slack as it is.
void ThreadPath::move_rest_length() {
  std::vector<double>& rest = next_.rest_length;
  for (std::size_t first = 0; first < rest.size();) {
    const std::size_t end = end_of_group(first, rest.size(), [this](std::size_t k) { return next_.slides[k] != 0; });
    const std::size_t given = given_in(pieces_, first, end);
    double all = 0.0, lacks = 0.0;
    for (std::size_t k = first; k < end; ++k) {
      all += rest[k];
      if (k != given) lacks += pieces_[k].lacks;
    }
    const double share = given < end || !(all > 0.0) ? 0.0 : lacks / all;
    double moved = 0.0;
    for (std::size_t k = first; end - first > 1 && k < end; ++k) {
      if (k == given) continue;
      rest[k] = std::max(rest[k] + pieces_[k].lacks - share * rest[k], least_rest);
      moved += rest[k];
    }
    if (end - first > 1 && given < end) {
      rest[given] = all - moved;  // below 0 where the tip has gone through
    } else if (end - first > 1) {
      for (std::size_t k = first; k < end; ++k) rest[k] *= all / moved;
    }
    first = end;
  }
}

void ThreadPath::note_events() {
  const std::size_t segments = next_.rest_length.size();
  auto piece = pieces_.begin() + static_cast<std::ptrdiff_t>(segments);
  for (KnotState& knot : next_.knots) {
    knot.tension = 0.0;
    if (knot.broken) continue;
    knot.tension = piece->tension;
    knot.broken = piece->tension > thread_.breaking_force;
    const double slip = piece->given >= 0.0 ? std::max(piece->lacks, 0.0) : 0.0;
    knot.rest_length += slip;
    knot.slip += slip;
    if (slip > 0.0) take_from_tails(slip);
    ++piece;
  }
  for (std::size_t k = 0; k < segments; ++k) next_.tension[k] = pieces_[k].tension;
  const auto most = std::ranges::max_element(next_.tension);
  if (*most > thread_.breaking_force) next_.broken[most - next_.tension.begin()] = 1;
  for (std::size_t p = next_.passages.size(); p-- > 0;) {
    if (!(force_[p + 1].norm() > thread_.passage_limit)) continue;
    remove(p);
    ++next_.torn;
  }
  std::size_t through = 0;
  while ((through = passage_left()) < next_.passages.size()) {
    remove(through);
    ++next_.pulled_out;
  }
  for (double& rest : next_.rest_length) rest = std::max(rest, 0.0);
}

/// The first that a tip, or an end where the thread broke, has gone through: no length of it is left. A segment that
/// broke has two ends: the one that slides is through.
std::size_t ThreadPath::passage_left() const {
  const std::size_t last = next_.passages.size();
  const auto is_through = [&](std::size_t p, std::size_t k) {
    const bool tail = k == 0 || k == last;
    const TipHold hold = control_.ends[k > 0].hold;
    const bool tip = tail && (hold == TipHold::pulled || hold == TipHold::clamped || next_.broken[k]);
    const bool end = next_.broken[k] && next_.slides[p] == (k == p ? 1 : -1);
    return (tip || end) && next_.rest_length[k] <= 0.0;
  };
  std::size_t p = 0;
  while (p < last && !(is_free_row(next_.passages[p]) && (is_through(p, p) || is_through(p, p + 1)))) ++p;
  return p;
}

void ThreadPath::remove(std::size_t passage) {
  const auto at = static_cast<std::ptrdiff_t>(passage);
  for (KnotState& knot : next_.knots) {
    if (knot.a != next_.passages[passage] && knot.b != next_.passages[passage]) continue;
    knot.broken = true;
    knot.tension = 0.0;
  }
  next_.rest_length[passage] += next_.rest_length[passage + 1];
  next_.broken[passage] |= next_.broken[passage + 1];
  next_.tension[passage] = 0.0;
  next_.rest_length.erase(next_.rest_length.begin() + at + 1);
  next_.broken.erase(next_.broken.begin() + at + 1);
  next_.tension.erase(next_.tension.begin() + at + 1);
  next_.position.erase(next_.position.begin() + at + 1);
  next_.passages.erase(next_.passages.begin() + at);
  next_.slides.erase(next_.slides.begin() + at);
}

}  // namespace phymul

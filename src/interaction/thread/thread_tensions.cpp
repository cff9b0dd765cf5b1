// SPDX-License-Identifier: MIT
#include "thread_path.h"

#include <algorithm>

namespace phymul {
namespace {

constexpr double least_flow = 1e-12;  // m: rest length that moves by rounding alone
constexpr double least_lack = 1e-13;  // m: likewise, of a slack group
constexpr double of_tension = 1e-10;  // by which a tension must be beyond what friction bears
/// Of what the points give way in a step: stiffer threads between the same particles would pull against each other by
/// more than their directions are known.
constexpr double least_compliance = 1e-2;
constexpr double least_tension = 1e-9;  // N
constexpr std::size_t rounds_per_piece = 4;

/// Gaussian elimination with pivots in columns; value = matrix^-1 value. A row of zeros gives 0.
void solve_dense(std::size_t n, std::vector<double>& matrix, std::vector<double>& value) {
  for (std::size_t j = 0; j < n; ++j) {
    std::size_t pivot = j;
    for (std::size_t i = j + 1; i < n; ++i) {
      if (std::abs(matrix[n * i + j]) > std::abs(matrix[n * pivot + j])) pivot = i;
    }
    for (std::size_t k = j; pivot != j && k < n; ++k) std::swap(matrix[n * j + k], matrix[n * pivot + k]);
    if (pivot != j) std::swap(value[j], value[pivot]);
    if (matrix[n * j + j] == 0.0) continue;
    for (std::size_t i = j + 1; i < n; ++i) {
      const double share = matrix[n * i + j] / matrix[n * j + j];
      for (std::size_t k = j; share != 0.0 && k < n; ++k) matrix[n * i + k] -= share * matrix[n * j + k];
      value[i] -= share * value[j];
    }
  }
  for (std::size_t j = n; j-- > 0;) {
    for (std::size_t k = j + 1; k < n; ++k) value[j] -= matrix[n * j + k] * value[k];
    value[j] = matrix[n * j + j] == 0.0 ? 0.0 : value[j] / matrix[n * j + j];
  }
}

}  // namespace

void ThreadTensions::clear() {
  points.clear();
  pieces.clear();
  bends.clear();
}

Vec3 mobility_between(TouchedParticles& touched, const Anchor& a, const Anchor& b) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < a.particles.size(); ++k) {
    const auto own = std::ranges::find(b.particles, a.particles[k]);
    if (own == b.particles.end()) continue;
    const TouchedParticles::Touched& particle = touched[touched.slot(*own)];
    if (particle.held) continue;
    const double both = a.weights[k] * b.weights[static_cast<std::size_t>(own - b.particles.begin())];
    sum += particle.free_part(Vec3::Constant(both * particle.inverse_mass));
  }
  return sum;
}

void ThreadTensions::find_couplings(TouchedParticles& touched) {
  bool same = known_ == points;
  std::size_t count = 0;
  for (const Anchor* const point : points) {
    for (std::size_t k = 0; point != nullptr && k < point->particles.size(); ++k, ++count) {
      if (count == held_.size()) held_.push_back(0);
      const std::uint8_t held = touched[touched.slot(point->particles[k])].held ? 1 : 0;
      same = same && held_[count] == held;
      held_[count] = held;
    }
  }
  if (same) return;
  known_ = points;
  const std::size_t n = points.size();
  coupling_.assign(n * n, Vec3::Zero());
  for (std::size_t i = 0; i < n * n; ++i) {
    const Anchor *const a = points[i / n], *const b = points[i % n];
    if (a != nullptr && b != nullptr) coupling_[i] = mobility_between(touched, *a, *b);
  }
}

double ThreadTensions::between(const ThreadPiece& a, const ThreadPiece& b) const {
  const std::size_t n = points.size();
  const auto at = [&](std::size_t i, std::size_t j) -> const Vec3& { return coupling_[n * i + j]; };
  const Vec3 sum = at(a.a, b.a) + at(a.b, b.b) - at(a.a, b.b) - at(a.b, b.a);
  return a.along.dot(sum.cwiseProduct(b.along));
}

std::size_t ThreadTensions::end_from(std::size_t first) const {
  if (first >= segments()) return first + 1;  // a knot
  return end_of_group(first, segments(), [this](std::size_t k) { return bends[k].slides != 0; });
}

std::size_t ThreadTensions::first_of_group(std::size_t piece) const {
  while (piece > 0 && bends[piece - 1].slides != 0) --piece;
  return piece;
}

/// Numbers the unknowns; tensions of a group follow from its given one, or from that of its first piece.
void ThreadTensions::join_groups() {
  unknowns_ = 0;
  for (std::size_t first = 0; first < pieces.size();) {
    const std::size_t end = end_from(first), given = given_in(pieces, first, end), from = given < end ? given : first;
    const std::size_t unknown = given < end || parts_[first].slack ? no_unknown : unknowns_++;
    for (std::size_t k = first; k < end; ++k) parts_[k].unknown = unknown;
    parts_[from].factor = given < end ? 0.0 : 1.0;
    parts_[from].offset = given < end ? pieces[given].given : 0.0;
    const auto carry = [&](std::size_t to, std::size_t by, const ThreadBend& bend, bool grows) {
      const Part& known = parts_[by];
      parts_[to].factor = grows ? known.factor * bend.growth : known.factor / bend.growth;
      parts_[to].offset =
          grows ? known.offset * bend.growth + bend.channel : (known.offset - bend.channel) / bend.growth;
    };
    for (std::size_t k = from + 1; k < end; ++k) carry(k, k - 1, bends[k - 1], bends[k - 1].slides > 0);
    for (std::size_t k = from; k > first; --k) carry(k - 1, k, bends[k - 1], bends[k - 1].slides < 0);
    first = end;
  }
}

void ThreadTensions::find_tensions() {
  const std::size_t n = pieces.size();
  matrix_.assign(unknowns_ * unknowns_, 0.0);
  value_.assign(unknowns_, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t row = parts_[i].unknown;
    if (row == no_unknown) continue;
    value_[row] += pieces[i].longer;
    for (std::size_t j = 0; j < n; ++j) {
      if (parts_[j].slack) continue;
      value_[row] -= stiffness_[n * i + j] * parts_[j].offset;
      if (parts_[j].unknown == no_unknown) continue;
      matrix_[unknowns_ * row + parts_[j].unknown] += stiffness_[n * i + j] * parts_[j].factor;
    }
  }
  solve_dense(unknowns_, matrix_, value_);
  for (std::size_t i = 0; i < n; ++i) {
    pieces[i].tension = parts_[i].slack ? 0.0 : parts_[i].offset;
    if (parts_[i].unknown != no_unknown) pieces[i].tension += parts_[i].factor * value_[parts_[i].unknown];
  }
  for (std::size_t i = 0; i < n; ++i) {
    pieces[i].lacks = pieces[i].longer;
    for (std::size_t j = 0; j < n; ++j) pieces[i].lacks -= stiffness_[n * i + j] * pieces[j].tension;
  }
}

bool ThreadTensions::changes_slack() {
  bool changes = false;
  for (Part& part : parts_) {
    if (part.unknown == no_unknown || !(value_[part.unknown] < 0.0)) continue;
    part.slack = changes = true;
  }
  for (std::size_t first = 0; !changes && first < pieces.size();) {
    const std::size_t end = end_from(first);
    double lacks = 0.0;
    for (std::size_t k = first; k < end; ++k) lacks += pieces[k].lacks;
    if (parts_[first].slack && lacks > least_lack) {
      for (std::size_t k = first; k < end; ++k) parts_[k].slack = false;
      return true;
    }
    first = end;
  }
  return changes;
}

/// A knot lets thread through as long as it holds less than the thread pulls.
bool ThreadTensions::changes_knots() {
  bool changes = false;
  for (std::size_t k = segments(); k < pieces.size(); ++k) {
    ThreadPiece& knot = pieces[k];
    const bool slips = knot.given >= 0.0;
    if (slips ? knot.lacks >= -least_flow : !(knot.tension > knot.most)) continue;
    knot.given = slips ? -1.0 : knot.most;
    changes = true;
  }
  return changes;
}

/// Where thread would go the other way than it slides, or could do so only with a tension below 0.
bool ThreadTensions::stops_sliding() {
  for (std::size_t p = 0; p < bends.size(); ++p) {
    if (bends[p].slides == 0) continue;
    const std::size_t first = first_of_group(p), end = end_from(first), given = given_in(pieces, first, end);
    double flow = 0.0;  // toward the last tip
    for (std::size_t k = first; given > p && k <= p; ++k) flow -= pieces[k].lacks;
    for (std::size_t k = p + 1; given <= p && k < end; ++k) flow += pieces[k].lacks;
    const bool below_zero = std::min(pieces[p].tension, pieces[p + 1].tension) < 0.0;
    if (bends[p].slides * flow >= -least_flow && !below_zero) continue;
    bends[p].slides = 0;
    return true;
  }
  return false;
}

bool ThreadTensions::starts_sliding() {
  for (std::size_t p = 0; p < bends.size(); ++p) {
    if (bends[p].slides != 0 || bends[p].locked) continue;
    const auto [low, high] = std::minmax(pieces[p].tension, pieces[p + 1].tension);
    const double most = low * bends[p].growth + bends[p].channel;
    if (high <= most + of_tension * (high + least_tension)) continue;
    const std::size_t first = first_of_group(p), end = end_from(p + 1);
    if (given_in(pieces, first, p + 1) <= p && given_in(pieces, p + 1, end) < end) {  // which of them holds?
      std::size_t holds = first;
      while (holds + 1 < end && !(bends[holds].slides != 0 && bends[holds].channel > bends[p].channel)) ++holds;
      if (holds + 1 == end) continue;
      bends[holds].slides = 0;  // the stronger clamp
    }
    bends[p].slides = pieces[p + 1].tension > pieces[p].tension ? 1 : -1;
    for (std::size_t k = first; k < end; ++k) parts_[k].slack = false;
    return true;
  }
  return false;
}

void ThreadTensions::solve(TouchedParticles& touched) {
  find_couplings(touched);
  const std::size_t n = pieces.size();
  const double square = touched.dt() * touched.dt();
  stiffness_.resize(n * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) stiffness_[n * i + j] = square * between(pieces[i], pieces[j]);
    double& own = stiffness_[n * i + i];
    own += std::max(pieces[i].compliance, least_compliance * own);
  }
  for (std::size_t p = 0; p < bends.size(); ++p) {  // of the last step, when other tensions were given
    if (bends[p].slides == 0) continue;
    const std::size_t first = first_of_group(p), end = end_from(first), given = given_in(pieces, first, end);
    if (bends[p].locked || (given < end && given_in(pieces, given + 1, end) < end)) bends[p].slides = 0;
  }
  parts_.assign(n, {});
  const std::size_t rounds = rounds_per_piece * n + 4;
  for (std::size_t round = 0; round < rounds; ++round) {
    join_groups();
    find_tensions();
    if (!changes_slack() && !changes_knots() && !stops_sliding() && !starts_sliding()) break;
  }
  for (ThreadPiece& piece : pieces) piece.tension = std::max(piece.tension, 0.0);
}

}  // namespace phymul

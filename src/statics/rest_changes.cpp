// SPDX-License-Identifier: MIT
#include "rest_changes.h"

#include <cmath>

namespace phymul {
namespace {

constexpr std::size_t most_changes = 4;
constexpr double least_of_change = 0.3;  ///< that newer ones do not have
constexpr double most_times = 4.0;       ///< that a change is larger or smaller than what is lacking, or of no use
constexpr double least_of_lack = 0.5;    ///< of what newer ones leave of it, that is worth the error of a change

}  // namespace

void RestChanges::add(const Eigen::VectorXd& way, const Eigen::VectorXd& force) {
  if (!changes_.empty() && changes_.front().way.size() != way.size()) changes_.clear();
  changes_.insert(changes_.begin(), {way, force});
  if (changes_.size() > most_changes) changes_.pop_back();
}

bool RestChanges::find(const Eigen::VectorXd& lacks, Eigen::VectorXd& way) const {
  if (changes_.empty()) return false;
  way = Eigen::VectorXd::Zero(changes_.front().way.size());
  Eigen::VectorXd left = lacks;
  std::vector<Change> basis;  // of forces at right angles, of length 1
  for (Change change : changes_) {
    const double whole = change.force.norm();
    for (const Change& other : basis) {
      const double share = other.force.dot(change.force);
      change.force -= share * other.force;
      change.way -= share * other.way;
    }
    const double own = change.force.norm(), times = whole / lacks.norm();
    if (times > most_times || times * most_times < 1.0 || !(own > least_of_change * whole)) continue;
    change.way /= own;
    change.force /= own;
    const double share = change.force.dot(left);
    if (std::abs(share) < least_of_lack * left.norm()) continue;
    way += share * change.way;
    left -= share * change.force;
    basis.push_back(std::move(change));
  }
  return !basis.empty();
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include "rest_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/box_tree.h"
#include "rest_body.h"

namespace phymul {
namespace {

using Vector = Eigen::VectorXd;
constexpr double first_goal = 0.1;   ///< of a linear residual, before the true one is looked at
constexpr double worth_while = 0.3;  ///< a linear residual below this share of the true one's deviation is in vain
constexpr double worth_while_predicted = 0.7;  ///< likewise if it is predicted, which is mostly too low
constexpr double share_of_rest = 0.8;          ///< of the tolerance, for the linear residual
constexpr double share_of_miss = 0.1;          ///< of the miss of terms, for residuals before they are raised
constexpr double share_of_idle = 0.01;         ///< of the goal: a free motion with a smaller residual is left alone
constexpr double balanced = 1e-8;              ///< of the loads: likewise
constexpr int most_iterations = 60;            ///< of conjugate gradients
constexpr double most_change = 0.75;           ///< of a mean gradient in one step: rotation in rad, strain
constexpr double most_way = 0.25;              ///< of a particle in one step, in sizes of the body
constexpr double much_limited = 0.5;           ///< if less of the way is gone, any direction will do
constexpr double rough = 0.7;                  ///< a linear residual that will do if the way is limited at all
constexpr double little_change = 0.05;         ///< up to which the preconditioner stays
constexpr int first_power_steps = 3, power_steps = 2;
constexpr int most_trials = 12;  ///< of a line search
/// Of the forces that shear a particle's neighbourhood by 1: what rounding leaves of them.
constexpr double force_rounding = 1e-12;
constexpr double energy_rounding = 1e-11;  ///< of an energy

}  // namespace

class RestSearch {
 public:
  RestSearch(RestBody& body, const LoadFrame& loads, RestTerms terms, std::span<const ConnectedBody> loose,
             const StaticOptions& options, VecList& position)
      : body_(body),
        options_(options),
        predicts_(options.predict && loose.empty()),
        topology_(body.topology_),
        loads_(loads),
        terms_(terms),
        idle_(loose, loads, terms),
        position_(position),
        tangent_(*body.tangent_),
        grid_(body.grid_),
        path_(body.path_),
        load_(3 * topology_.particle_count),
        force_(position.size()),
        trial_(position.size()) {
    if (grid_.begin(terms) || !predicts_) body.turned_at_.clear();
    for (std::size_t i = 0; i < position.size(); ++i) {
      load_.segment<3>(3 * static_cast<Eigen::Index>(i)) = load_on(topology_.mass, loads, i);
    }
    double shear = 0.0;
    for (const DomainTexel& domain : topology_.domains) {
      shear += topology_.energies[domain.energy][0] / std::pow(domain.inverse_volume, 2.0 / 3.0);
    }
    most_way_ = most_way * bounding_box(topology_.rest).diagonal().norm();
    floor_ = force_rounding * shear / std::sqrt(static_cast<double>(topology_.particle_count));
  }

  RestSearchEnd run() {
    RestSearchEnd end;
    residual_at(position_, residual_, gradients_);
    const Vector start = predicts_ ? sought() : Vector(), lacks = predicts_ ? lacking() : Vector();
    if (predicts_) predict(start, lacks);
    if (position_ == topology_.rest) {
      energy_ = 0.0;
      for (const RestTerm* term : terms_) *energy_ += term->energy(position_);
    }
    while (true) {
      const bool imposes = find_way_to_targets();
      const double law = options_.tolerance * scale_ + floor_, miss = miss_of_terms();
      goal_ = std::max(law, share_of_miss * miss);
      const bool settled = !imposes && std::isfinite(goal_) && residual_.norm() <= goal_;
      end.at_rest = settled && miss <= law;
      if (end.at_rest || end.stuck || evaluations() >= options_.most_evaluations) break;
      if (settled) {
        raise_terms();
        continue;
      }
      linearise();
      idle_.find(position_, grid_.free(), residual_, std::max(share_of_idle * goal_, balanced * scale_));
      find_direction(imposes);
      end.stuck = !(imposes ? impose() : descend());
    }
    end.evaluations = evaluations();
    end.residual = options_.tolerance * scale_ > floor_ ? residual_.norm() / scale_ : 0.0;
    for (Eigen::Index i = 0; i < residual_.size(); i += 3) {
      end.largest_force = std::max(end.largest_force, residual_.segment<3>(i).norm());
    }
    if (predicts_) remember(end, start, lacks);
    return end;
  }

 private:
  int evaluations() const { return forces_ + grid_.evaluations(); }

  /// And the mean gradients there.
  void residual_at(const VecList& x, Vector& r, std::vector<Mat3>& gradients) {
    for (Vec3& force : force_) force.setZero();
    body_.add_forces(x, force_, gradients);
    for (const RestTerm* term : terms_) term->add_forces(x, force_);
    ++forces_;
    r = load_;
    for (std::size_t i = 0; i < x.size(); ++i) r.segment<3>(3 * static_cast<Eigen::Index>(i)) += force_[i];
    r.array() *= grid_.free().array();
  }

  /// N: residual_, and the ways to where imposed coordinates shall be, by the stiffness of their particles.
  Vector lacking() {
    find_way_to_targets();
    Vector sum = residual_;
    for (std::size_t i = 0; i < loads_.fixed.size(); ++i) {
      sum.segment<3>(3 * static_cast<Eigen::Index>(i)) +=
          body_.diagonal_[i].trace() / 3.0 * imposed_way_.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
    return sum;
  }

  /// m and N: places, and what terms estimate.
  Vector sought() const {
    std::vector<double> all(position_.data()->data(), position_.data()->data() + load_.size());
    for (const RestTerm* term : terms_) term->append_estimates(all);
    return Eigen::Map<const Vector>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  void go_to(const Vector& sought) {
    std::copy_n(sought.data(), load_.size(), position_.data()->data());
    std::span<const double> estimates(sought.data() + load_.size(), sought.data() + sought.size());
    for (RestTerm* term : terms_) estimates = term->take_estimates(estimates);
    residual_at(position_, residual_, gradients_);
  }

  /// Goes where the last searches lead, unless the energy is higher there: it falls by the mean force times the way.
  /// Forces may grow there, those that volume and rotations have to do with, which soon fall again.
  void predict(const Vector& start, const Vector& lacks) {
    Vector way;
    if (lacks.isZero() || !body_.changes_.find(lacks, way) || way.size() != start.size()) return;
    direction_ = grid_.free().select(way.head(load_.size()), imposed_way_);
    bend_direction();
    way.head(load_.size()) = direction_;
    const Vector residual = residual_;
    go_to(start + way);
    const bool falls = (residual + residual_).dot(direction_) > 0.0;
    if (imposed_way_.isZero() ? falls : residual_.norm() < lacks.norm()) return;
    go_to(start);
  }

  void remember(const RestSearchEnd& end, const Vector& start, const Vector& lacks) {
    if (!end.at_rest) body_.changes_.clear();
    Vector way = sought() - start;
    if (!end.at_rest || way.isZero()) return;
    direction_ = way.head(load_.size());
    bend_direction();  // the tangent of the curve at its end, where the chord lags behind it
    way.head(load_.size()) = direction_;
    body_.changes_.add(way, lacks - lacking());
  }

  void bend_direction() {
    find_change();
    path_.bend(gradients_, change_, 1.0, bent_);
    direction_.array() += grid_.free().array() * bent_.array();
  }

  /// N: by how much terms miss their laws.
  double miss_of_terms() const {
    double sum = 0.0;
    for (const RestTerm* term : terms_) sum += term->squared_miss(position_);
    return std::sqrt(sum);
  }

  void raise_terms() {
    for (RestTerm* term : terms_) term->raise(position_);
    residual_at(position_, residual_, gradients_);
    energy_.reset();
    curvature_ = 0.0;
  }

  /// From the coordinates that are imposed to where they shall be; whether they are not there. Forces are those of
  /// position_ then: also finds what the residual is compared with.
  bool find_way_to_targets() {
    imposed_way_ = Vector::Zero(load_.size());
    double supports = 0.0;
    for (const RestTerm* term : terms_) supports += term->squared_support(position_);
    for (std::size_t i = 0; i < loads_.fixed.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        if ((loads_.fixed[i] >> axis & 1) == 0) continue;
        const double target = loads_.target[i][axis];
        imposed_way_[3 * static_cast<Eigen::Index>(i) + axis] = target - position_[i][axis];
        if (target != topology_.rest[i][axis]) supports += force_[i][axis] * force_[i][axis];
      }
    }
    scale_ = std::sqrt(grid_.free().cwiseProduct(load_).squaredNorm() + supports);
    return (imposed_way_.array() != 0.0).any();
  }

  void linearise() {
    const bool at_rest = std::ranges::all_of(gradients_, [](const Mat3& H) { return H == Mat3::Zero(); });
    tangent_.linearise(at_rest ? std::span<const Mat3>() : gradients_);
    for (RestTerm* term : terms_) term->linearise(position_);
    std::vector<Mat3>& turned_at = body_.turned_at_;
    double most = turned_at.empty() ? std::numeric_limits<double>::infinity() : 0.0;
    for (std::size_t d = 0; d < turned_at.size(); ++d) {
      most = std::max(most, (gradients_[d] - turned_at[d]).cwiseAbs().maxCoeff());
    }
    const bool stays = !grid_.follow_terms() && most <= little_change;
    keeps_way_ = stays && curvature_ > 0.0;
    if (stays) return;
    grid_.turn(gradients_);
    grid_.estimate_largest(turned_ ? power_steps : first_power_steps);
    turned_ = true;
    turned_at = gradients_;
  }

  void find_change() { body_.find_gradients(direction_, change_); }

  /// Solves K d = r for the direction d: first roughly, then further if the true residual at the end of d follows the
  /// linear one. By how much it deviates is known from the last step, or found by going there. Where the way along d is
  /// limited, a rough direction is good enough.
  void find_direction(bool imposes) {
    direction_ = imposed_way_;
    Vector r = residual_, z;
    if (imposes) {
      grid_.apply(imposed_way_, image_);
      r -= image_;
    }
    idle_.remove(r);
    if (keeps_way_) idle_.remove(way_);
    reached_ = false;
    double goal = std::max(first_goal * r.norm(), share_of_rest * goal_);
    bool looked = imposes, knows_change = false;
    for (int k = 0; k < most_iterations && evaluations() < options_.most_evaluations; ++k) {
      grid_.solve(r, z);
      idle_.remove(z);
      const bool goes_on = k > 0 || (keeps_way_ && !imposes);
      if (goes_on) {
        way_ = z - z.dot(image_of_way_) / curvature_ * way_;
      } else {
        way_ = z;
      }
      grid_.apply(way_, image_of_way_);
      idle_.remove(image_of_way_);
      curvature_ = way_.dot(image_of_way_);
      if (!(curvature_ > 0.0)) {
        if (k == 0) direction_ += z;
        break;
      }
      const double step = r.dot(way_) / curvature_;
      direction_ += step * way_;
      r -= step * image_of_way_;
      reached_ = false;
      knows_change = false;
      // Not after each iteration: to look takes as long as a force.
      if (limited_ && !imposes && r.norm() > goal && (k & (k + 1)) == 0) {
        find_change();
        knows_change = true;
        const double share = largest_share();
        if (share < much_limited || (share < 1.0 && r.norm() <= rough * residual_.norm())) break;
      }
      if (r.norm() <= goal) {
        if (looked) break;
        looked = true;
        double in_vain = worth_while_predicted * deviation_per_energy_ * direction_.dot(residual_ - r);
        if (deviation_per_energy_ == 0.0) {
          find_change();
          move(1.0);
          residual_at(trial_, next_residual_, next_gradients_);
          reached_ = true;
          in_vain = worth_while * (next_residual_ - r).norm();
        }
        goal = std::max(in_vain, share_of_rest * goal_);
        if (r.norm() <= goal) break;
      }
    }
    left_ = r;
    // What nothing holds but slack springs has a tangent that is as good as singular.
    if (!imposes && !(direction_.dot(residual_) > 0.0)) {
      grid_.solve(residual_, direction_);
      idle_.remove(direction_);
      reached_ = knows_change = false;
      left_ = residual_;
    }
    if (!reached_ && !knows_change) find_change();
  }

  double largest_share() const {
    double most = 0.0, way = 0.0;
    for (const Mat3& change : change_) most = std::max(most, change.cwiseAbs().maxCoeff());
    for (Eigen::Index i = 0; i < direction_.size(); i += 3) way = std::max(way, direction_.segment<3>(i).norm());
    return 1.0 / std::max({1.0, most / most_change, way / most_way_});
  }

  /// trial_: the place at `share` of the path along direction_.
  void move(double share) {
    path_.bend(gradients_, change_, share, bent_);
    bent_.array() *= grid_.free().array();
    idle_.remove(bent_);
    bent_ += share * direction_;
    for (std::size_t i = 0; i < trial_.size(); ++i) {
      trial_[i] = position_[i] + bent_.segment<3>(3 * static_cast<Eigen::Index>(i));
      if (share < 1.0 || loads_.fixed.empty()) continue;
      for (int axis = 0; axis < 3; ++axis) {
        if ((loads_.fixed[i] >> axis & 1) != 0) trial_[i][axis] = loads_.target[i][axis];
      }
    }
  }

  void take_trial() {
    std::swap(position_, trial_);
    std::swap(gradients_, next_gradients_);
    residual_ = next_residual_;
  }

  /// A part of the way to the targets, as large as the deformation allows. The energy may grow.
  bool impose() {
    move(largest_share());
    residual_at(trial_, next_residual_, next_gradients_);
    take_trial();
    energy_.reset();
    return residual_.allFinite();
  }

  /// Whether there is a step that makes the residual or the energy smaller.
  bool descend() {
    double share = largest_share();
    limited_ = share < 1.0;
    const double slope = -residual_.dot(direction_);
    for (int k = 0; k < most_trials; ++k) {
      if (!reached_ || share < 1.0 || k > 0) {
        move(share);
        residual_at(trial_, next_residual_, next_gradients_);
      }
      const double next_slope = -next_residual_.dot(direction_);
      std::optional<double> energy;
      if (!(next_residual_.norm() < 0.5 * residual_.norm())) {
        if (!energy_) energy_ = potential_energy(topology_, loads_, terms_, position_);
        energy = potential_energy(topology_, loads_, terms_, trial_);
        const bool overshoots = !(next_slope < 0.9 * std::abs(slope));
        // Near rest the energies differ by less than their rounding.
        const bool closer =
            share * std::abs(slope) < energy_rounding * std::abs(*energy_) && next_residual_.norm() < residual_.norm();
        if (!closer && (!(*energy <= *energy_ + 1e-4 * share * slope) || overshoots)) {
          const double secant = slope / (slope - next_slope);
          share *= next_slope > 0.0 ? std::clamp(secant, 0.1, 0.6) : 0.3;
          continue;
        }
      }
      // Both are of second order in the direction, but for where contacts change.
      const double energy_of_way = share == 1.0 && terms_.empty() ? direction_.dot(residual_ - left_) : 0.0;
      deviation_per_energy_ = energy_of_way > 0.0 ? (next_residual_ - left_).norm() / energy_of_way : 0.0;
      take_trial();
      energy_ = energy;
      return true;
    }
    residual_at(position_, residual_, gradients_);
    return false;
  }

  RestBody& body_;
  const StaticOptions& options_;
  const bool predicts_;
  const TopologyTextures& topology_;
  const LoadFrame& loads_;
  RestTerms terms_;
  IdleMotions idle_;
  VecList& position_;
  Tangent& tangent_;
  Multigrid& grid_;
  TurningPath& path_;
  Vector load_;
  VecList force_, trial_;
  int forces_ = 0;
  double floor_ = 0.0, scale_ = 0.0, goal_ = 0.0;  // N
  double most_way_ = 0.0;                          // m
  Vector residual_, next_residual_, direction_, imposed_way_, image_, bent_;
  Vector way_, image_of_way_;  // of conjugate gradients
  Vector left_;                // the linear residual at the end of direction_
  double curvature_ = 0.0;
  double deviation_per_energy_ = 0.0;  // 1/m: of the true residual from the linear one, in the last step; 0: unknown
  bool turned_ = false;                // grid_, in this search
  bool keeps_way_ = false;
  bool limited_ = true;   // largest_share() was less than 1 when last asked for a descent; or none was yet
  bool reached_ = false;  // trial_ and next_residual_ are those at the end of direction_
  std::vector<Mat3> gradients_, next_gradients_, change_;
  std::optional<double> energy_;  // of position_, where known
};

RestSearchEnd search_rest(RestBody& body, const LoadFrame& loads, RestTerms terms, std::span<const ConnectedBody> loose,
                          const StaticOptions& options, VecList& position) {
  return RestSearch(body, loads, terms, loose, options, position).run();
}

}  // namespace phymul

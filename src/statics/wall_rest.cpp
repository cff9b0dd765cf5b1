// SPDX-License-Identifier: MIT
#include "rest_search.h"

#include <phymul/elasticity.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "elastic/force_wall.h"

namespace phymul {
namespace {

constexpr double most_turn = 0.3;             ///< of an edge in one step: difference of its ends over its length
constexpr int patience = 8;                   ///< steps that need not lower the energy
constexpr int most_halvings = 30;             ///< of a line search
constexpr double least_slope = 1e-4;          ///< of what the slope of the energy promises
constexpr double rounding_of_forces = 1e-12;  ///< of those that stretch a triangle by 1

using WallMatrix = Eigen::SparseMatrix<double>;
using WallEntries = std::vector<Eigen::Triplet<double>>;

class WallSearch {
 public:
  WallSearch(const TopologyTextures& topology, const LoadFrame& loads, VecList& position)
      : t_(topology), loads_(loads), x_(position), force_(position.size()) {
    const auto count = static_cast<Eigen::Index>(3 * position.size());
    load_.resize(count);
    free_ = Eigen::VectorXd::Ones(count);
    for (std::size_t i = 0; i < position.size(); ++i) {
      load_.segment<3>(3 * static_cast<Eigen::Index>(i)) = load_on(topology.mass, loads, i);
      for (int axis = 0; axis < 3 && !loads.fixed.empty(); ++axis) {
        if ((loads.fixed[i] >> axis & 1) != 0) free_[3 * static_cast<Eigen::Index>(i) + axis] = 0.0;
      }
    }
    for (const WallTexel& wall : t_.walls) {
      floor_ = std::max(floor_, rounding_of_forces * wall.shear * std::hypot(wall.gradient[1][0], wall.gradient[1][1]));
    }
    floor_ *= std::sqrt(static_cast<double>(position.size()));
  }

  RestSearchEnd run(double tolerance, int most_evaluations) {
    RestSearchEnd end;
    look();
    keep_best();
    while (true) {
      const Eigen::VectorXd way = way_to_targets();
      const bool imposes = (way.array() != 0.0).any();
      end.at_rest = !imposes && std::isfinite(scale_) && residual_.norm() <= tolerance * scale_ + floor_;
      if (end.at_rest || end.stuck || evaluations_ >= most_evaluations) break;
      if (imposes) {
        impose(way);
        keep_best();
      } else if (since_best_ < patience) {
        const Eigen::VectorXd step = direction(residual_);
        go(x_, largest_share(step) * step);
        look();
        if (energy_ < best_energy_ || residual_.norm() < 0.5 * best_residual_) {
          keep_best();
        } else {
          ++since_best_;
        }
      } else {
        x_ = best_;
        look();
        end.stuck = !descend();
      }
    }
    end.evaluations = evaluations_;
    const bool is_rounding = end.at_rest && !(tolerance * scale_ > floor_);
    end.residual = is_rounding ? 0.0 : residual_.norm() / std::max(scale_, floor_ / tolerance);
    for (Eigen::Index i = 0; i < residual_.size(); i += 3) {
      end.largest_force = std::max(end.largest_force, residual_.segment<3>(i).norm());
    }
    return end;
  }

 private:
  /// Forces, residual and energy at x_, and what the residual is compared with.
  void look() {
    elastic_forces(t_, x_, force_);
    ++evaluations_;
    residual_ = load_;
    double supports = 0.0;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const auto at = 3 * static_cast<Eigen::Index>(i);
      residual_.segment<3>(at) += force_[i];
      for (int axis = 0; axis < 3; ++axis) {
        if (free_[at + axis] == 0.0 && loads_.target[i][axis] != t_.rest[i][axis]) {
          supports += force_[i][axis] * force_[i][axis];
        }
      }
    }
    residual_.array() *= free_.array();
    scale_ = std::sqrt(free_.cwiseProduct(load_).squaredNorm() + supports);
    energy_ = potential_energy(t_, loads_, {}, x_);
  }

  void keep_best() {
    best_ = x_;
    best_energy_ = energy_;
    best_residual_ = residual_.norm();
    since_best_ = 0;
  }

  Eigen::VectorXd way_to_targets() const {
    Eigen::VectorXd way = Eigen::VectorXd::Zero(free_.size());
    for (Eigen::Index k = 0; k < way.size(); ++k) {
      const auto i = static_cast<std::size_t>(k / 3);
      if (free_[k] == 0.0) way[k] = loads_.target[i][k % 3] - x_[i][k % 3];
    }
    return way;
  }

  /// A part of the way to the targets, as large as the deformation allows, and the free particles after it. The energy
  /// may grow.
  void impose(const Eigen::VectorXd& way) {
    const WallMatrix K = tangent(false);
    const Eigen::VectorXd step = way + direction(free_.cwiseProduct(residual_ - K * way));
    const double share = largest_share(step);
    go(x_, share * step);
    for (Eigen::Index k = 0; share == 1.0 && k < way.size(); ++k) {
      const auto i = static_cast<std::size_t>(k / 3);
      if (free_[k] == 0.0) x_[i][k % 3] = loads_.target[i][k % 3];
    }
    look();
  }

  bool descend() {
    const Eigen::VectorXd step = direction(residual_);
    const double slope = residual_.dot(step);
    double share = largest_share(step);
    for (int k = 0; k < most_halvings; ++k, share *= 0.5) {
      x_ = best_;
      go(x_, share * step);
      look();
      if (energy_ <= best_energy_ - least_slope * share * slope || residual_.norm() < 0.5 * best_residual_) {
        keep_best();
        return true;
      }
    }
    x_ = best_;
    look();
    return false;
  }

  static void go(VecList& x, const Eigen::VectorXd& step) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += step.segment<3>(3 * static_cast<Eigen::Index>(i));
  }

  double largest_share(const Eigen::VectorXd& step) const {
    double most = 0.0;
    for (const WallTexel& wall : t_.walls) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = wall.vertex[k], b = wall.vertex[(k + 1) % 3];
        const double turn = (step.segment<3>(3 * a) - step.segment<3>(3 * b)).norm();
        most = std::max(most, turn / (x_[a] - x_[b]).norm());
      }
    }
    return std::min(1.0, most_turn / most);
  }

  /// K^-1 r; where K has a direction in which the energy falls, with as much added to its diagonal as takes that away.
  Eigen::VectorXd direction(const Eigen::VectorXd& r) {
    const WallMatrix K = tangent(true);
    double mean = 0.0;
    for (Eigen::Index k = 0; k < K.rows(); ++k) mean += K.coeff(k, k) / static_cast<double>(K.rows());
    if (!analysed_) {
      factors_.analyzePattern(K);
      analysed_ = true;
    }
    for (double more = 0.0;; more = std::max(10.0 * more, 1e-8 * mean)) {
      factors_.setShift(more);
      factors_.factorize(K);
      const bool falls = factors_.info() == Eigen::Success && factors_.vectorD().minCoeff() > 0.0;
      if (falls || !(more < 1e3 * mean)) return factors_.solve(r);
    }
  }

  /// `alone`: of the free coordinates, and 1 for the others.
  WallMatrix tangent(bool alone) {
    WallEntries entries;
    entries.reserve(324 * t_.walls.size());
    for (const WallTexel& wall : t_.walls) add_tangent(wall, alone, entries);
    for (Eigen::Index k = 0; alone && k < free_.size(); ++k) {
      if (free_[k] == 0.0) entries.emplace_back(static_cast<int>(k), static_cast<int>(k), 1.0);
    }
    WallMatrix K(free_.size(), free_.size());
    K.setFromTriplets(entries.begin(), entries.end());
    ++evaluations_;
    return K;
  }

  void add_tangent(const WallTexel& wall, bool alone, WallEntries& entries) const {
    WallTexel own = wall;
    std::array<Vec3, 6> rest, at;
    rest.fill(Vec3::Zero());
    at.fill(Vec3::Zero());
    double size = 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
      if (wall.vertex[k] == none) continue;
      own.vertex[k] = static_cast<Index>(k);
      rest[k] = t_.rest[wall.vertex[k]];
      at[k] = x_[wall.vertex[k]];
      size = std::max(size, (rest[k] - rest[0]).norm());
    }
    const double h = 1e-6 * size;
    Eigen::Matrix<double, 18, 18> K = Eigen::Matrix<double, 18, 18>::Zero();
    for (int c = 0; c < 18; ++c) {
      if (wall.vertex[static_cast<std::size_t>(c / 3)] == none) continue;
      std::array<Vec3, 6> moved = at, plus, minus;
      plus.fill(Vec3::Zero());
      minus.fill(Vec3::Zero());
      moved[static_cast<std::size_t>(c / 3)][c % 3] += h;
      wall_energy(own, rest, moved, plus);
      moved[static_cast<std::size_t>(c / 3)][c % 3] = at[static_cast<std::size_t>(c / 3)][c % 3] - h;
      wall_energy(own, rest, moved, minus);
      for (int k = 0; k < 6; ++k) {
        K.block<3, 1>(3 * k, c) = (minus[static_cast<std::size_t>(k)] - plus[static_cast<std::size_t>(k)]) / (2.0 * h);
      }
    }
    for (int r = 0; r < 18; ++r) {
      const Index i = wall.vertex[static_cast<std::size_t>(r / 3)];
      if (i == none || (alone && free_[3 * i + r % 3] == 0.0)) continue;
      for (int c = 0; c < 18; ++c) {
        const Index j = wall.vertex[static_cast<std::size_t>(c / 3)];
        if (j == none || (alone && free_[3 * j + c % 3] == 0.0)) continue;
        entries.emplace_back(3 * i + r % 3, 3 * j + c % 3, 0.5 * (K(r, c) + K(c, r)));
      }
    }
  }

  const TopologyTextures& t_;
  const LoadFrame& loads_;
  VecList& x_;
  VecList force_, best_;
  Eigen::VectorXd load_, free_, residual_;
  double energy_ = 0.0, scale_ = 0.0, floor_ = 0.0, best_energy_ = 0.0, best_residual_ = 0.0;
  int evaluations_ = 0, since_best_ = 0;
  bool analysed_ = false;
  Eigen::SimplicialLDLT<WallMatrix> factors_;
};

}  // namespace

RestSearchEnd search_wall_rest(const TopologyTextures& topology, const LoadFrame& loads, double tolerance,
                               int most_evaluations, VecList& position) {
  return WallSearch(topology, loads, position).run(tolerance, most_evaluations);
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include "rest_body.h"

#include <phymul/elasticity.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/symmetric_modes.h"
#include "elastic/domain_forces.h"

namespace phymul {
namespace {

constexpr std::size_t most_changes = 4;
constexpr double least_of_change = 0.3;  ///< that newer ones do not have
constexpr double most_times = 4.0;       ///< that a change is larger or smaller than what is lacking, or of no use
constexpr double least_of_lack = 0.5;    ///< of what newer ones leave of it, that is worth the error of a change

}  // namespace

TurningPath::TurningPath(const TopologyTextures& topology, const GridLevel& level) : level_(level) {
  for (const Vec3& rest : topology.rest) places_.push_back(level.place_of(rest));
  Eigen::SparseMatrix<double> last;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::SparseMatrix<double> matrix = level.laplacian(axis);
    const bool same = axis > 0 && std::equal(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros(), last.valuePtr());
    if (!same) solvers_[axis] = std::make_unique<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(matrix);
    last.swap(matrix);
  }
}

void TurningPath::bend(std::span<const Mat3> at, std::span<const Mat3> change, double share, Eigen::VectorXd& added) {
  missing_.assign(at.size(), Mat3::Zero());
  for (std::size_t k = 0; k < at.size(); ++k) {
    const Mat3 F = Mat3::Identity() + at[k];
    if (!(F.determinant() > 0.1)) continue;  // a collapsed or inverted domain has no rotation to speak of
    const Mat3 L = share * change[k] * F.inverse();
    const Vec3 axial(0.5 * (L(2, 1) - L(1, 2)), 0.5 * (L(0, 2) - L(2, 0)), 0.5 * (L(1, 0) - L(0, 1)));
    const double angle = axial.norm();
    if (!(angle > 0.0)) continue;
    const Mat3 turn = Eigen::AngleAxisd(angle, axial / angle).toRotationMatrix();
    const Mat3 strain = 0.5 * (L + L.transpose());
    missing_[k] = turn * (F + strain * F) - F - share * change[k];
  }
  Eigen::VectorXd b;
  level_.sources(missing_, b);
  Eigen::VectorXd at_nodes(b.size());
  const auto* solver = solvers_.front().get();
  for (int axis = 0; axis < 3; ++axis) {
    if (solvers_[axis] != nullptr) solver = solvers_[axis].get();
    const Eigen::VectorXd along = b(Eigen::seqN(axis, level_.nodes(), 3));
    at_nodes(Eigen::seqN(axis, level_.nodes(), 3)) = solver->solve(along).eval();
  }
  added.resize(3 * static_cast<Eigen::Index>(places_.size()));
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Vec3 value = Vec3::Zero();
    for (int a = 0; a < 8; ++a)
      value += static_cast<double>(places_[i].weight[a]) * at_nodes.segment<3>(3 * places_[i].node[a]);
    added.segment<3>(3 * static_cast<Eigen::Index>(i)) = value;
  }
}

constexpr Index path_nodes = 600;  ///< of the grid that paths bend on, at most

RestBody::RestBody(const TopologyTextures& topology, std::span<const std::uint8_t> fixed)
    : topology_(topology),
      diagonal_(diagonal_at_rest(topology)),
      tangent_(make_tangent(topology)),
      grid_(topology, fixed, diagonal_, *tangent_),
      path_(topology, grid_.finest_of(path_nodes)),
      of_domains_(topology.domains.size()) {}

void RestBody::add_forces(const VecList& x, std::span<Vec3> force, std::vector<Mat3>& gradients) {
  std::ranges::transform(topology_.domains, of_domains_.begin(), [&](const DomainTexel& domain) -> Vec3 {
    return x[domain.particle] - topology_.rest[domain.particle];
  });
  gradients.resize(of_domains_.size());
  add_domain_forces(
      topology_, [this](Index e) -> const Vec3& { return of_domains_[e]; }, {}, force,
      [&](Index d, const Mat3& H) { gradients[d] = H; });
}

void RestBody::find_gradients(const Eigen::VectorXd& displacement, std::vector<Mat3>& gradients) {
  std::ranges::transform(topology_.domains, of_domains_.begin(), [&](const DomainTexel& domain) -> Vec3 {
    return displacement.segment<3>(3 * static_cast<Eigen::Index>(domain.particle));
  });
  gradients.resize(of_domains_.size());
  for (std::size_t d = 0; d < gradients.size(); ++d) {
    gradients[d] =
        mean_gradient(topology_, static_cast<Index>(d), [this](Index e) -> const Vec3& { return of_domains_[e]; });
  }
}

double potential_energy(const TopologyTextures& topology, const LoadFrame& loads, RestTerms terms,
                        const VecList& position) {
  double energy = elastic_energy(topology, position);
  for (const RestTerm* term : terms) energy += term->energy(position);
  for (std::size_t i = 0; i < position.size(); ++i) {
    energy -= load_on(topology.mass, loads, i).dot(position[i] - topology.rest[i]);
  }
  return energy;
}

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

namespace {

/// Of the largest resistance that supports give to a rigid motion: less is none.
constexpr double unsupported = 1e-9;

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Of what terms resist a rigid motion with at most: less is rounding.
constexpr double unresisted_share = 1e-9;

/// Those of these particles.
Vector part_of(const Vector& v, std::span<const Index> particles) {
  Vector part(3 * static_cast<Eigen::Index>(particles.size()));
  for (std::size_t k = 0; k < particles.size(); ++k) {
    part.segment<3>(3 * static_cast<Eigen::Index>(k)) = v.segment<3>(3 * static_cast<Eigen::Index>(particles[k]));
  }
  return part;
}

}  // namespace

std::vector<RigidMotion> free_motions(std::span<const Index> particles, std::span<const Vec3> position,
                                      std::span<const std::uint8_t> fixed) {
  Vec3 centre = Vec3::Zero();
  for (const Index i : particles) centre += position[i] / static_cast<double>(particles.size());
  double size = 1e-300;  // of a single particle
  for (const Index i : particles) size = std::max(size, (position[i] - centre).norm());
  Eigen::MatrixXd support = Eigen::MatrixXd::Zero(6, 6);
  for (const Index i : particles) {
    for (int axis = 0; axis < 3 && !fixed.empty(); ++axis) {
      if ((fixed[i] >> axis & 1) == 0) continue;
      Eigen::Matrix<double, 6, 1> along;  // how far shift and turn * size displace the particle along the axis
      along << Vec3::Unit(axis), (position[i] - centre).cross(Vec3::Unit(axis)) / size;
      support += along * along.transpose();
    }
  }
  const SymmetricModes modes = symmetric_modes(support);
  const double largest = std::max(1.0, modes.values[5]);
  std::vector<RigidMotion> motions;
  for (int k = 0; k < 6; ++k) {
    if (modes.values[k] > unsupported * largest) continue;
    const auto mode = modes.vectors.col(k);
    motions.push_back({centre, mode.head<3>(), mode.tail<3>() / size});
  }
  return motions;
}

/// Of the motions that no imposed coordinate resists, combinations that no term resists. [3 particles, motions]
Matrix IdleMotions::unresisted(const ConnectedBody& body, std::span<const Vec3> position, const Vector& free) const {
  const std::vector<RigidMotion> motions = free_motions(body.particles, position, loads_.fixed);
  Matrix along(3 * static_cast<Eigen::Index>(body.particles.size()), static_cast<Eigen::Index>(motions.size()));
  Matrix resisted = along;
  Vector d, force;
  for (Eigen::Index m = 0; m < along.cols(); ++m) {
    d = force = Vector::Zero(free.size());
    for (const Index i : body.particles) {
      d.segment<3>(3 * static_cast<Eigen::Index>(i)) = motions[static_cast<std::size_t>(m)].at(position[i]);
    }
    d.array() *= free.array();
    for (const RestTerm* term : terms_) term->add_product(d, force);
    along.col(m) = part_of(d, body.particles);
    resisted.col(m) = part_of(force, body.particles);
  }
  if (along.cols() == 0) return along;
  const SymmetricModes modes = symmetric_modes(along.transpose().lazyProduct(resisted));
  const Vector& resistance = modes.values;
  Eigen::Index count = 0;
  while (count < resistance.size() && !(resistance[count] > unresisted_share * resistance[resistance.size() - 1])) {
    ++count;
  }
  return along.lazyProduct(modes.vectors.leftCols(count));
}

void IdleMotions::find(std::span<const Vec3> position, const Vector& free, const Vector& residual, double idle) {
  idle_.clear();
  for (const ConnectedBody& body : loose_) {
    const Matrix motions = unresisted(body, position, free);
    const Vector own = part_of(residual, body.particles);
    OfBody found{body.particles, Matrix(motions.rows(), 0)};
    for (Eigen::Index m = 0; m < motions.cols(); ++m) {
      Vector along = motions.col(m);
      along -= found.along * (found.along.transpose() * along).eval();
      along.normalize();
      if (std::abs(along.dot(own)) > idle) continue;
      found.along.conservativeResize(Eigen::NoChange, found.along.cols() + 1);
      found.along.rightCols<1>() = along;
    }
    if (found.along.cols() > 0) idle_.push_back(std::move(found));
  }
}

void IdleMotions::remove(Vector& v) const {
  for (const OfBody& body : idle_) {
    const Vector part = body.along * (body.along.transpose() * part_of(v, body.particles)).eval();
    for (std::size_t k = 0; k < body.particles.size(); ++k) {
      v.segment<3>(3 * static_cast<Eigen::Index>(body.particles[k])) -=
          part.segment<3>(3 * static_cast<Eigen::Index>(k));
    }
  }
}

}  // namespace phymul

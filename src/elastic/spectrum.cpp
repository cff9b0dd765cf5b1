// SPDX-License-Identifier: MIT
//
// Extreme eigenvalues of M^-1 K, K = -df/dx by central differences of the elastic forces along a direction, or, at
// rest, from the tables of Law::particle_averaged. Lanczos works on the symmetric M^-1/2 K M^-1/2, Arnoldi on the same
// similarity transform of an unsymmetric K. Source: Golub & Van Loan, Matrix Computations, ch. 10.
#include <phymul/elasticity.h>
#include <phymul/error.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <future>
#include <limits>
#include <optional>
#include <random>
#include <thread>

#include "averaged_stiffness.h"

namespace phymul {
namespace {

using Vector = Eigen::VectorXd;

/// Ritz values are taken when their residuals are below this share of the largest; eigenvalues are then nearer than
/// that.
constexpr double ritz_accuracy = 1e-3;
/// Eigenvalues nearer to 0 than this share of the largest are those of rigid motion, on either side of 0 by rounding.
constexpr double rigid_motion = 1e-6;
constexpr int lanczos_steps = 400;
/// Stiffness over mass leaves the numbers: no step is small enough.
constexpr Spectrum out_of_range{.largest = std::numeric_limits<double>::infinity()};
/// Arnoldi keeps every vector: as many as fit in this many bytes, within [12, 80].
constexpr double arnoldi_bytes = 4e8;
/// From so many particles on, forces on both sides of a difference are found side by side: far more work than starting
/// a thread.
constexpr Index worth_a_thread = 500;

double rest_spacing(const TopologyTextures& topology) {
  double sum = 0.0;
  std::size_t count = 0;
  const auto add = [&](Index a, Index b) {
    sum += (topology.rest[a] - topology.rest[b]).norm();
    ++count;
  };
  for (Index i = 0; i < topology.particle_count; ++i) {
    const IndexTexel& at = topology.index[i];
    for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) add(i, topology.neighbours[r]);
  }
  for (const SpringTexel& spring : topology.springs) add(spring.end[0], spring.end[1]);
  for (const VolumeTexel& term : topology.volumes) add(term.vertex[0], term.vertex[1]);
  if (count > 0) return sum / static_cast<double>(count);
  // Law::particle_averaged needs no neighbours: its cells make the body.
  for (std::size_t d = 0; d < topology.domains.size(); ++d) {
    for (Index r = topology.first_link[d]; r < topology.first_link[d + 1]; ++r) {
      add(topology.domains[d].particle, topology.domains[topology.links[r].domain].particle);
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

/// The operator q -> M^-1/2 K M^-1/2 q, free coordinates only.
class ScaledStiffness {
 public:
  ScaledStiffness(const TopologyTextures& topology, std::span<const Vec3> position, std::span<const std::uint8_t> fixed)
      : topology_(topology),
        position_(position),
        spacing_(rest_spacing(topology)),
        scale_(Vector::Zero(3 * topology.particle_count)),
        side_by_side_(topology.particle_count >= worth_a_thread && std::thread::hardware_concurrency() > 1) {
    if (AveragedStiffness::is_all_of(topology) && std::ranges::equal(position, topology.rest)) {
      at_rest_.emplace(topology);
    } else {
      plus_.resize(position.size());
      minus_.resize(position.size());
    }
    for (Index i = 0; i < topology.particle_count; ++i) {
      for (int axis = 0; axis < topology.dimension; ++axis) {
        const bool free = fixed.empty() || (fixed[i] >> axis & 1) == 0;
        if (free) scale_[3 * i + axis] = 1.0 / std::sqrt(topology.mass[i]);
      }
    }
  }

  double spacing() const { return spacing_; }

  void project(Vector& q) const { q = (scale_.array() > 0).select(q, 0.0); }

  void apply(const Vector& q, Vector& result) {
    const Vector direction = scale_.cwiseProduct(q);
    if (at_rest_) {
      at_rest_->apply(direction, result);
      result.array() *= scale_.array();
    } else {
      apply_differences(direction, result);
    }
  }

 private:
  struct Side {
    VecList moved, force;
    void resize(std::size_t count) {
      moved.resize(count);
      force.resize(count);
    }
  };

  void apply_differences(const Vector& direction, Vector& result) {
    const double largest = direction.cwiseAbs().maxCoeff();
    result.setZero(direction.size());
    if (largest == 0.0) return;
    // Truncation falls as step^2, rounding grows as 1/step: 1e-4 of the spacing keeps both near 1e-8.
    const double step = 1e-4 * spacing_ / largest;
    if (side_by_side_) {
      auto other = std::async(std::launch::async | std::launch::deferred, [&] { force_at(direction, -step, minus_); });
      force_at(direction, step, plus_);
      other.get();
    } else {
      force_at(direction, step, plus_);
      force_at(direction, -step, minus_);
    }
    for (Index i = 0; i < topology_.particle_count; ++i) {
      const Vec3 stiffness = (minus_.force[i] - plus_.force[i]) / (2.0 * step);
      result.segment<3>(3 * i) = scale_.segment<3>(3 * i).cwiseProduct(stiffness);
    }
  }

  void force_at(const Vector& direction, double step, Side& side) const {
    for (Index i = 0; i < topology_.particle_count; ++i) {
      side.moved[i] = position_[i] + step * direction.segment<3>(3 * i);
    }
    elastic_forces(topology_, side.moved, side.force);
  }

  const TopologyTextures& topology_;
  std::span<const Vec3> position_;
  double spacing_;
  Vector scale_;
  bool side_by_side_;
  std::optional<AveragedStiffness> at_rest_;
  Side plus_, minus_;  // empty where at_rest_ serves
};

/// Fixed, and from the generator's bits alone: the same on every machine.
Vector start_vector(Eigen::Index size) {
  std::mt19937 bits(20071);
  Vector q(size);
  for (Eigen::Index k = 0; k < size; ++k) q[k] = static_cast<double>(bits()) / 4294967296.0 - 0.5;
  return q;
}

Spectrum lanczos(ScaledStiffness& A, Vector q) {
  std::vector<double> diagonal, off;
  Vector before = Vector::Zero(q.size()), image(q.size());
  Spectrum found;
  for (int step = 0; step < lanczos_steps; ++step) {
    A.apply(q, image);
    diagonal.push_back(q.dot(image));
    image -= diagonal.back() * q;
    if (step > 0) image -= off.back() * before;
    const double beta = image.norm();
    if (!std::isfinite(beta)) return out_of_range;

    const bool look = step % 5 == 4 || step + 1 == lanczos_steps || beta == 0.0;
    if (look) {
      const auto size = static_cast<Eigen::Index>(diagonal.size());
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
      ritz.computeFromTridiagonal(Eigen::Map<Vector>(diagonal.data(), size), Eigen::Map<Vector>(off.data(), size - 1));
      const auto& values = ritz.eigenvalues();
      const Eigen::Index top = std::abs(values[0]) > std::abs(values[size - 1]) ? 0 : size - 1;
      found.largest = std::abs(values[top]);
      found.most_negative = values[0];
      // A negative end must settle as well. Where none shows, waiting for one would cost a body at rest thrice the
      // steps.
      const auto last = ritz.eigenvectors().row(size - 1);
      const bool grows = values[0] < -rigid_motion * found.largest;
      const double residual = beta * std::max(std::abs(last[top]), grows ? std::abs(last[0]) : 0.0);
      if (residual <= ritz_accuracy * found.largest) break;
    }
    off.push_back(beta);
    before.swap(q);
    q = image / beta;
  }
  return found;
}

/// Of an upper Hessenberg matrix. Eigen::EigenSolver would reduce it to that form first, and takes far longer to
/// compile.
Spectrum spectrum_of(const Eigen::MatrixXd& hessenberg) {
  Spectrum found;
  const double scale = hessenberg.cwiseAbs().maxCoeff();
  if (scale == 0.0) return found;
  const Eigen::Index size = hessenberg.rows();
  const Eigen::MatrixXd scaled = hessenberg / scale;
  Eigen::RealSchur<Eigen::MatrixXd> schur(size);
  schur.computeFromHessenberg(scaled, scaled, false);
  const Eigen::MatrixXd T = schur.matrixT() * scale;
  for (Eigen::Index i = 0; i < size; ++i) {
    std::complex<double> value = T(i, i);
    if (i + 1 < size && T(i + 1, i) != 0.0) {  // a block of two rows on the diagonal: a conjugate pair
      const double half = 0.5 * (T(i, i) - T(i + 1, i + 1));
      const double most = std::max({std::abs(half), std::abs(T(i + 1, i)), std::abs(T(i, i + 1))});
      const double h = half / most;
      value = {T(i + 1, i + 1) + half, most * std::sqrt(std::abs(h * h + T(i + 1, i) / most * (T(i, i + 1) / most)))};
      ++i;
    }
    found.largest = std::max(found.largest, std::abs(value));
    found.most_negative = std::min(found.most_negative, value.real());
    found.largest_imaginary = std::max(found.largest_imaginary, std::abs(value.imag()));
  }
  return found;
}

Spectrum arnoldi(ScaledStiffness& A, const Vector& q) {
  const double vector_bytes = 8.0 * static_cast<double>(q.size());
  const auto steps = std::min<Eigen::Index>(
      q.size(), std::clamp<Eigen::Index>(static_cast<Eigen::Index>(arnoldi_bytes / vector_bytes), 12, 80));
  Eigen::MatrixXd basis(q.size(), steps + 1);
  Eigen::MatrixXd hessenberg = Eigen::MatrixXd::Zero(steps + 1, steps);
  basis.col(0) = q;
  Vector image(q.size());
  Eigen::Index used = steps;
  for (Eigen::Index step = 0; step < steps; ++step) {
    A.apply(basis.col(step), image);
    for (Eigen::Index k = 0; k <= step; ++k) {
      hessenberg(k, step) = basis.col(k).dot(image);
      image -= hessenberg(k, step) * basis.col(k);
    }
    const double beta = image.norm();
    if (!std::isfinite(beta)) return out_of_range;
    hessenberg(step + 1, step) = beta;
    if (beta <= 1e-12 * hessenberg.topLeftCorner(step + 1, step + 1).norm()) {
      used = step + 1;
      break;
    }
    basis.col(step + 1) = image / beta;
  }
  return spectrum_of(hessenberg.topLeftCorner(used, used));
}

}  // namespace

Spectrum estimate_spectrum(const TopologyTextures& topology, std::span<const Vec3> position,
                           std::span<const std::uint8_t> fixed) {
  const auto count = static_cast<std::size_t>(topology.particle_count);
  if (position.size() != count || (!fixed.empty() && fixed.size() != count)) {
    throw Error("estimate_spectrum: expected " + std::to_string(count) +
                " positions and as many fixed marks or none, got " + std::to_string(position.size()) + " and " +
                std::to_string(fixed.size()));
  }
  for (Index i = 0; i < topology.particle_count; ++i) {
    if (!position[i].allFinite()) {
      throw Error("estimate_spectrum: the position of particle " + std::to_string(i) + " is not finite");
    }
  }
  ScaledStiffness A(topology, position, fixed);
  Vector q = start_vector(3 * topology.particle_count);
  A.project(q);
  if (A.spacing() == 0.0 || q.norm() == 0.0) return {};
  q.normalize();

  const Reaction reaction = topology.options.reaction;
  const bool symmetric =
      topology.base_count == 0 || reaction == Reaction::conservative || reaction == Reaction::averaged;
  Spectrum found = symmetric ? lanczos(A, q) : arnoldi(A, q);
  if (found.most_negative > -rigid_motion * found.largest) found.most_negative = 0.0;
  return found;
}

double stable_step(const Spectrum& spectrum, double damping_factor) {
  if (spectrum.largest <= 0.0) return std::numeric_limits<double>::infinity();
  return std::sqrt(2.0 * (1.0 + damping_factor) / spectrum.largest);
}

}  // namespace phymul

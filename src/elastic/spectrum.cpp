// SPDX-License-Identifier: MIT
//
// Extreme eigenvalues of M^-1 K: Lanczos works on the symmetric M^-1/2 K M^-1/2 (scaled_stiffness.h), Arnoldi on the
// same similarity transform of an unsymmetric K. Source: Golub & Van Loan, Matrix Computations, ch. 10.
#include <phymul/elasticity.h>
#include <phymul/error.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "dissipation.h"
#include "scaled_stiffness.h"

namespace phymul {
namespace {

using Vector = Eigen::VectorXd;

/// Arnoldi keeps every vector: as many as fit in this many bytes, within [12, 80].
constexpr double arnoldi_bytes = 4e8;

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
    // Stiffness over mass leaves the numbers: no step is small enough.
    if (!std::isfinite(beta)) return {.largest = std::numeric_limits<double>::infinity()};
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
  const Vector q = A.start_vector();
  if (A.spacing() == 0.0 || q.isZero(0.0)) return {};

  const Reaction reaction = topology.options.reaction;
  const bool symmetric =
      topology.base_count == 0 || reaction == Reaction::conservative || reaction == Reaction::averaged;
  if (symmetric) return lanczos(A, q).spectrum;
  Spectrum found = arnoldi(A, q);
  if (found.most_negative > -rigid_motion * found.largest) found.most_negative = 0.0;
  return found;
}

double stable_step(const Spectrum& spectrum, double damping_factor) {
  if (spectrum.largest <= 0.0) return std::numeric_limits<double>::infinity();
  return std::sqrt(2.0 * (1.0 + damping_factor) / spectrum.largest);
}

double stable_step(const TopologyTextures& topology, const Spectrum& spectrum, double damping_factor) {
  return largest_step(step_bound(topology, spectrum), damping_factor);
}

}  // namespace phymul

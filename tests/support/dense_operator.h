// SPDX-License-Identifier: MIT
//
// The linearised motion of small bodies by dense matrices: what Lanczos and Arnoldi iteration are held against, and how
// fast a body that is not stable grows. In a library of its own, dense_operator.cmake: dense eigenvalues take a
// compiler longer than most tests.
#pragma once

#include <phymul/elasticity.h>

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace phymul::test {

/// Eigenvalues of M^-1 K of the free coordinates, 1/s^2, by central differences; the others count as rows and columns
/// of zeros.
Eigen::VectorXcd dense_eigenvalues(const TopologyTextures& topology, const VecList& position,
                                   const std::vector<std::uint8_t>& fixed = {});

/// The fastest growing motion about the rest shape, u(t) = Re(shape exp(s t)) with s^2 = -eigenvalue.
struct GrowingMode {
  std::complex<double> s;          ///< 1/s; real part: growth rate, imaginary part: angular frequency
  double highest_frequency = 0.0;  ///< 1/s, of all motions: sqrt of the largest |eigenvalue|
  Eigen::VectorXcd shape;          ///< [3N], right eigenvector, largest entry 1
  Eigen::RowVectorXcd picks;       ///< picks * u(t) is its amplitude alone, whatever else u(t) holds
};

/// Rigid motions, whose eigenvalue 0 comes out as rounding, do not count as growth.
GrowingMode fastest_growing_mode(const TopologyTextures& topology);

}  // namespace phymul::test

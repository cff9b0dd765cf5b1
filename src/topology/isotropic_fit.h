// SPDX-License-Identifier: MIT
//
// Non-negative weights on directions that look alike from all sides. The elasticity of a set of bases depends on the
// fourth moment of their normals, M = sum_t u_t n_t (x) n_t (x) n_t (x) n_t; it is that of an isotropic body when M is
//   3-D: M_ijkl = (d_ij d_kl + d_ik d_jl + d_il d_jk) / 15,   2-D: the same over 8.
// Distances between moments are Frobenius norms, which do not change when the body is turned.
#pragma once

#include <phymul/types.h>

#include <Eigen/Core>
#include <vector>

namespace phymul {

/// The 15 different entries of a symmetric fourth-order tensor, each times the root of how often it occurs.
using FourthMoment = Eigen::Matrix<double, 15, 1>;

/// Moment of one unit direction.
FourthMoment fourth_moment(const Vec3& normal);

/// Moment of directions spread evenly over the sphere (circle where dimension is 2).
FourthMoment isotropic_moment(int dimension);

/// Weights of many directions, most of them 0: the nearest isotropic moment with at most 18 positive weights, sum 1.
/// `centre` is where each sample lies, in units of the neighbourhood's size and relative to its particle; sets that
/// are balanced about the particle are preferred. All zero where there are no directions.
Eigen::VectorXd sparse_weights(const std::vector<Vec3>& normals, const VecList& centres, int dimension);

}  // namespace phymul

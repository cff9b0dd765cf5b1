// SPDX-License-Identifier: MIT
//
// How far scaled materials (Scene::scale_stiffness) can raise the spectrum of a body, from what each of them is by
// itself.
//
// K = sum of f_m K_m, each K_m positive semidefinite at rest. Two bounds hold for its largest eigenvalue over the
// masses M; both are one for factors that are alike, and are near it where one material is far stiffer than the others:
//   joined  t w + sum of max(f_m - t, 0) l_m for every t >= 0, with w of the whole body, l_m of K_m over M:
//           f_m K_m <= t K_m + max(f_m - t, 0) K_m (Weyl)
//   apart   the largest f_m a_m, with a_m of K_m over the masses that are left to material m if the body is cut where
//           materials meet and the masses there are shared out: x K x = sum of f_m x K_m x <= sum of f_m a_m x M_m x
// For both see Horn and Johnson, Matrix Analysis, section 4.3.
#pragma once

#include <phymul/topology_textures.h>

#include <span>
#include <vector>

namespace phymul {

// Some materials of a body of Law::particle_averaged as tables of their own. Exact, because links join domains of one
// material.

/// The domains of some materials, and the particles that have one.
struct PartOfBody {
  TopologyTextures tables;
  std::vector<Index> particle;  ///< of the whole body, in ascending order
};
/// `chosen`: by row of Model::materials; further rows are not chosen. Domains keep their order.
PartOfBody part_of(const TopologyTextures& topology, const std::vector<bool>& chosen);

/// [rows of Model::materials] whether it has domains.
std::vector<bool> materials_of(const TopologyTextures& topology);

class MaterialSpectra {
 public:
  /// Of the materials that have domains. Costs about twice estimate_spectrum() of the body, however many there are.
  explicit MaterialSpectra(const TopologyTextures& topology);

  /// A bound of the largest eigenvalue, 1/s^2. `whole`: the one of factors 1. Factors by row of Model::materials; of
  /// rows beyond: 1. Does not allocate.
  double largest(double whole, std::span<const double> factors) const;

 private:
  struct Own {
    Index material;
    double joined, apart;  // 1/s^2
  };
  std::vector<Own> own_;
};

}  // namespace phymul

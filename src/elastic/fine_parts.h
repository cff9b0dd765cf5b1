// SPDX-License-Identifier: MIT
//
// Parts of a body whose cells are smaller than those of the rest, of any material: motions finer than the spacing of
// the rest get a larger inertia, so that they do not set the step.
//
// N interpolates linearly between the nodes of a grid, D = N^T M 1 are the masses of the nodes. S = N D^-1 N^T M takes
// means of accelerations over the grid: it keeps a field that is constant, nearly keeps one that is smooth on the grid,
// and leaves little of others. A step takes Q f / m in place of f / m,
//   Q = S + (1 - S) / inertia.
// M Q^-1 is constant, symmetric and at least M, so the scheme is Verlet's with that mass. The rows of M Q^-1 sum to M:
// linear momentum is conserved. It is the same for each component, so the part may turn, and the angular momentum of
// these masses is conserved. Rest shapes are the same. Source of larger masses for fast motions alone: Olovsson,
// Simonsson and Unosson, Selective mass scaling for explicit finite element analyses, Int. J. Numer. Meth. Eng. 63,
// 2005; there each cell has its own, here they are one per particle and a few passes over them.
#pragma once

#include <phymul/topology_textures.h>

#include <array>
#include <span>
#include <vector>

namespace phymul {

struct FineParts {
  static constexpr double cost_of_particle = 0.4;  ///< in those of a step for one, on "cpu"
  struct Entry {
    Index row = 0;
    float weight = 0.0f;
  };
  std::vector<Index> particle;                ///< in ascending order
  std::vector<double> mass;                   ///< kg, by particle
  std::vector<std::array<Entry, 4>> corners;  ///< by particle: N of nodes; they sum to 1 without rounding
  std::vector<Index> first;                   ///< [nodes + 1] row of `entries`
  std::vector<Entry> entries;                 ///< by node: N of particles
  std::vector<double> node_mass;              ///< kg, D
  double inertia = 1.0;

  bool empty() const { return particle.empty(); }
  std::size_t nodes() const { return node_mass.size(); }
  /// Of a step, in those of a step without parts.
  double cost(Index particles) const {
    return cost_of_particle * static_cast<double>(particle.size()) / static_cast<double>(particles);
  }

  /// J: v (M Q^-1 - M) next / 2, what the larger inertia adds to a kinetic energy. m/s, by particle; `free`: by
  /// particle 1, or 0 for imposed coordinates.
  double added_energy(std::span<const Vec3> v, std::span<const Vec3> next, std::span<const Vec3> free) const;

  /// M (Q - 1) M^-1 f to `change`, N, both by particle. `at_nodes`: scratch, [nodes].
  template <class Vector>
  void changes(std::span<const Vector> f, std::span<Vector> change, std::span<Vector> at_nodes) const {
    using Scalar = typename Vector::Scalar;
    const auto part = [](const Entry& of, std::span<const Vector> values) -> Vector {
      return static_cast<Scalar>(of.weight) * values[of.row];
    };
    for (std::size_t node = 0; node < nodes(); ++node) {
      Vector even = Vector::Zero(), odd = even;  // two sums that do not wait for each other
      Index row = first[node];
      for (; row + 1 < first[node + 1]; row += 2) {
        even += part(entries[row], f);
        odd += part(entries[row + 1], f);
      }
      if (row < first[node + 1]) even += part(entries[row], f);
      at_nodes[node] = static_cast<Scalar>(1.0 / node_mass[node]) * (even + odd);
    }
    const auto taken = static_cast<Scalar>(1.0 - 1.0 / inertia);
    for (std::size_t r = 0; r < particle.size(); ++r) {
      const std::array<Entry, 4>& of = corners[r];
      const Vector mean =
          (part(of[0], at_nodes) + part(of[1], at_nodes)) + (part(of[2], at_nodes) + part(of[3], at_nodes));
      change[r] = taken * (static_cast<Scalar>(mass[r]) * mean - f[r]);
    }
  }
};

/// Share of the cost below which a gain is not worth a change of the scheme.
inline constexpr double least_gain = 0.1;

/// The parts with which a second of physics costs least by an estimate. None if they gain little, or if motions that
/// are smooth in the whole body would get a noticeably larger inertia. `excluded`: [N] particles that stay out of them,
/// or empty.
FineParts choose_fine_parts(const TopologyTextures& topology, const std::vector<bool>& excluded);

}  // namespace phymul

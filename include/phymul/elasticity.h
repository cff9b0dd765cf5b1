// SPDX-License-Identifier: MIT
//
// Forces and energy of a body in double precision: the kernels of the reference backend as plain functions. They throw
// Error when a size is not the topology's particle count.
#pragma once

#include <phymul/topology_textures.h>

#include <limits>
#include <span>

namespace phymul {

/// Attractor P*_i of every particle that has bases; the particle itself elsewhere. Shapes [N], m.
void attractors(const TopologyTextures& topology, std::span<const Vec3> position, std::span<Vec3> attractor);

/// Elastic force on every particle, all terms of the topology, N. Shapes [N]; overwrites `force`; does not allocate.
/// `factors`: of the stiffness of each material, as Scene::stiffness_factors(), or none: 1.
void elastic_forces(const TopologyTextures& topology, std::span<const Vec3> position, std::span<Vec3> force,
                    std::span<const double> factors = {});

/// Elastic energy, J. For the reactions full, shared and barycentric, which have none, that of `averaged`. `factors` as
/// above.
double elastic_energy(const TopologyTextures& topology, std::span<const Vec3> position,
                      std::span<const double> factors = {});

/// The first particle one of whose bases has collapsed to a line or a point, so that it has no direction; -1: none.
/// Throws Error when the size does not agree.
Index first_collapsed(const TopologyTextures& topology, std::span<const Vec3> position);

/// Largest and most negative eigenvalues of M^-1 K linearised about a position, found by Lanczos iteration
/// (conservative, averaged, springs) or Arnoldi iteration (the others, whose K is not symmetric).
struct Spectrum {
  double largest = 0.0;            ///< largest |eigenvalue|, 1/s^2: omega_max squared; infinite where it overflows
  double most_negative = 0.0;      ///< smallest real part if below 0, 1/s^2: grows as exp(sqrt(-it) t)
  double largest_imaginary = 0.0;  ///< of the eigenvalues found, 1/s^2: flutter
};

/// `fixed` [N] as LoadFrame::fixed, or empty. Takes two threads where the body is worth it; results do not depend on
/// them. Throws Error when position is not finite.
Spectrum estimate_spectrum(const TopologyTextures& topology, std::span<const Vec3> position,
                           std::span<const std::uint8_t> fixed = {});

/// How a body is strained. Domains (Law::particle_averaged) are *beyond the law* where their energy is not that of
/// StrainEnergy alone as it holds near rest: stretches outside 0.6 to 1.7 and somewhat more, or inverted.
struct StrainSummary {
  double growth = std::numeric_limits<double>::infinity();  ///< frequency_growth()
  Index beyond_law = 0;                                     ///< number of domains
  Index inverted = 0;                                       ///< number of these with det F <= 0
  Index first_beyond = -1;                                  ///< their lowest particle, row of the model; -1: none
};

/// Throws Error when the size does not agree; does not allocate. Bodies without domains (Law::particle_averaged) have
/// none beyond the law, and an infinite growth unless they are of walls alone.
StrainSummary strain_summary(const TopologyTextures& topology, std::span<const Vec3> position);

/// By how much deformation can have raised the largest eigenvalue over that at rest: 1 at rest (times 3.7 with walls,
/// times 2.6 for a Poisson's ratio below 0.3), in other states an estimate from above (docs/theory/physics.md), above
/// 1e6 where a domain is beyond the law (StrainSummary). Of bodies of walls alone 2 (1 - nu) / 1.15 at rest, if that is
/// above 1. Infinite for other bodies without domains. Throws Error when the
/// size does not agree; does not allocate.
double frequency_growth(const TopologyTextures& topology, std::span<const Vec3> position);

/// Largest stable step of x+ = x + d (x - x-) + (f/m) dt^2 in s: (omega_max dt)^2 <= 2 (1 + d); infinite without
/// any stiffness.
double stable_step(const Spectrum& spectrum, double damping_factor);

/// The same of a body whose material may dissipate, with the largest retardation_time T and relaxation_strength D of
/// its domains: omega_max^2 ((1 + D) dt^2 + 2 T dt) <= 2 (1 + d). Derivation: docs/theory/physics.md.
double stable_step(const TopologyTextures& topology, const Spectrum& spectrum, double damping_factor);

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Materials that dissipate (Material::retardation_time, relaxation_strength), in double precision: the reference for
// backends. For each domain, with Green's strain E of its mean gradient, F = I + H and the small-strain tensor C:
//   rate     S = retardation_time * C : (E - E-) / dt, with E- of the step before
//   branch   S = relaxation_strength * exp(-dt / (2 tau)) * C : (E - Ev), then Ev += (1 - exp(-dt / tau)) (E - Ev)
// Both add the first Piola stress F S; S is symmetric, so that it conserves angular momentum. The branch is the
// midpoint rule for its convolution integral: Simo and Hughes, Computational Inelasticity, 1998, section 10.3, with Ev
// in place of their stress so that a domain keeps one strain.
#pragma once

#include <phymul/elasticity.h>
#include <phymul/state.h>

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace phymul {

/// xx, yy, zz, yz, zx, xy
using Strain = std::array<double, 6>;

/// Which strains the domains of a body keep: E-, then Ev.
struct KeptStrains {
  bool rate = false, branch = false;
  std::size_t count() const { return std::size_t{rate} + std::size_t{branch}; }
};
KeptStrains kept_strains(const TopologyTextures& topology);

/// [D * KeptStrains::count()], domain by domain. Empty: each domain's are its own strain at the next step, as after a
/// reset.
using StrainMemory = std::vector<Strain>;

/// Adds the memory, if it is not empty, as a part of the snapshot.
void put_strains(const StrainMemory& memory, Snapshot& snapshot);
bool has_strains(const Snapshot& snapshot);
/// The part that put_strains() added; empty if there is none. Throws Error if it is of another body or not finite.
StrainMemory strains_of(const Snapshot& snapshot, const TopologyTextures& topology);

/// After an edit of the tables: the strains E- of the domains are what the last step's start would have by the new
/// ones, so that no step takes the change for a motion and their rates go on. Copies of particles keep the Ev of these.
void continue_strains(const TopologyTextures& topology, std::span<const Index> domains,
                      std::span<const std::array<Index, 2>> copied, Snapshot& snapshot);

/// Adds the forces of a step of `dt`, s, from x, N. `last_dt`, s: of the step before, 0: there was none. `next`, if not
/// null, gets the memory after this step. Returns the energy in the branches at x, J, if the
/// step before took `dt` too.
double add_dissipative_forces(const TopologyTextures& topology, std::span<const Vec3> x, const StrainMemory& memory,
                              double dt, double last_dt, std::span<Vec3> force, StrainMemory* next = nullptr);

/// Of a state that a step of `last_dt`, s, led to; 0: none did.
struct DissipationNow {
  VecList force;        ///< N; empty: none
  double energy = 0.0;  ///< J, in the branches
};
DissipationNow dissipation_at(const TopologyTextures& topology, std::span<const Vec3> x, const StrainMemory& memory,
                              double last_dt);

class Dissipation {
 public:
  /// Takes the memory of both states, so that no step and no reset allocates.
  explicit Dissipation(const TopologyTextures& topology) : kept_(kept_strains(topology)) {
    memory_.reserve(topology.dissipation.size() * kept_.count());
    next_.reserve(memory_.capacity());
  }

  bool empty() const { return kept_.count() == 0; }
  void reset(const StrainMemory& memory) { memory_.assign(memory.begin(), memory.end()); }
  const StrainMemory& memory() const { return memory_; }

  /// Adds the forces of the step from x, N. `t`: the tables of the constructor, or ones whose stiffness is scaled.
  /// `dt`, s: of this step; `last_dt`: of the one before, 0: there was none.
  void add_forces(const TopologyTextures& t, std::span<const Vec3> x, double dt, double last_dt,
                  std::span<Vec3> force) {
    add_dissipative_forces(t, x, memory_, dt, last_dt, force, &next_);
  }
  /// The step counts: the next one starts from its strains.
  void accept() { memory_.swap(next_); }

 private:
  const KeptStrains kept_;
  StrainMemory memory_, next_;
};

/// Bounds of a body's stiffness and damping over its masses.
struct StepBound {
  double stiffness = 0.0;  ///< 1/s^2
  double damping = 0.0;    ///< 1/s
};
StepBound step_bound(const TopologyTextures& topology, const Spectrum& spectrum);

/// s. Of x+ = x + dt v+, v+ = d v - dt (K x + C v) / m, whose characteristic polynomial has its roots within the unit
/// circle while dt^2 k + 2 dt c <= 2 (1 + d), mode by mode. Infinite without stiffness and damping.
double largest_step(const StepBound& bound, double damping_factor);

// Parts of a snapshot that are numbers alone.
void put_numbers(std::string_view name, std::span<const double> numbers, Snapshot& snapshot);
bool has_part(std::string_view name, const Snapshot& snapshot);
/// [count]; none if there is no such part. Throws Error if it is of another body or not finite.
std::vector<double> numbers_of(std::string_view name, std::size_t count, const Snapshot& snapshot);

}  // namespace phymul

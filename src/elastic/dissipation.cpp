// SPDX-License-Identifier: MIT
#include "dissipation.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/checked_file.h"
#include "domain_forces.h"

namespace phymul {
namespace {

constexpr const char* part_name = "strains";

Mat3 matrix(const Strain& e) {
  Mat3 E;
  E << e[0], e[5], e[4], e[5], e[1], e[3], e[4], e[3], e[2];
  return E;
}

Strain strain_of(const Mat3& E) {
  return {E(0, 0), E(1, 1), E(2, 2), E(1, 2), E(2, 0), E(0, 1)};
}

Mat3 green_strain(const Mat3& H) {
  return matrix(strain_of(0.5 * (H + H.transpose() + H.transpose() * H)));
}

Mat3 stress_of(const DissipationTexel& of, const Mat3& E) {
  return 2.0 * of.mu * E + of.lambda * E.trace() * Mat3::Identity();
}

/// exp(-dt / tau); 1 where nothing relaxes.
double decay(const DissipationTexel& of, double dt) {
  return of.relaxation_strength > 0.0 ? std::exp(-dt / of.relaxation_time) : 1.0;
}

/// Adds the forces of the stress P of domain d.
void add_stress(const TopologyTextures& t, Index d, const Mat3& P, std::span<Vec3> force) {
  for_each_area(t, d, [&](Index other, const Vec3& area) {
    const Vec3 pull = P * area;
    force[t.domains[other].particle] -= pull;
    force[t.domains[d].particle] += pull;
  });
}

}  // namespace

KeptStrains kept_strains(const TopologyTextures& topology) {
  KeptStrains kept;
  for (const DissipationTexel& of : topology.dissipation) {
    kept.rate = kept.rate || of.retardation_time > 0.0;
    kept.branch = kept.branch || of.relaxation_strength > 0.0;
  }
  return kept;
}

void put_strains(const StrainMemory& memory, Snapshot& snapshot) {
  if (memory.empty()) return;
  put_numbers(part_name, {memory.front().data(), memory.size() * memory.front().size()}, snapshot);
}

bool has_strains(const Snapshot& snapshot) {
  return has_part(part_name, snapshot);
}

StrainMemory strains_of(const Snapshot& snapshot, const TopologyTextures& topology) {
  const std::size_t count = topology.dissipation.size() * kept_strains(topology).count();
  const std::vector<double> numbers = numbers_of(part_name, count * std::tuple_size_v<Strain>, snapshot);
  StrainMemory memory(numbers.empty() ? 0 : count);
  for (std::size_t k = 0; k < memory.size(); ++k) std::copy_n(&numbers[6 * k], 6, memory[k].begin());
  return memory;
}

void continue_strains(const TopologyTextures& t, std::span<const Index> domains,
                      std::span<const std::array<Index, 2>> copied, Snapshot& snapshot) {
  StrainMemory memory = strains_of(snapshot, t);
  if (memory.empty()) return;
  const KeptStrains kept = kept_strains(t);
  const auto branch_of = [&](Index d) -> Strain& {
    return memory[static_cast<std::size_t>(d) * kept.count() + kept.rate];
  };
  if (kept.branch) {
    for (const auto& [copy, of] : copied) {
      for (Index d = t.first_domain[copy]; d < t.first_domain[copy + 1]; ++d) {
        for (Index e = t.first_domain[of]; e < t.first_domain[of + 1]; ++e) {
          if (t.domains[d].material == t.domains[e].material) branch_of(d) = branch_of(e);
        }
      }
    }
  }
  if (kept.rate) {
    VecList before = snapshot.state.position;
    for (std::size_t i = 0; i < before.size(); ++i) before[i] -= snapshot.last_dt * snapshot.state.velocity[i];
    for (const Index d : domains) {
      const Mat3 H = mean_gradient(t, d, displacements_at(t, before));
      memory[static_cast<std::size_t>(d) * kept.count()] = strain_of(green_strain(H));
    }
  }
  std::erase_if(snapshot.parts, [](const Snapshot::Part& part) { return part.name == part_name; });
  put_strains(memory, snapshot);
}

double add_dissipative_forces(const TopologyTextures& t, std::span<const Vec3> x, const StrainMemory& memory, double dt,
                              double last_dt, std::span<Vec3> force, StrainMemory* next) {
  const KeptStrains kept = kept_strains(t);
  if (next != nullptr) next->resize(t.dissipation.size() * kept.count());
  const double inverse_dt = 1.0 / (last_dt > 0.0 ? last_dt : dt);
  double energy = 0.0;
  for (Index d = 0; d < static_cast<Index>(t.dissipation.size()); ++d) {
    const DissipationTexel& of = t.dissipation[d];
    const Mat3 H = mean_gradient(t, d, displacements_at(t, x)), E = green_strain(H);
    std::size_t at = static_cast<std::size_t>(d) * kept.count();
    const auto before = [&] { return memory.empty() ? E : matrix(memory[at]); };
    const auto keep = [&](const Mat3& strain) {
      if (next != nullptr) (*next)[at] = strain_of(strain);
      ++at;
    };
    Mat3 S = Mat3::Zero();
    if (kept.rate) {
      S += of.retardation_time * inverse_dt * stress_of(of, E - before());
      keep(E);
    }
    if (kept.branch) {
      const Mat3 Ev = before(), stress = stress_of(of, E - Ev);
      const double e = decay(of, dt);
      energy += 0.5 * of.relaxation_strength * e * stress.cwiseProduct(E - Ev).sum() / t.domains[d].inverse_volume;
      S += of.relaxation_strength * std::sqrt(e) * stress;
      keep(Ev + (1.0 - e) * (E - Ev));
    }
    Mat3 P = S + H * S;
    if (t.dimension == 2) P.row(2).setZero();  // nothing but rounding, which would leave the plane
    add_stress(t, d, P, force);
  }
  return energy;
}

DissipationNow dissipation_at(const TopologyTextures& t, std::span<const Vec3> x, const StrainMemory& memory,
                              double last_dt) {
  DissipationNow now;
  if (memory.empty() || !(last_dt > 0.0)) return now;
  now.force.assign(t.particle_count, Vec3::Zero());
  now.energy = add_dissipative_forces(t, x, memory, last_dt, last_dt, now.force);
  return now;
}

StepBound step_bound(const TopologyTextures& topology, const Spectrum& spectrum) {
  double strength = 0.0, time = 0.0;
  for (const DissipationTexel& of : topology.dissipation) {
    strength = std::max(strength, of.relaxation_strength);
    time = std::max(time, of.retardation_time);
  }
  const double squared = std::max(spectrum.largest, 0.0);
  return {(1.0 + strength) * squared, time * squared};
}

double largest_step(const StepBound& bound, double damping_factor) {
  const double twice = 2.0 * (1.0 + damping_factor), c = bound.damping;
  if (c == 0.0) return stable_step(Spectrum{.largest = bound.stiffness}, damping_factor);
  return twice / (c + std::sqrt(c * c + twice * bound.stiffness));
}

void put_numbers(std::string_view name, std::span<const double> numbers, Snapshot& snapshot) {
  ByteWriter out;
  for (const double number : numbers) out.real(number);
  snapshot.parts.push_back({std::string(name), {out.bytes().begin(), out.bytes().end()}});
}

bool has_part(std::string_view name, const Snapshot& snapshot) {
  return std::ranges::find(snapshot.parts, name, &Snapshot::Part::name) != snapshot.parts.end();
}

std::vector<double> numbers_of(std::string_view name, std::size_t count, const Snapshot& snapshot) {
  const auto part = std::ranges::find(snapshot.parts, name, &Snapshot::Part::name);
  if (part == snapshot.parts.end()) return {};
  const std::string label = "the snapshot's part \"" + part->name + '"';
  const std::size_t bytes = count * sizeof(double);
  if (bytes == 0 || part->bytes.size() != bytes) {
    throw Error("Solver::restore: expected " + label + " to have " + std::to_string(bytes) +
                " bytes for this body and these options, got " + std::to_string(part->bytes.size()) +
                "; the solver keeps its state");
  }
  ByteReader in(part->name, {reinterpret_cast<const char*>(part->bytes.data()), bytes});
  std::vector<double> numbers(count);
  for (double& number : numbers) {
    number = in.real("a number");
    if (std::isfinite(number)) continue;
    throw Error("Solver::restore: " + label + " has a number that is not finite; the solver keeps its state");
  }
  return numbers;
}

}  // namespace phymul

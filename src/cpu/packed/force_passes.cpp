// SPDX-License-Identifier: MIT
#include "force_passes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/compiler.h"
#include "base/denormals.h"
#include "elastic/domain_forces.h"
#include "elastic/force_wall.h"

namespace phymul::cpu {
namespace {

/// The last cluster of a run is left to its part: another would read constants from further away than it saves, for a
/// part that is late by less than one cluster.
constexpr int least_to_take_from = 2;

std::uint64_t run_of(std::uint64_t first, std::uint64_t end) {
  return first | end << 32;
}
int first_of(std::uint64_t run) {
  return static_cast<int>(run & 0xffffffffu);
}
int end_of(std::uint64_t run) {
  return static_cast<int>(run >> 32);
}
int size_of(std::uint64_t run) {
  return end_of(run) - first_of(run);
}

/// Clusters [result[part], result[part + 1]) of about equal cost for each part.
std::vector<int> shared_out(const PackedBody& body, int parts) {
  std::vector<int> first{0};
  double done = 0.0;
  double all = 0.0;
  for (const Cluster& cluster : body.clusters) all += cluster.cost;
  for (std::size_t c = 0; c < body.clusters.size(); ++c) {
    const double middle = done + 0.5 * body.clusters[c].cost;
    while (static_cast<int>(first.size()) < parts && middle >= all * static_cast<double>(first.size()) / parts) {
      first.push_back(static_cast<int>(c));
    }
    done += body.clusters[c].cost;
  }
  first.resize(static_cast<std::size_t>(parts) + 1, static_cast<int>(body.clusters.size()));
  return first;
}

}  // namespace

ClusterClaims::ClusterClaims(const PackedBody& body, int parts) : runs_(static_cast<std::size_t>(parts)) {
  const std::vector<int> first = shared_out(body, parts);
  for (std::size_t part = 0; part < runs_.size(); ++part) {
    runs_[part].all = run_of(static_cast<std::uint64_t>(first[part]), static_cast<std::uint64_t>(first[part + 1]));
  }
}

void ClusterClaims::begin() {
  for (Run& run : runs_) run.left.store(run.all, std::memory_order_relaxed);
}

int ClusterClaims::take(int part) {
  std::atomic<std::uint64_t>& left = runs_[static_cast<std::size_t>(part)].left;
  std::uint64_t run = left.load(std::memory_order_relaxed);
  if (runs_.size() == 1) {  // nobody to agree with, which small bodies need not pay for
    left.store(run + 1, std::memory_order_relaxed);
    return size_of(run) > 0 ? first_of(run) : -1;
  }
  while (size_of(run) > 0) {
    if (left.compare_exchange_weak(run, run + 1, std::memory_order_relaxed)) return first_of(run);
  }
  return take_from_another();
}

/// From the part that has most left, which is the latest.
int ClusterClaims::take_from_another() {
  for (;;) {
    Run* latest = nullptr;
    std::uint64_t of_latest = 0;
    int most = least_to_take_from - 1;
    for (Run& run : runs_) {
      const std::uint64_t left = run.left.load(std::memory_order_relaxed);
      if (size_of(left) <= most) continue;
      most = size_of(left);
      latest = &run;
      of_latest = left;
    }
    if (!latest) return -1;
    const int last = end_of(of_latest) - 1;
    const std::uint64_t rest =
        run_of(static_cast<std::uint64_t>(first_of(of_latest)), static_cast<std::uint64_t>(last));
    if (latest->left.compare_exchange_strong(of_latest, rest, std::memory_order_relaxed)) return last;
  }
}

namespace {

/// Bytes a step above which rows that a kernel reads once come from so far that it gains by asking for them ahead.
constexpr double near_caches = 8e6;

/// `u`: 16 bytes a particle; `near`: as many a slot. The last slot, which stands for nothing, is set to 0. Returns
/// `near`.
const char* near_displacements(const Cluster& cluster, const char* u, char* const near) {
  char* to = near;
  std::memcpy(to, u + 16 * static_cast<std::size_t>(cluster.first), 16 * static_cast<std::size_t>(cluster.own));
  to += 16 * static_cast<std::size_t>(cluster.own);
  for (const std::int32_t quad : cluster.halo) {
    std::memcpy(to, u + 16 * static_cast<std::size_t>(quad), 16);
    to += 16;
  }
  std::memset(to, 0, 16);
  return near;
}

constexpr std::size_t page = 4096;

/// The first place from `near` on that is half a page from `other`, whole pages aside. Processors take a load for one
/// of a recent store where the two agree in their last twelve bits: a slot's displacement must not stand there relative
/// to its force, or the kernels run at half their pace.
char* half_a_page_from(const char* other, char* near) {
  const auto distance = reinterpret_cast<std::uintptr_t>(other) + page / 2 - reinterpret_cast<std::uintptr_t>(near);
  return near + distance % page;
}

/// Asks for them ahead, into the second cache: a halo lies scattered in memory, where no processor foresees it.
void ask_for_displacements(const Cluster& cluster, const char* u) {
  const char* own = u + 16 * static_cast<std::size_t>(cluster.first);
  for (std::size_t k = 0; k < 16 * static_cast<std::size_t>(cluster.own); k += 64) PHYMUL_PREFETCH_LATER(own + k);
  for (const std::int32_t quad : cluster.halo) {
    PHYMUL_PREFETCH_LATER(u + 16 * static_cast<std::size_t>(quad));
  }
}

}  // namespace

ClusteredPasses::ClusteredPasses(const PackedBody& body, const simd::Kernels& kernels, int parts, bool far)
    : body_(body),
      kernels_(kernels),
      claims_(body, parts),
      near_u_(static_cast<std::size_t>(parts), Floats(4 * body.most_slots() + page, 0.0f)),
      stiffening_(body.clusters.size() * static_cast<std::size_t>(kernels.lanes), 0.0f),
      rows_far_(body.bytes_a_step() > near_caches),
      far_(far) {}

void ClusteredPasses::run(const char* u, char* force, char* pull, bool last, ThreadPool& pool, WorkLaps& laps,
                          WorkLaps& no_laps) {
  claims_.begin();
  pool.run([&](int part, int) {
    const DenormalsAreZero guard;
    for (int c = claims_.take(part); c >= 0; c = claims_.take(part)) {
      // Part 0 is the calling thread; the others write no times.
      float* const stiffening = last ? stiffening_.data() + static_cast<std::ptrdiff_t>(c) * kernels_.lanes : nullptr;
      add_cluster(c, u, force, pull, bytes(near_u_[static_cast<std::size_t>(part)]), stiffening,
                  part == 0 ? laps : no_laps);
    }
  });
  laps.end(Work::waiting);
}

double ClusteredPasses::growth(const TopologyTextures& topology) const {
  return has_walls_alone(topology) ? growth_of_walls(topology, std::ranges::max(stiffening_)) : HUGE_VAL;
}

void ClusteredPasses::add_to_particles(char* force, WorkLaps& laps) const {
  auto* const quads = reinterpret_cast<float*>(force);
  for (const auto& [to, from] : body_.wall_sums) {
    for (int a = 0; a < 4; ++a) quads[4 * std::ptrdiff_t{to} + a] += quads[4 * std::ptrdiff_t{from} + a];
  }
  laps.end(Work::walls);
}

void ClusteredPasses::add_cluster(int c, const char* u, char* force, char* pull, char* near, float* stiffening,
                                  WorkLaps& laps) const {
  const Cluster& cluster = body_.clusters[static_cast<std::size_t>(c)];
  simd::Job job = cluster.job;
  if (pull) job.pull = pull + 16 * static_cast<std::size_t>(cluster.first);
  if (force) {
    job.force = force + 16 * cluster.force_first;
    std::memset(job.force, 0, 16 * static_cast<std::size_t>(cluster.slots()));
  }
  job.wall_stiffening = stiffening;
  job.rows_far = rows_far_;
  job.far = far_;
  job.u = near_displacements(cluster, u, half_a_page_from(job.force ? job.force : job.pull, near));
  if (far_ && c + 1 < static_cast<int>(body_.clusters.size())) {
    ask_for_displacements(body_.clusters[static_cast<std::size_t>(c) + 1], u);
  }
  laps.end(Work::gathering);
  if (job.bases.count > 0) {
    kernels_.bases[static_cast<int>(body_.use)][body_.plane](job);
    laps.end(Work::bases);
  }
  if (job.enumerated.count > 0) {
    kernels_.enumerated[body_.use == simd::BaseUse::averaged](job);
    laps.end(Work::enumerated_bases);
  }
  if (job.springs.count > 0) {
    kernels_.springs(job);
    laps.end(Work::springs);
  }
  if (job.volumes.count > 0) {
    kernels_.volumes[body_.plane][body_.bounded](job);
    laps.end(Work::volumes);
  }
  if (job.walls.count > 0) {
    kernels_.walls(job);
    laps.end(Work::walls);
  }
}

AveragedPasses::AveragedPasses(const TopologyTextures& topology, const PackedBody& body, const simd::Kernels& kernels,
                               int parts)
    : body_(body),
      kernels_(kernels),
      energy_(static_cast<int>(topology.options.strain_energy)),
      growth_exponent_(growth_exponent(topology)),
      stress_(body.averages.stress_floats(), 0.0f),
      sums_(topology.dissipation.empty() ? 0 : 9 * static_cast<std::size_t>(body.averages.slots), 0.0f),
      condition_(static_cast<std::size_t>(body.averages.slots), 1.0f),
      first_(body.averages.shared_out(parts)) {}

bool AveragedPasses::scale(const TopologyTextures& topology, const std::vector<double>& of_materials) {
  if (of_materials == of_materials_) return false;
  of_materials_ = of_materials;
  const std::vector<Index>& domains = body_.averages.domain_of_place;
  factor_.resize(of_materials.empty() ? 0 : domains.size());
  for (std::size_t place = 0; place < factor_.size(); ++place) {
    const Index d = domains[place];
    const std::size_t row = d == none ? of_materials.size() : static_cast<std::size_t>(topology.domains[d].material);
    factor_[place] = row < of_materials.size() ? static_cast<float>(of_materials[row]) : 1.0f;
  }
  return true;
}

StrainSummary AveragedPasses::strain(const TopologyTextures& topology) const {
  StrainSummary found;
  double largest = 1.0;
  const std::vector<Index>& domains = body_.averages.domain_of_place;
  for (std::size_t place = 0; place < domains.size(); ++place) {
    if (domains[place] != none) largest = std::max(largest, double{condition_[place]});  // else of constants of 0
  }
  found.growth = growth_of(topology, growth_exponent_, largest);
  if (largest < 1e6) return found;
  for (std::size_t place = 0; place < domains.size(); ++place) {
    if (domains[place] != none) count_beyond_law(condition_[place], topology.domains[domains[place]].particle, found);
  }
  return found;
}

template <class Pass>
void AveragedPasses::for_each_pass(const simd::Averaged& job, WorkLaps& laps, const Pass& pass) const {
  const bool runs = !body_.averages.runs.empty();
  const auto of = [&](auto kernel) { return [&job, kernel](int first, int last) { kernel(job, first, last); }; };
  if (runs) {
    pass(of(kernels_.spread_displacements));
    laps.end(Work::gathering);
  }
  pass([&, this](int first, int last) {
    kernels_.averaged_stresses[runs][energy_][body_.bounded](job, first, last);
    if (job.dissipation != nullptr) kernels_.add_dissipation[runs](job, first, last);
    if (job.factor != nullptr) kernels_.scale_stresses[runs](job, first, last);
  });
  laps.end(Work::averaged_stresses);
  pass(of(kernels_.averaged_forces[runs]));
  laps.end(Work::averaged_forces);
}

void AveragedPasses::run(char* force, char* u, char* next_u, const simd::Dissipation* dissipation,
                         const BodySleep* sleep, bool last, ThreadPool& pool, WorkLaps& laps) {
  if (sleep != nullptr && sleep->none()) return;
  const PackedAverages& averages = body_.averages;
  simd::Averaged job = averages.job(u, bytes(stress_), force);
  if (!factor_.empty()) job.factor = factor_.data();
  job.dissipation = dissipation;
  job.sums = dissipation != nullptr ? sums_.data() : nullptr;
  job.condition = last ? condition_.data() : nullptr;
  if (sleep != nullptr) {
    sleep->copy_displacements(u, next_u);
  } else {
    averages.copy_displacements(u);
  }
  for_each_pass(job, laps, [&](const auto& kernel) {
    if (sleep == nullptr || sleep->all()) {
      pool.run([&](int part, int) {
        const DenormalsAreZero guard;
        kernel(first_[part], first_[part + 1]);
      });
    } else {
      sleep->run(pool, [&](int part, int parts) {
        const DenormalsAreZero guard;
        sleep->slots().share(part, parts, kernel);
      });
    }
  });
  if (sleep != nullptr) {
    sleep->gather_forces(force);
  } else {
    averages.gather_forces(force);
  }
  laps.end(Work::averaged_forces);
}

}  // namespace phymul::cpu

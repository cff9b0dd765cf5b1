// SPDX-License-Identifier: MIT
#include "averaged_passes.h"

#include <algorithm>
#include <cmath>

#include "base/denormals.h"
#include "elastic/domain_forces.h"

namespace phymul::cpu {

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
  const double largest = *std::ranges::max_element(condition_);
  found.growth = std::pow(largest, growth_exponent_);
  if (largest < 1e6) return found;
  const std::vector<Index>& domains = body_.averages.domain_of_place;
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
  if (last && sleep != nullptr) std::ranges::fill(condition_, 1.0f);
  if (sleep != nullptr && sleep->none()) return;
  const PackedAverages& averages = body_.averages;
  simd::Averaged job = averages.job(u, reinterpret_cast<char*>(stress_.data()), force);
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

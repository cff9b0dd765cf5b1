// SPDX-License-Identifier: MIT
#include "simd_profile.h"

namespace phymul::cpu {

WorkLaps::WorkLaps(Profile* profile, const PackedBody& body) : profile_(profile) {
  if (!profile_) return;
  constexpr std::array<const char*, kinds> names{"loads",           "gathering", "bases", "enumerated bases",
                                                 "springs",         "volumes",   "walls", "averaged stresses",
                                                 "averaged forces", "waiting",   "move",  "tools",
                                                 "contacts",        "checks"};
  for (std::size_t k = 0; k < names.size(); ++k) rows_[k] = profile_->row(names[k]);
  const auto runs = [this](Work work, bool yes) {
    bool& any = runs_[static_cast<std::size_t>(work)];
    any = any || yes;
  };
  for (const Work work : {Work::loads, Work::gathering, Work::move, Work::checks}) runs(work, true);
  for (const Cluster& cluster : body.clusters) {
    const simd::Job& job = cluster.job;
    runs(Work::bases, job.bases.count > 0);
    runs(Work::enumerated_bases, job.enumerated.count > 0);
    runs(Work::springs, job.springs.count > 0);
    runs(Work::volumes, job.volumes.count > 0);
    runs(Work::walls, job.walls.count > 0);
  }
  for (const Work work : {Work::averaged_stresses, Work::averaged_forces}) runs(work, body.averaged());
  runs(Work::waiting, body.clusters.size() > 1);
}

void WorkLaps::end_step(bool tools, bool contacts) {
  if (!profile_) return;
  if (tools) profile_->add(row_of(Work::tools), 0.0, 1);
  if (contacts) profile_->add(row_of(Work::contacts), 0.0, 1);
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    if (runs_[k]) profile_->add(rows_[k], 0.0, 1);
  }
}

}  // namespace phymul::cpu

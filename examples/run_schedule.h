// SPDX-License-Identifier: MIT
//
// The dates of a run, and who is held and who is driven: read out of its loads.
#pragma once

#include <phymul/scene.h>

#include <vector>

struct RunSchedule {
  bool has_driven = false;
  double largest_pull = 0.0;          ///< s, first date of the largest imposed value; only where something is driven
  double let_go = 0.0;                ///< s, last date of the driven loads; only where something is driven
  double last_date = 0.0;             ///< s, last date of the other loads
  std::vector<phymul::Index> held;    ///< particles that a translation holds, sorted
  std::vector<phymul::Index> driven;  ///< particles that a translation or rotation moves, sorted
};

/// True for an imposed translation or rotation that moves something; one that only holds is none.
bool is_driving(const phymul::Load& load);

/// True for a force, pressure or acceleration that is not 0 throughout.
bool is_pushing(const phymul::Load& load);

RunSchedule schedule_of(const std::vector<phymul::Load>& loads);

/// Takes the driving loads out of the scene.
void let_go(phymul::Scene& scene);

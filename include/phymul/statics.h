// SPDX-License-Identifier: MIT
//
// Options and result of Simulation::solve_static: the rest shape without steps.
#pragma once

#include <phymul/step_report.h>

#include <string>

namespace phymul {

struct StaticOptions {
  /// The body is at rest when the net forces on free coordinates are at most this share of the loads, > 0. Both are
  /// Euclidean norms over all particles. The loads are gravity and forces on free coordinates, the elastic forces
  /// on coordinates that are imposed away from their rest places, and the forces of joints on points of the world and
  /// of tools.
  double tolerance = 1e-6;
  /// Evaluations, >= 1, after which the search gives up, some more at most: of the elastic forces of all particles, or
  /// of products with the tangent stiffness, of which an evaluation of the forces costs several.
  int most_evaluations = 3000;
  /// Begin where the displacements of the last calls lead, for calls that follow each other as loads, held places or
  /// tools change little by little. The result is as near to rest, but its bits depend on the calls before, which a
  /// Snapshot does not have. Without effect for bodies that nothing holds and for walls.
  bool predict = false;
};

struct StaticResult {
  RestStatus status = RestStatus::failed;  ///< step_limit: most_evaluations were not enough
  int evaluations = 0;                     ///< as StaticOptions::most_evaluations counts them
  double residual = 0.0;       ///< net forces over loads, as StaticOptions::tolerance; 0 if the loads are mere rounding
  double largest_force = 0.0;  ///< N, largest net force on a free particle
  Index folded = -1;           ///< as RestResult::folded, if converged
  std::string cause;           ///< of RestStatus::failed

  bool converged() const { return status == RestStatus::converged; }
  std::string message() const;  ///< one sentence for people
};

}  // namespace phymul

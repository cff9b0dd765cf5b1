// SPDX-License-Identifier: MIT
//
// Where a search for rest may begin after others of the same body: what the last ones changed is combined so that it
// would end the most of the forces that are there now (P. F. Fischer, Comput. Methods Appl. Mech. Eng. 163 (1998)
// 193-204, for linear systems).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace phymul {

class RestChanges {
 public:
  /// A search changed what it sought by `way` and ended the force `force`, N. Forgets changes of ways of another
  /// size, as with other tools.
  void add(const Eigen::VectorXd& way, const Eigen::VectorXd& force);
  void clear() { changes_.clear(); }
  /// To `way` what would end the most of `lacks`, N; false if nothing would.
  bool find(const Eigen::VectorXd& lacks, Eigen::VectorXd& way) const;

 private:
  struct Change {
    Eigen::VectorXd way, force;
  };
  std::vector<Change> changes_;  // the newest first
};

}  // namespace phymul

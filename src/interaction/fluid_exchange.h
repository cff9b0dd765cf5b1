// SPDX-License-Identifier: MIT
//
// How much fluid each of some connected volumes has at the end of a step. Into volume i fits, at the pressure p at the
// end, phi_i(p) = V_i(s(p)) / r_i(p) of its fluid (FluidPush), which rises with p. With G the conductances between them
// and L their Laplacian, which has the openings to the outside on its diagonal,
//
//     phi_i(p_i) + dt (L p)_i = m_i + dt G_out,i p_out,i          m: the fluid at the start
//
// is the gradient of a convex function: Newton's method with a line search finds its one root, at any conductance.
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <utility>
#include <vector>

#include "fluid_push.h"

namespace phymul {

class FluidExchange {
 public:
  struct Volume {
    FluidPush push;                                   // closed, with the fluid at the start
    double reached = 0.0;                             // m^3, without a push
    std::array<double, 3> along{};                    // volume_along()
    double conductance = 0.0, outlet_pressure = 0.0;  // to the outside
    double p = 0.0;                                   // Pa: where to start; then the root
    // Found by solve(). Beyond `low` and `high`, Pa, phi is continued by lines. Below `low` no fluid is left to give:
    // the volume keeps `least`, as flat as it is or so little that it cannot give more, and p is what sucks at it.
    double low = 0.0, high = 0.0, least = 0.0;  // Pa, Pa, m^3
    bool flat = false, dry = false;
    double left = 0.0;  // m^3, at the end

    WantedVolume fits(double pressure) const;  ///< phi and its slope
    void find_ends();
  };
  struct Link {
    int from, to;  // rows of `volumes`
    double conductance;
  };
  std::vector<Volume> volumes;  ///< refilled in each step
  std::vector<Link> links;

  void allocate(int count);
  /// The row of a volume that cannot hold what it would have; -1: none.
  int solve();

 private:
  double residual(const Eigen::VectorXd& p, Eigen::VectorXd& to) const;  ///< its greatest component
  enum class Found { root, rigid, nothing };  // rigid: nothing yields, so no pressure follows
  Found find_root();
  void share_out();

  static constexpr double enough = 1e-10;  // of all fluid: off by less is a root
  Eigen::MatrixXd slope_;
  Eigen::VectorXd p_, trial_, off_, step_;
  Eigen::LDLT<Eigen::MatrixXd> factors_;
};

}  // namespace phymul

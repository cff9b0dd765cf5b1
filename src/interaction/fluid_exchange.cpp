// SPDX-License-Identifier: MIT
#include "fluid_exchange.h"

#include <cmath>

namespace phymul {

void FluidExchange::Volume::find_ends() {
  const std::pair<double, double> branch = growing_branch(along);
  FluidPush last = push;
  last.volume = push.least();
  const auto s = root_of_cubic(along, [&](double at) -> WantedVolume {
    const WantedVolume all = last(at);
    return {all.volume - reached, all.slope};
  });
  flat = !s;
  low = push.pressure(s ? *s : branch.first);
  least = s ? last.volume : reached / fluid_ratio(push.fluid, 0.0).volume;
  high = push.pressure(branch.second);
  // Beyond its points a curve continues as a line, down to a ratio of 0.
  if (push.fluid.law == FluidLaw::curve) {
    high = std::min(high, fluid_pressure(push.fluid, 1e-3 * push.fluid.curve.front()[0]));
  }
}

WantedVolume FluidExchange::Volume::fits(double pressure) const {
  if (dry) return {least, 0.0};
  const double at = std::min(std::max(pressure, low), high), s = push.push(at), per_push = push.per_push();
  const WantedVolume r = fluid_ratio(push.fluid, at);
  const double volume = reached + ((along[2] * s + along[1]) * s + along[0]) * s;
  const double grows = ((3.0 * along[2] * s + 2.0 * along[1]) * s + along[0]) / per_push;
  WantedVolume phi{volume / r.volume, (grows - volume * r.slope / r.volume) / r.volume};
  if (pressure == at) return phi;
  phi.slope += along[0] / (per_push * r.volume);  // at the end of the branch there is none
  phi.volume += phi.slope * (pressure - at);
  return phi;
}

void FluidExchange::allocate(int count) {
  volumes.reserve(count);
  slope_.setIdentity(count, count);
  factors_.compute(slope_);  // of this size; before, a copy would read what Eigen leaves undefined
  for (Eigen::VectorXd* list : {&p_, &trial_, &off_, &step_}) list->resize(count);
}

double FluidExchange::residual(const Eigen::VectorXd& p, Eigen::VectorXd& to) const {
  const double dt = volumes.front().push.dt;
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    const Volume& own = volumes[k];
    to[k] = own.fits(p[k]).volume - own.push.volume + dt * own.conductance * (p[k] - own.outlet_pressure);
  }
  for (const Link& link : links) {
    const double flows = dt * link.conductance * (p[link.from] - p[link.to]);
    to[link.from] += flows;
    to[link.to] -= flows;
  }
  return to.lpNorm<Eigen::Infinity>();
}

FluidExchange::Found FluidExchange::find_root() {
  const double dt = volumes.front().push.dt;
  double total = 0.0;
  for (const Volume& own : volumes) total += own.push.volume;
  double worst = residual(p_, off_), enough = 1e-10 * total;
  for (int round = 0; round < 100 && worst > 1e-16 * total; ++round) {
    slope_.setZero();
    for (Eigen::Index k = 0; k < p_.size(); ++k) {
      slope_(k, k) = volumes[k].fits(p_[k]).slope + dt * volumes[k].conductance;
    }
    const double yields = slope_.trace();
    for (const auto& [from, to, conductance] : links) {
      slope_(from, from) += dt * conductance;
      slope_(to, to) += dt * conductance;
      slope_(from, to) -= dt * conductance;
      slope_(to, from) -= dt * conductance;
    }
    if (!(yields > 1e-13 * slope_.trace())) return Found::rigid;
    enough = 1e-10 * total + 1e-14 * slope_.trace() * p_.lpNorm<Eigen::Infinity>();
    step_ = factors_.compute(slope_).solve(off_);
    step_ = -step_;  // not at once: Eigen would allocate
    const double downhill = off_.dot(step_);
    double next = worst;
    for (double share = 1.0; share > 1e-9; share *= 0.5) {
      trial_ = p_ + share * step_;
      next = residual(trial_, off_);
      if (off_.dot(step_) <= -0.5 * downhill) break;
    }
    if (!(next < worst) && worst <= enough) break;  // what is left is rounding
    p_ = trial_;
    worst = next;
  }
  return worst <= enough ? Found::root : Found::nothing;
}

/// By what fits, which is more exact than flows where conductances are extreme. So that nothing is lost by rounding,
/// the volumes are multiples of the last bit of their sum, so that sums of them are exact; the largest one takes what
/// is left over.
void FluidExchange::share_out() {
  double total = 0.0;
  for (const Volume& own : volumes) total += own.push.volume;
  for (Eigen::Index k = 0; k < p_.size(); ++k) {
    Volume& own = volumes[k];
    own.p = p_[k];
    own.left = own.fits(own.p).volume;
    total -= own.push.dt * own.conductance * (own.p - own.outlet_pressure);
  }
  const double grid = std::ldexp(1.0, std::ilogb(total) - 52);
  const auto largest = std::ranges::max_element(volumes, {}, &Volume::left);
  for (auto own = volumes.begin(); own != volumes.end(); ++own) {
    if (own == largest) continue;
    own->left = grid * std::max(1.0, std::round(own->left / grid));
    total -= own->left;
  }
  largest->left = total;
}

int FluidExchange::solve() {
  for (std::size_t k = 0; k < volumes.size(); ++k) {
    Volume& own = volumes[k];
    own.find_ends();
    own.left = own.push.volume;
    p_[static_cast<Eigen::Index>(k)] = std::min(std::max(own.p, own.low), own.high);
    own.p = 0.0;
  }
  // Each round but the last finds another dry volume.
  for (;;) {
    const Found found = find_root();
    const auto dry = std::ranges::find_if(volumes, &Volume::dry);
    const bool no_number = !p_.allFinite() || !off_.allFinite();
    if (no_number || (found == Found::rigid && dry == volumes.end())) return -1;
    if (found != Found::root) return static_cast<int>(dry == volumes.end() ? 0 : dry - volumes.begin());
    bool changes = false;
    for (std::size_t k = 0; k < volumes.size(); ++k) {
      Volume& own = volumes[k];
      const double p = p_[static_cast<Eigen::Index>(k)];
      if (own.dry || (p >= own.low && p <= own.high)) continue;
      if (p > own.high || (own.flat && !(own.reached > 0.0))) return static_cast<int>(k);
      own.dry = changes = true;
    }
    if (!changes) break;
  }
  share_out();
  return -1;
}

}  // namespace phymul

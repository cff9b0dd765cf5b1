// SPDX-License-Identifier: MIT
#include "local_steps.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/symmetric_modes.h"
#include "scaled_tables.h"
#include "substep_loop.h"

namespace phymul {
namespace {

/// Each finds a half to a third of what is left of the excess; what is left of the last is below ritz_accuracy.
constexpr int margin_turns = 12;
/// Margins where the factor of `stiff` is smaller than the others', over that of equal factors: where it shows at one
/// of the factors that it is tried at, and where not. The largest of random bodies of two materials was 1.39.
constexpr double weaker_margin = 1.45, other_margin = 1.02;

/// Chebyshev polynomials at delta = cosh(theta), T_p(delta) = polynomial_start.
struct Chebyshev {
  explicit Chebyshev(int degree) : p(degree), theta(std::acosh(polynomial_start) / degree) {}
  double at(int k) const { return std::cosh(k * theta); }
  /// T_p / (2 T_p') at delta: the step's polynomial is then 1 - x / 2 to first order.
  double scale() const { return polynomial_start * std::sinh(theta) / (2.0 * p * std::sinh(p * theta)); }
  const int p;
  const double theta;
};

double largest_factor(const std::vector<bool>& chosen, bool of_chosen, std::span<const double> factors) {
  double largest = factors.empty() ? 1.0 : 0.0;
  for (std::size_t m = 0; m < factors.size(); ++m) {
    if ((m < chosen.size() && chosen[m]) == of_chosen) largest = std::max(largest, factors[m]);
  }
  return largest;
}

double rate_of(const TopologyTextures& t, const std::vector<bool>& chosen) {
  const PartOfBody part = part_of(t, chosen);
  return part.tables.domains.empty() ? 0.0 : estimate_spectrum(part.tables, part.tables.rest).largest;
}

using Vector = Eigen::VectorXd;

constexpr int steps_at_most = 120;

/// Q, applied to z = K u: minus the mean acceleration of a step, over the masses.
class Filter {
 public:
  explicit Filter(const LocalSteps& steps)
      : steps_(steps),
        dt_(2.0 / std::sqrt(steps.rate())),
        still_(Vector::Zero(static_cast<Eigen::Index>(3 * steps.stiff.particle.size()))),
        a_(steps.fine.particle.size()),
        change_(a_.size()),
        nodes_(steps.fine.nodes()) {
    if (steps.substeps.empty()) return;
    stiffness_.emplace(steps.stiff.tables, steps.stiff.tables.rest, std::span<const std::uint8_t>{});
    loop_.emplace(steps.substeps, Vector::Ones(still_.size()),
                  [this](const Vector& w, Vector& result) { stiffness_->apply(w, result); });
  }

  void apply(const Vector& z, Vector& result) {
    result = z;
    if (loop_) {
      for_each(steps_.stiff.particle, [&](auto own, auto whole) { still_.segment<3>(3 * own) = -z.segment<3>(whole); });
      const Vector& sum = loop_->run(still_, dt_, 1.0);
      for_each(steps_.stiff.particle,
               [&](auto own, auto whole) { result.segment<3>(whole) -= sum.segment<3>(3 * own); });
    }
    if (steps_.fine.empty()) return;
    const auto root = [&](auto own) { return std::sqrt(steps_.fine.mass[own]); };
    for_each(steps_.fine.particle, [&](auto own, auto whole) { a_[own] = z.segment<3>(whole) * root(own); });
    steps_.fine.changes<Vec3>(a_, change_, nodes_);
    for_each(steps_.fine.particle, [&](auto own, auto whole) { result.segment<3>(whole) += change_[own] / root(own); });
  }

 private:
  template <class Each>
  static void for_each(const std::vector<Index>& particle, const Each& each) {
    for (std::size_t r = 0; r < particle.size(); ++r) {
      each(static_cast<Eigen::Index>(r), Eigen::Index{3} * particle[r]);
    }
  }

  const LocalSteps& steps_;
  std::optional<ScaledStiffness> stiffness_;
  const double dt_;
  Vector still_;
  std::optional<SubstepLoop<Vector>> loop_;
  VecList a_, change_, nodes_;
};

}  // namespace

std::vector<Substep> substeps_of(int count) {
  if (count == 1) return {{.keep = 0.0, .kick = 0.5, .share = 1.0}};
  const Chebyshev T(count);
  std::vector<Substep> substeps(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    Substep& substep = substeps[k];
    if (k > 0) substep.keep = T.at(k - 1) / T.at(k + 1);
    substep.kick = (k == 0 ? 1.0 : 2.0) * T.scale() * T.at(k) / T.at(k + 1);
  }
  // w_p - x is dt^2 / 2 times the sum of share_k a_k: what a kick has become at the end.
  for (int k = 0; k < count; ++k) {
    double before = 0.0, now = substeps[k].kick;
    for (int j = k + 1; j < count; ++j) before = std::exchange(now, now + substeps[j].keep * (now - before));
    substeps[k].share = 2.0 * now;
  }
  return substeps;
}

double substep_limit(int count) {
  if (count == 1) return 4.0;
  const Chebyshev T(count);
  return (1.0 + T.at(1)) / T.scale();
}

double LocalSteps::factor(std::span<const double> factors) const {
  return largest_factor(chosen, true, factors);
}

double LocalSteps::rate(std::span<const double> factors) const {
  const double others = largest_factor(chosen, false, factors);
  const double soft_now = soft_rate * others;
  if (substeps.empty()) return margin * soft_now;
  const double stiff_now = stiff_rate * factor(factors);
  return (others > factor(factors) ? margin_beside : margin) *
         std::max(soft_now, 4.0 * stiff_now / substep_limit(static_cast<int>(substeps.size())));
}

namespace {

/// Of a second of physics, in those of a step without local steps. On "cpu" a step with p substeps of a share s takes
/// 1 + s (0.9 p + 0.3) times as long (balls of 3 to 25 % of 2,197 and 9,261 particles).
double cost(const LocalSteps& steps, const TopologyTextures& t) {
  const double substeps = steps.substeps.empty() ? 0.0 : 0.9 * static_cast<double>(steps.substeps.size()) + 0.3;
  return (1.0 + substeps * steps.share + steps.fine.cost(t.particle_count)) * std::sqrt(steps.rate());
}

/// Fine parts of what is not in `stiff`, whose tables are `others`.
void add_fine_parts(const TopologyTextures& t, const PartOfBody& others, LocalSteps& steps) {
  std::vector<bool> excluded(others.particle.size(), false);
  for (std::size_t r = 0; r < excluded.size(); ++r) {
    const Index i = others.particle[r];
    for (Index d = t.first_domain[i]; d < t.first_domain[i + 1]; ++d) {
      const auto m = static_cast<std::size_t>(t.domains[d].material);
      if (m < steps.chosen.size() && steps.chosen[m]) excluded[r] = true;
    }
  }
  LocalSteps alone;
  alone.fine = choose_fine_parts(others.tables, excluded);
  alone.soft_rate = steps.soft_rate;
  if (alone.fine.empty()) return;
  steps.soft_rate = largest_rate(others.tables, alone);
  steps.fine = std::move(alone.fine);
  for (Index& i : steps.fine.particle) i = others.particle[i];
}

void number_particles(const TopologyTextures& t, LocalSteps& steps) {
  steps.particle = steps.stiff.particle;
  steps.particle.insert(steps.particle.end(), steps.fine.particle.begin(), steps.fine.particle.end());
  for (const Index i : steps.particle) {
    steps.rest.push_back(t.rest[i]);
    steps.mass.push_back(t.mass[i]);
  }
}

/// The margin where the factor of `stiff` is smaller than the others'.
double margin_beside(const TopologyTextures& t, const LocalSteps& steps) {
  const double softer = steps.soft_rate / steps.stiff_rate;
  const double of_substeps = 4.0 / substep_limit(static_cast<int>(steps.substeps.size()));
  // Where margins are about largest.
  for (const double weaker : {std::min({1.0, softer / of_substeps, 17.5 * softer}), 1.0 / 6.0, 2.0 * softer}) {
    if (weaker > 1.0) continue;
    std::vector<double> factors;
    for (const bool is_stiff : steps.chosen) factors.push_back(is_stiff ? weaker : 1.0);
    ScaledTables scaled;
    LocalSteps now = steps;
    now.stiff = part_of(scaled.of(t, factors), steps.chosen);
    now.stiff_rate *= weaker;
    if (largest_rate(scaled.of(t, factors), now) > other_margin * now.rate()) return weaker_margin * steps.margin;
  }
  return other_margin * steps.margin;
}

}  // namespace

std::unique_ptr<const LocalSteps> choose_local_steps(const TopologyTextures& t, const Spectrum& whole, int most) {
  const std::vector<bool> present = materials_of(t);
  std::vector<std::size_t> order;  // materials, the stiffest first
  std::vector<double> own(present.size(), 0.0);
  for (std::size_t m = 0; m < present.size(); ++m) {
    if (!present[m]) continue;
    std::vector<bool> alone(present.size(), false);
    alone[m] = true;
    own[m] = rate_of(t, alone);
    order.push_back(m);
  }
  if (most < 2) return nullptr;
  std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t m) { return own[m]; });

  auto best = std::make_unique<LocalSteps>();
  double least_cost = (1.0 - least_gain) * std::sqrt(whole.largest);
  const auto consider = [&](const LocalSteps& steps) {
    const double its = cost(steps, t);
    if (its >= least_cost) return;
    least_cost = its;
    *best = steps;
  };
  // Substeps pass on what dampers give within a step too late for their limit.
  const std::size_t most_stiff = t.dissipation.empty() ? order.size() - 1 : 0;
  std::vector<bool> stiff(present.size(), false), soft = present;
  for (std::size_t k = 0; k <= most_stiff; ++k) {
    LocalSteps steps;
    if (k > 0) {
      stiff[order[k - 1]] = true;
      soft[order[k - 1]] = false;
      steps.stiff_rate = k == 1 ? own[order[0]] : rate_of(t, stiff);
    }
    steps.chosen = stiff;
    steps.soft_rate = k == 0 ? whole.largest : k + 1 == order.size() ? own[order.back()] : rate_of(t, soft);
    const auto domains = std::ranges::count_if(
        t.domains, [&](const DomainTexel& domain) { return stiff[static_cast<std::size_t>(domain.material)]; });
    steps.share = static_cast<double>(domains) / static_cast<double>(t.domains.size());
    const auto try_substeps = [&] {
      if (k == 0) return consider(steps);
      for (int p = 2; p <= most; ++p) {
        steps.substeps = substeps_of(p);
        consider(steps);
        if (steps.rate() <= steps.soft_rate) break;  // more substeps gain nothing
      }
    };
    try_substeps();
    add_fine_parts(t, part_of(t, soft), steps);
    if (!steps.fine.empty()) try_substeps();
  }
  if (best->substeps.empty() && best->fine.empty()) return nullptr;
  if (!best->substeps.empty()) {
    best->stiff = part_of(t, best->chosen);
    // In a shorter step substeps hide less of the stiffness, so that the margin of a step is that of no shorter one.
    for (int turn = 0; turn < margin_turns; ++turn) {
      const double excess = largest_rate(t, *best) / best->rate();
      if (excess <= 1.0) break;
      best->margin *= (1.0 + ritz_accuracy) * excess;
    }
    best->margin_beside = margin_beside(t, *best);
  }
  if (cost(*best, t) >= (1.0 - least_gain) * std::sqrt(whole.largest)) return nullptr;
  number_particles(t, *best);
  return best;
}

double largest_rate(const TopologyTextures& topology, const LocalSteps& steps) {
  ScaledStiffness K(topology, topology.rest, {});
  Filter filter(steps);
  // v: vectors with v . Q v = 1; z = Q v. (In x . K y rigid motions would have no length, and what rounds would grow.)
  Vector v = K.start_vector(), z, last_v = Vector::Zero(v.size()), w, image;
  filter.apply(v, z);
  const double length = std::sqrt(v.dot(z));
  if (!(length > 0.0)) return 0.0;
  v /= length;
  z /= length;
  std::vector<double> diagonal, off;
  double largest = 0.0;
  for (int step = 0; step < steps_at_most; ++step) {
    K.apply(z, w);
    diagonal.push_back(z.dot(w));
    w -= diagonal.back() * v;
    if (step > 0) w -= off.back() * last_v;
    filter.apply(w, image);
    const double beta = std::sqrt(std::max(w.dot(image), 0.0));
    if (step % 10 == 9 || step + 1 == steps_at_most || beta == 0.0) {
      const SymmetricModes ritz = tridiagonal_modes(diagonal, off);
      const Eigen::Index last = ritz.values.size() - 1;
      largest = ritz.values[last];
      const double residual = beta * std::abs(ritz.vectors(last, last));
      if (residual <= ritz_accuracy * largest || beta == 0.0) break;
    }
    off.push_back(beta);
    last_v.swap(v);
    v = w / beta;
    z = image / beta;
  }
  return largest;
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include "planner.h"

#include <algorithm>
#include <cmath>

#include "base/decimal.h"

namespace phymul {
namespace {

constexpr double twice_as_fine = 1.9;

/// Of |u1 - u2| to |u2 - u3|; rises with p.
double ratio_of_differences(double p, double h1, double h2, double h3) {
  return (std::pow(h1, p) - std::pow(h2, p)) / (std::pow(h2, p) - std::pow(h3, p));
}

double order_of(double ratio, double h1, double h2, double h3) {
  double low = least_order, high = most_order;
  for (int k = 0; k < 60; ++k) {
    const double p = 0.5 * (low + high);
    (ratio_of_differences(p, h1, h2, h3) < ratio ? low : high) = p;
  }
  return 0.5 * (low + high);
}

}  // namespace

double mean_distance(std::span<const Vec3> a, std::span<const Vec3> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

Convergence fit_convergence(const FieldAt& coarse, const FieldAt& middle, const FieldAt& fine) {
  Convergence fit;
  const double first = mean_distance(coarse.u, middle.u), second = mean_distance(middle.u, fine.u);
  // Three equal fields have converged; any order will do.
  fit.converges = first >= second * ratio_of_differences(least_order, coarse.h, middle.h, fine.h) * (1.0 - 1e-9);
  fit.order = second > 0.0 ? order_of(first / second, coarse.h, middle.h, fine.h) : most_order;
  const double fine_part = std::pow(fine.h, fit.order);
  const double share = fine_part / (std::pow(middle.h, fit.order) - fine_part);
  fit.limit.resize(fine.u.size());
  for (std::size_t i = 0; i < fine.u.size(); ++i) fit.limit[i] = fine.u[i] + share * (fine.u[i] - middle.u[i]);
  fit.scale = mean_distance(fit.limit, VecList(fit.limit.size(), Vec3::Zero()));
  return fit;
}

double estimated_error(const Convergence& fit, const FieldAt& field, const FieldAt& finest) {
  double error = mean_distance(field.u, fit.limit);
  if (field.h > twice_as_fine * finest.h) {
    const double own = std::pow(field.h, fit.order);
    error = std::max(error, mean_distance(field.u, finest.u) * own / (own - std::pow(finest.h, fit.order)));
  }
  return error / fit.scale;
}

namespace {

constexpr double refinement = 1.4142135623730951;
/// Of the distance of the finest body from the limit, which is extrapolated: how far the limit may be off.
constexpr double doubt = 0.5;
/// Of the first body: a first spacing is taken if it gives so many.
constexpr Index fewest_particles = 100, wanted_particles = 180, most_first_particles = 320;
constexpr Index fewest_at_all = 30;
constexpr int most_first_tries = 14;
constexpr double first_guess = 0.1;  // m: a body that is finer than it need be costs time, one that is coarser none
constexpr double finest_guess = 1e-6;
constexpr double most_particles = 2e6;
constexpr int same_body_tries = 6;
/// Of PlanOptions::max_error: a body with less is a good enough reference for the coarser ones. While little of the
/// budget is used, finer bodies make a better one.
constexpr double enough_error = 0.5, best_error = 0.2;
constexpr double for_better = 0.25;  // share of the budget
/// Share of the budget for refining; the rest is for choosing.
constexpr double for_refining = 0.7;
constexpr int most_bisections = 2;
constexpr double for_both = 1.5;  // times a body's own seconds: for a bisection, and a little for choosing
constexpr std::size_t fitted = 3;
constexpr double least_difference = 0.1;
constexpr int most_failures = 3;  // one after another

}  // namespace

Planner::Planner(SceneBuilder builder, PlanOptions options, double guess)
    : plan_{.options = std::move(options), .builder = std::move(builder)},
      prober_(plan_.builder, plan_.options),
      guess_(guess) {
  first_.backend = plan_.options.backends.front();
  first_.step = *std::ranges::max_element(plan_.options.steps);
}

bool Planner::goes_to_next_backend(const std::exception& error) {
  const auto* const own = dynamic_cast<const Error*>(&error);
  const std::vector<std::string>& backends = plan_.options.backends;
  if (own == nullptr || own->code() != ErrorCode::not_supported || !levels_.empty()) return false;
  const auto tried = std::ranges::find(backends, first_.backend);
  const auto next = std::find_if(tried, backends.end(), [&](const std::string& name) {
    return std::find(backends.begin(), tried + 1, name) == tried + 1;
  });
  if (next == backends.end()) return false;
  first_.backend = *next;
  return true;
}

double Planner::first_spacing() {
  const PlanOptions& options = plan_.options;
  if (options.coarsest > 0.0) return options.coarsest;
  double spacing = guess_ > 0.0 ? guess_ : first_guess, best = 0.0, best_off = 0.0;
  std::string refusal = "the budget ended";
  double tried = spacing;
  for (int k = 0; k < most_first_tries && prober_.left() > 0.0 && spacing > finest_guess; ++k) {
    Index particles = 0;
    PlanCandidate candidate = first_;
    candidate.spacing = tried = spacing;
    try {
      particles = own_particles(prober_.build(candidate).model());
    } catch (const SceneError&) {
      throw;
    } catch (const std::exception& error) {
      const auto* const own = dynamic_cast<const Error*>(&error);
      if (own != nullptr && own->code() == ErrorCode::unknown_name) throw;  // of a group: no spacing mends that
      if (goes_to_next_backend(error)) {
        --k;
        continue;
      }
      refusal = error.what();
      if (best > 0.0 || spacing <= options.finest) break;
      spacing *= 0.5;
      continue;
    }
    const double off = std::abs(std::log(static_cast<double>(particles) / wanted_particles));
    if (best == 0.0 || off < best_off) best = spacing, best_off = off;
    if (particles >= fewest_particles && particles <= most_first_particles) break;
    spacing *= std::clamp(std::cbrt(static_cast<double>(particles) / wanted_particles), 0.5, 4.0);
  }
  if (best == 0.0) {
    throw SceneError("the builder made no body at any spacing, last at " + to_decimal(tried) + " m: " + refusal);
  }
  return std::max(best, options.finest);
}

/// s, of a body of another spacing.
double Planner::predicted_seconds(double spacing) const {
  const auto last =
      std::find_if(levels_.rbegin(), levels_.rend(), [](const Level& it) { return it.probe.seconds > 0.0; });
  if (last == levels_.rend()) return 0.0;
  const bool by_steps = last->probe.by_steps || prober_.probes_motion();
  return last->probe.seconds * std::pow(last->trial.candidate.spacing / spacing, by_steps ? 4.0 : 3.3);
}

bool Planner::add_level(double spacing, bool in_ladder) {
  Level level;
  level.in_ladder = in_ladder;
  level.trial.candidate = first_;
  level.trial.candidate.spacing = spacing;
  bool is_new = true;
  const auto is_known = [&](const Probe& made) {
    for (const Level& it : levels_) {
      if (it.probe.particles == made.particles && it.probe.h == made.h) is_new = false;
      // Bodies of nearly one spacing, as where the cells of a single direction differ, would spoil the fit.
      if (it.in_ladder && std::abs(it.probe.h / made.h - 1.0) < least_difference) level.in_ladder = false;
    }
    return !is_new;
  };
  try {
    level.probe = prober_.probe(level.trial.candidate, is_known);
  } catch (const SceneError&) {
    throw;
  } catch (const std::exception& error) {
    if (goes_to_next_backend(error)) return add_level(spacing, in_ladder);
    level.probe.failure = error.what();
  }
  if (!is_new) return false;
  const Probe& probe = level.probe;
  PlanTrial& trial = level.trial;
  trial.particles = probe.particles;
  trial.mean_spacing = probe.h;
  trial.tick = probe.tick;
  trial.real_time = prober_.tick_length() / probe.tick;
  trial.rest = probe.rest_seconds;
  trial.rest_by_steps = probe.by_steps;
  trial.note = probe.failure.empty() ? probe.note : probe.failure;
  trial.keeps_time = keeps_time(trial);
  const auto place =
      std::ranges::find_if(levels_, [&](const Level& it) { return it.trial.candidate.spacing < spacing; });
  levels_.insert(place, std::move(level));
  return true;
}

void Planner::estimate_errors() {
  std::vector<const Level*> ladder;
  for (const Level& level : levels_) {
    if (level.in_ladder && level.has_field()) ladder.push_back(&level);
  }
  if (ladder.size() < fitted) return;
  // Where there are five, those with spacings in ratio two: what differs by chance between two bodies weighs less.
  const std::size_t stride = std::min<std::size_t>(2, (ladder.size() - 1) / 2), last = ladder.size() - 1;
  const auto field = [](const Level& level) { return FieldAt{level.probe.h, level.probe.u}; };
  const FieldAt finest = field(*ladder[last]);
  const Convergence fit = fit_convergence(field(*ladder[last - 2 * stride]), field(*ladder[last - stride]), finest);
  if (!(fit.scale > 0.0)) throw SceneError("nothing moves in this scene; give it a load, or PlanOptions::probe_time");
  plan_.order = fit.order;
  const double doubtful = doubt * mean_distance(finest.u, fit.limit) / fit.scale;
  // A material means nothing where it is inside out, and finer bodies may rest elsewhere.
  const bool folds = ladder[last]->probe.folded;
  double error_of_finer = 0.0;
  for (std::size_t k = levels_.size(); k-- > 0;) {
    Level& level = levels_[k];
    if (!level.has_field()) continue;
    error_of_finer = std::max(error_of_finer, estimated_error(fit, field(level), finest) + doubtful);
    level.trial.error = error_of_finer;
    level.trial.keeps_error = !folds && error_of_finer <= plan_.options.max_error;
  }
  plan_.notes.clear();
  if (!fit.converges) {
    plan_.notes.emplace_back("the displacements do not converge as expected; errors are guesses on the safe side");
  }
  if (folds) {
    plan_.notes.emplace_back(
        "cells of the finest body are flat or inside out at rest, so no error is certain: finer bodies may fold more "
        "and rest elsewhere; hold or load the body less abruptly there");
  }
}

std::optional<std::size_t> Planner::coarsest_kept() const {
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    if (levels_[k].trial.keeps_error) return k;
  }
  return std::nullopt;
}

void Planner::refine() {
  const PlanOptions& options = plan_.options;
  double spacing = first_spacing();
  int same = 0, failures = 0;
  for (;; spacing /= refinement) {
    if (!levels_.empty() && (spacing < options.finest * (1.0 - 1e-9) || prober_.left() < 0.0)) {
      ended_ = prober_.left() < 0.0 ? "the budget ended" : "PlanOptions::finest is reached";
      break;
    }
    if (!add_level(spacing, true)) {
      if (++same < same_body_tries) continue;
      const std::string bodies = "the builder makes no finer body than the one of " +
                                 std::to_string(levels_.back().probe.particles) + " particles";
      if (levels_.size() == 1) throw SceneError(bodies + "; it must use PlanCandidate::spacing");
      ended_ = bodies;
      break;
    }
    same = 0;
    estimate_errors();
    const Level& finest = levels_.back();
    failures = finest.has_field() ? 0 : failures + 1;
    if (failures == most_failures) {
      ended_ = "finer bodies fail: " + finest.trial.note;
      break;
    }
    const double with_next = prober_.elapsed() + predicted_seconds(spacing / refinement);
    const bool may_be_better = with_next < for_better * options.budget;
    if (finest.trial.error <= (may_be_better ? best_error : enough_error) * options.max_error) {
      ended_ = "the errors are known well enough";
      break;
    }
    const double share = levels_.size() < fitted ? 1.0 : for_refining;
    if (with_next > share * options.budget) {
      ended_ = "a finer body would exceed the budget";
      break;
    }
    if (finest.probe.particles * std::pow(refinement, 3.0) > most_particles) {
      ended_ = "a finer body would be too large";
      break;
    }
  }
  if (std::ranges::none_of(levels_, [](const Level& level) { return level.has_field(); })) {
    throw SceneError("no body could be measured; the finest, of spacing " +
                     to_decimal(levels_.back().trial.candidate.spacing) + " m: " + levels_.back().trial.note);
  }
}

void Planner::coarsen() {
  if (plan_.options.coarsest > 0.0) return;
  double spacing = levels_.front().trial.candidate.spacing;
  for (int same = 0; same < same_body_tries && prober_.left() > 0.0;) {
    const Level& coarsest = levels_.front();
    if (!coarsest.trial.keeps_error || coarsest.probe.particles <= fewest_at_all) return;
    spacing *= refinement;
    same = add_level(spacing, false) ? 0 : same + 1;
    estimate_errors();
  }
}

void Planner::bisect() {
  for (int k = 0; k < most_bisections; ++k) {
    const std::optional<std::size_t> kept = coarsest_kept();
    if (!kept || *kept == 0) return;
    const double fine = levels_[*kept].trial.candidate.spacing, coarse = levels_[*kept - 1].trial.candidate.spacing;
    if (prober_.left() < for_both * levels_[*kept].probe.seconds) return;
    if (!add_level(std::sqrt(fine * coarse), false)) return;
    estimate_errors();
  }
}

Plan Planner::run() {
  refine();
  coarsen();
  bisect();
  choose();
  for (const Level& level : levels_) plan_.trials.push_back(level.trial);
  plan_.trials.insert(plan_.trials.end(), measured_.begin(), measured_.end());
  std::ranges::stable_sort(plan_.trials, std::greater{}, [](const PlanTrial& it) { return it.candidate.spacing; });
  plan_.seconds = prober_.elapsed();
  return std::move(plan_);
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include "run_loop.h"

#include <phymul/bodies.h>
#include <phymul/error.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "surface_body.h"

namespace {

constexpr int samples_per_frame = 10;
constexpr double default_sample_interval = 0.005;  // s, where no frames are asked for
constexpr double time_to_rest = 20.0;              // s after the last date, unless --max-time says otherwise
constexpr double tear_interval = 1e-3;             // s: each call of the simulation parts a row of cells at a front

/// m^2 at rest, of one face of all cuts.
double cut_area(const phymul::Model& model) {
  const phymul::TissueSurface surface = tissue_surface(model);
  const phymul::VecList place = surface.at(model.rest);
  double twice = 0.0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    if (surface.of_cut[t] != 0) twice += 0.5 * (place[b] - place[a]).cross(place[c] - place[a]).norm();
  }
  return 0.5 * twice;
}

}  // namespace

RunLoop::RunLoop(const RunOptions& options, const RunSchedule& schedule, phymul::Simulation& sim, Progress& progress)
    : options_(options),
      schedule_(schedule),
      sim_(sim),
      solver_(sim.unrecorded_solver()),
      model_(sim.model()),
      progress_(progress) {
  // What is imposed from the beginning, and never changes, has no last date at which it would be let go.
  const bool lets_go = schedule.has_driven && !options.keep && (options.let_go || schedule.let_go > 0.0);
  if (lets_go) let_go_date_ = options.let_go.value_or(schedule.let_go);
  if (schedule.has_driven) pull_date_ = std::min(schedule.largest_pull, let_go_date_.value_or(schedule.largest_pull));
  settle_date_ = schedule.last_date;
  if (schedule.has_driven) settle_date_ = std::max(settle_date_, let_go_date_.value_or(schedule.let_go));
  end_ = options.max_time.value_or(settle_date_ + time_to_rest);
  sample_interval_ =
      options.frame_interval > 0.0 ? options.frame_interval / samples_per_frame : default_sample_interval;
  if (options.frame_interval > 0.0) {
    std::filesystem::create_directories(options.out + "/frames");
    series_.emplace(options.out + "/frames/body");
  }
  if (options.tearing) first_cut_area_ = cut_area(model_);
  energies_.open(options.out + "/energies.csv");
  if (!energies_) throw phymul::Error(options.out + "/energies.csv: expected a file that can be written");
  energies_.precision(12);
  energies_ << "time,elastic,kinetic,gravity,total,residual,max_speed,max_displacement\n";
}

/// The default step is a whole part of the sample interval: samples and most dates then fall on steps.
void RunLoop::choose_step() {
  if (options_.dt) {
    summary_.dt = *options_.dt;
    return;
  }
  const double wanted = std::min(0.5 * solver_.stable_step(), sample_interval_);
  summary_.dt = sample_interval_ / std::ceil(sample_interval_ / wanted * (1.0 - 1e-9));
}

bool RunLoop::is_settling() const {
  return reached(settle_date_) && (!let_go_date_ || let_go_done_);
}

double RunLoop::next_date() const {
  double date = std::min(end_, static_cast<double>(samples_) * sample_interval_);
  if (options_.tearing) date = std::min(date, state_.time + tear_interval);
  if (pull_date_ && !pull_seen_) date = std::min(date, *pull_date_);
  if (let_go_date_ && !let_go_done_) date = std::min(date, *let_go_date_);
  return date;
}

/// False when the solver failed.
bool RunLoop::advance(double date) {
  const auto steps = static_cast<int>(std::clamp(std::round((date - state_.time) / summary_.dt), 1.0, 1e9));
  const auto start = std::chrono::steady_clock::now();
  // Undamped, nothing comes to rest, and run_to_rest() refuses.
  if (is_settling() && options_.damping_rate > 0.0 && !options_.tearing) {
    const phymul::RestResult rest = solver_.run_to_rest(steps, summary_.dt);
    report_ = rest.report;
    loose_ = rest.loose;
  } else {
    report_ = sim_.step(steps, summary_.dt);
  }
  summary_.wall_time += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary_.steps += report_.steps;
  summary_.torn += report_.torn;
  summary_.could_not_tear = summary_.could_not_tear || report_.uncut > 0;
  if (report_.torn > 0) choose_step();  // the stable one is shorter now
  return report_.ok();
}

void RunLoop::look() {
  solver_.read(state_);
  const phymul::Energy energy = solver_.energy();
  if (reached(static_cast<double>(samples_) * sample_interval_)) {
    energies_ << state_.time << ',' << energy.elastic << ',' << energy.kinetic << ',' << energy.gravity << ','
              << energy.total() << ',' << report_.residual << ',' << report_.max_speed << ','
              << displacement_norms(model_, state_).max << '\n';
    const auto frame_date = [&] { return static_cast<double>(frames_ * samples_per_frame) * sample_interval_; };
    if (series_ && reached(frame_date())) series_->write(model_, state_);
    while (reached(frame_date())) ++frames_;
    while (reached(static_cast<double>(samples_) * sample_interval_)) ++samples_;
  }
  remember_pull();
  if (let_go_date_ && !let_go_done_ && reached(*let_go_date_)) {
    summary_.let_go = snapshot("let go");
    summary_.snapshots.push_back(*summary_.let_go);
    draw("let_go.png", "let go", state_, false);
    let_go(sim_.scene());
    let_go_done_ = true;
    progress_.say("let go at " + std::to_string(state_.time) + " s");
  }
  progress_.show(state_.time, energy, report_,
                 summary_.wall_time > 0.0 ? static_cast<double>(summary_.steps) / summary_.wall_time : 0.0);
}

/// Where nothing is driven, the most deformed moment stands for the largest pull; not of a body that tears, which is
/// another one at the end.
void RunLoop::remember_pull() {
  // What is imposed from the beginning is there after a step.
  if (pull_date_ && !pull_seen_ && summary_.steps > 0 && reached(*pull_date_)) {
    pull_seen_ = true;
    pulled_ = state_;
    summary_.pulled = snapshot("largest pull");
    summary_.snapshots.push_back(*summary_.pulled);
    full_scale_ = summary_.pulled->displacement.max;
    draw("pulled.png", "largest pull", state_, false);
  } else if (!pull_date_ && !options_.tearing &&
             displacement_norms(model_, state_).max > pulled_shot_.displacement.max) {
    pulled_ = state_;
    pulled_shot_ = snapshot("most deformed");
  }
}

Snapshot RunLoop::snapshot(std::string label) const {
  return take_snapshot(std::move(label), solver_, state_, report_, schedule_.driven);
}

int RunLoop::run() {
  choose_step();
  look();
  while (true) {
    const bool settling = is_settling();
    if (settling && settling_from_ < 0) settling_from_ = summary_.steps;
    if (!advance(next_date())) return finish(true, false);
    look();
    const bool at_rest = settling && report_.at_rest && report_.torn == 0;
    if (at_rest || reached(end_)) return finish(false, at_rest);
  }
}

int RunLoop::finish(bool failed, bool at_rest) {
  solver_.read(state_);
  if (failed) summary_.failure = report_.message();
  const std::string moving = "not at rest after " + std::to_string(state_.time) + " s";
  summary_.status = failed       ? "the solver failed"
                    : at_rest    ? "at rest"
                    : loose_ < 0 ? moving + "; raise --max-time or --damping"
                                 : "nothing holds the part of particle " + std::to_string(loose_) +
                                       ": it moves away unless its loads balance; hold it, as with --fix; " + moving;
  if (at_rest) summary_.steps_to_rest = summary_.steps - settling_from_;
  summary_.at_rest = at_rest;
  if (options_.tearing) {
    summary_.torn_area = cut_area(model_) - first_cut_area_;
    summary_.pieces = connected_bodies(model_).size();
  }
  if (!pull_date_ && pulled_) {
    full_scale_ = pulled_shot_.displacement.max;
    draw("pulled.png", "most deformed", *pulled_, false);
    summary_.snapshots.push_back(pulled_shot_);
  }
  summary_.snapshots.push_back(snapshot(at_rest ? "at rest" : "at the end"));
  draw("rest.png", at_rest ? "at rest" : "at the end", state_, let_go_done_);
  energies_.close();
  if (!energies_)
    throw phymul::Error(options_.out + "/energies.csv: could not be written to its end; is the disk full?");
  return failed ? 2 : at_rest ? 0 : 3;
}

void RunLoop::draw(const std::string& file, const std::string& title, const phymul::State& state, bool is_let_go) {
  if (!options_.pictures) return;
  ScenePictureOptions picture;
  picture.title = (model_.name.empty() ? "body" : model_.name) + ": " + title;
  const bool tissue = is_cut(model_);  // whose picture has no particles
  char text[160];
  std::snprintf(text, sizeof text, tissue ? "t = %.4g s" : "t = %.4g s, %d particles", state.time,
                model_.particle_count());
  picture.subtitle = text;
  if (model_.materials.size() == 1) {
    const phymul::Material& material = model_.materials.front();
    std::snprintf(text, sizeof text, ", E = %.4g kPa, Poisson's ratio %.3g", 1e-3 * material.young, material.poisson);
    picture.subtitle += text;
  }
  std::snprintf(text, sizeof text, "; at most %.3g mm from the rest shape",
                1e3 * displacement_norms(model_, state).max);
  picture.subtitle += text;
  picture.full_scale = full_scale_;
  if (!tissue) picture.held = schedule_.held;
  if (!is_let_go && !tissue) picture.driven = schedule_.driven;
  picture.width = 900;
  picture.height = 1000;
  picture.eye = {0.75, -1.0, 0.45};
  if (pulled_) {
    picture.frame = pulled_->position;
    picture.frame.insert(picture.frame.end(), model_.rest.begin(), model_.rest.end());
    picture.frame.insert(picture.frame.end(), state.position.begin(), state.position.end());
  }
  if (tissue) return draw_tissue(model_, state, picture, options_.out + '/' + file);
  if (!pictures_) pictures_.emplace(model_);
  pictures_->draw(state, picture, options_.out + '/' + file);
}

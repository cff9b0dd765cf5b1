// SPDX-License-Identifier: MIT
#include "run_report.h"

#include <phymul/topology_textures.h>
#include <unistd.h>

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>

using phymul::StepReport;

Snapshot take_snapshot(std::string label, const phymul::Solver& solver, const phymul::State& state,
                       const StepReport& report, const std::vector<phymul::Index>& driven) {
  const phymul::Model& model = solver.model();
  Snapshot shot;
  shot.label = std::move(label);
  shot.time = state.time;
  shot.energy = solver.energy();
  shot.residual = report.residual;
  shot.max_speed = report.max_speed;
  shot.linear_momentum = linear_momentum(model, state).norm();
  shot.angular_momentum = angular_momentum(model, state, centre_of_mass(model, state)).norm();
  const double rest_volume = volume(model, model.rest);
  shot.volume_ratio = rest_volume > 0.0 ? volume(model, state.position) / rest_volume : 0.0;
  shot.displacement = displacement_norms(model, state);
  for (const phymul::Index i : driven) shot.driven = std::max(shot.driven, (state.position[i] - model.rest[i]).norm());
  return shot;
}

Progress::Progress(bool quiet)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      interval_(terminal_ ? 200 : 3000),
      next_(std::chrono::steady_clock::now()) {
  if (!terminal_) next_ += interval_;
}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', stderr);
}

bool Progress::is_due() {
  if (quiet_) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return false;
  next_ = now + interval_;
  return true;
}

/// \033[K clears what a longer line has left.
void Progress::print(const char* line) {
  std::fprintf(stderr, terminal_ ? "\r%s\033[K" : "%s\n", line);
  std::fflush(stderr);
  line_open_ = terminal_;
}

void Progress::show(double time, const phymul::Energy& energy, const StepReport& report, double steps_per_second) {
  if (!is_due()) return;
  char line[256];
  std::snprintf(line, sizeof line,
                "t = %8.4f s  elastic %.3e J  kinetic %.3e J  residual %.2e N  speed %.2e m/s  %.0f steps/s", time,
                energy.elastic, energy.kinetic, report.residual, report.max_speed, steps_per_second);
  print(line);
}

void Progress::show(const phymul::StepProgress& progress) {
  if (!is_due()) return;
  char line[256];
  std::snprintf(line, sizeof line, "t = %8.4f s  step %d of at most %d  residual %.2e N  speed %.2e m/s", progress.time,
                progress.steps, progress.of, progress.residual, progress.max_speed);
  print(line);
}

void Progress::show_trial(double spacing, int particles) {
  if (!is_due()) return;
  char line[128];
  std::snprintf(line, sizeof line, "spacing %.4g m: %d particles", spacing, particles);
  print(line);
}

void Progress::say(const std::string& sentence) {
  if (quiet_) return;
  std::fprintf(stderr, "%s%s\n", line_open_ ? "\r\033[K" : "", sentence.c_str());
  line_open_ = false;
}

namespace {

void row(const char* name, const std::vector<Snapshot>& shots, const char* format,
         const std::function<double(const Snapshot&)>& value) {
  std::printf("  %-34s", name);
  for (const Snapshot& shot : shots) {
    char text[32];
    std::snprintf(text, sizeof text, format, value(shot));
    std::printf("%16s", text);
  }
  std::printf("\n");
}

void print_moments(const std::vector<Snapshot>& shots) {
  std::printf("  %-34s", "");
  for (const Snapshot& shot : shots) std::printf("%16s", shot.label.c_str());
  std::printf("\n");
  row("time, s", shots, "%.4f", [](const Snapshot& s) { return s.time; });
  row("elastic energy, J", shots, "%.4e", [](const Snapshot& s) { return s.energy.elastic; });
  row("kinetic energy, J", shots, "%.4e", [](const Snapshot& s) { return s.energy.kinetic; });
  row("largest residual force, N", shots, "%.3e", [](const Snapshot& s) { return s.residual; });
  row("largest speed, m/s", shots, "%.3e", [](const Snapshot& s) { return s.max_speed; });
  row("linear momentum, kg m/s", shots, "%.3e", [](const Snapshot& s) { return s.linear_momentum; });
  row("angular momentum, kg m^2/s", shots, "%.3e", [](const Snapshot& s) { return s.angular_momentum; });
  row("distance from rest shape, rms, mm", shots, "%.4g", [](const Snapshot& s) { return 1e3 * s.displacement.rms; });
  row("distance from rest, largest, mm", shots, "%.4g", [](const Snapshot& s) { return 1e3 * s.displacement.max; });
  if (shots.front().volume_ratio > 0.0) {
    row("volume / rest volume", shots, "%.5f", [](const Snapshot& s) { return s.volume_ratio; });
  }
}

}  // namespace

void print_profile(const std::vector<phymul::PassProfile>& passes, const RunSummary& summary) {
  // The device's own times, where it has any; else those of the thread that works for this program.
  const auto cost = [](const phymul::PassProfile& pass) {
    return std::isnan(pass.device_seconds) ? pass.seconds : pass.device_seconds;
  };
  double all = 0.0;
  for (const phymul::PassProfile& pass : passes) all += cost(pass);
  std::printf("\n  %-24s%12s%12s%12s%10s%14s\n", "pass", "runs", "host, s", "device, s", "share, %", "us a step");
  const double steps = std::max<double>(1.0, static_cast<double>(summary.steps));
  for (const phymul::PassProfile& pass : passes) {
    char device[32] = "-";
    if (!std::isnan(pass.device_seconds)) std::snprintf(device, sizeof device, "%.4f", pass.device_seconds);
    std::printf("  %-24s%12" PRId64 "%12.4f%12s%10.1f%14.3f\n", pass.name.c_str(), pass.runs, pass.seconds, device,
                all > 0.0 ? 100.0 * cost(pass) / all : 0.0, 1e6 * cost(pass) / steps);
  }
  std::printf("  %-24s%12" PRId64 "%12.4f%12s%10.1f%14.3f\n", "all, of the wall time", summary.steps, summary.wall_time,
              "", summary.wall_time > 0.0 ? 100.0 * all / summary.wall_time : 0.0, 1e6 * summary.wall_time / steps);
}

void print_table(const phymul::Solver& solver, const RunSummary& summary) {
  const phymul::TopologyTextures& topology = solver.topology();
  std::printf("\n%s: %s\n\n", solver.model().name.empty() ? "body" : solver.model().name.c_str(),
              summary.status.c_str());
  std::printf("  %-34s%16d\n", "particles", topology.particle_count);
  std::printf("  %-34s%16d\n", "bases", topology.base_count);
  std::printf("  %-34s%16zu\n", "springs", topology.springs.size());
  std::printf("  %-34s%16zu\n", "volume terms", topology.volumes.size());
  std::printf("  %-34s%16zu\n", "mean deformations", topology.domains.size());
  std::printf("  %-34s%16s\n", "backend", std::string(solver.name()).c_str());
  std::printf("  %-34s%16.4e\n", "step, s", summary.dt);
  std::printf("  %-34s%16.4e\n", "stable step at rest, s", solver.stable_step());
  std::printf("  %-34s%16" PRId64 "\n", "steps", summary.steps);
  if (summary.steps_to_rest >= 0)
    std::printf("  %-34s%16" PRId64 "\n", "steps to rest after the last date", summary.steps_to_rest);
  std::printf("  %-34s%16.4f\n", "simulated time, s", summary.snapshots.empty() ? 0.0 : summary.snapshots.back().time);
  std::printf("  %-34s%16.3f\n", "wall time of stepping, s", summary.wall_time);
  if (summary.wall_time > 0.0) {
    std::printf("  %-34s%16.4g\n", "particle-steps/s",
                static_cast<double>(summary.steps) * topology.particle_count / summary.wall_time);
  }
  std::printf("\n");
  if (!summary.snapshots.empty()) print_moments(summary.snapshots);
}

namespace {

/// "acceleration, gravity": what pushes the body, by kind.
std::string kinds_of_pushes(const phymul::Scene& scene) {
  std::set<std::string> kinds;
  for (const phymul::Load& load : scene.loads()) {
    if (!is_pushing(load)) continue;
    kinds.insert(load.type == phymul::LoadType::force      ? "force"
                 : load.type == phymul::LoadType::pressure ? "pressure"
                                                           : "acceleration");
  }
  if (!scene.gravity().isZero(0.0)) kinds.insert("gravity");
  std::string text;
  for (const std::string& kind : kinds) text += (text.empty() ? "" : ", ") + kind;
  return text;
}

}  // namespace

void print_story(const phymul::Scene& scene, const RunSchedule& schedule, const RunSummary& summary) {
  std::printf("\n  %zu particles held, %zu driven", schedule.held.size(), schedule.driven.size());
  const std::string pushes = kinds_of_pushes(scene);
  if (!pushes.empty()) std::printf("; under %s", pushes.c_str());
  std::printf(".\n");
  if (summary.pulled) {
    std::printf("  Pulled at %.4g s: the driven particles are %.4g mm from their rest places.\n", summary.pulled->time,
                1e3 * summary.pulled->driven);
  }
  if (summary.let_go) {
    std::printf("  Let go at %.4g s, the driven particles %.4g mm from their rest places.\n", summary.let_go->time,
                1e3 * summary.let_go->driven);
    if (summary.pulled && summary.let_go->driven < 0.5 * summary.pulled->driven) {
      std::printf("    The loads had led them back by then; --let-go %.4g lets go at the largest pull.\n",
                  summary.pulled->time);
    }
  }
  if (summary.pieces > 0) {
    std::printf("  Torn: %" PRId64 " cells, %.4g mm^2 of %zu %s.%s\n", summary.torn, 1e6 * summary.torn_area,
                summary.pieces, summary.pieces == 1 ? "piece" : "pieces",
                summary.could_not_tear
                    ? " Cells should have torn that could not: cut three times, or no spare particles."
                    : "");
  }
  const bool acts = !scene.gravity().isZero(0.0) || std::ranges::any_of(scene.loads(), [](const phymul::Load& load) {
    return is_pushing(load) && load.events.back().value != 0.0;
  });
  const Snapshot& end = summary.snapshots.back();
  std::printf("  %s at %.4g s, at most %.4g mm from the rest shape%s.\n", summary.at_rest ? "At rest" : "Stopped",
              end.time, 1e3 * end.displacement.max, summary.at_rest && acts ? " under what still acts" : "");
}

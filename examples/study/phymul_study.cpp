// SPDX-License-Identifier: MIT
//
// phymul-study STUDY: the rest shapes of a table of scenes, on one machine or many.
#include <phymul/error.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <thread>

#include "file.h"
#include "fit.h"
#include "journal.h"
#include "measurement.h"
#include "options.h"
#include "progress.h"
#include "ranks.h"
#include "sampler.h"
#include "scene.h"
#include "tables.h"

namespace {

using Scenes = std::vector<std::vector<double>>;

/// Paths in a study are relative to it, as its words are to phymul-run's folder.
void enter_folder_of(StudyOptions& options) {
  options.out = std::filesystem::absolute(options.out).string();
  const std::filesystem::path study = std::filesystem::absolute(options.study);
  if (!std::filesystem::exists(study)) throw phymul::Error(options.study + ": expected a study file that can be read");
  std::filesystem::current_path(study.parent_path());
  options.study = study.filename().string();
}

std::vector<double> first_scene(const Study& study) {
  if (!study.identifies()) return study_table(study).front();
  std::vector<double> guesses;
  for (const StudyUnknown& it : study.unknowns) guesses.push_back(it.guess);
  return guesses;
}

int show(const Study& study, int scene) {
  const Scenes scenes = study.identifies() ? Scenes{first_scene(study)} : study_table(study);
  if (static_cast<std::size_t>(scene) > scenes.size()) {
    throw phymul::Error("--show: expected a scene of 1 to " + std::to_string(scenes.size()) + ", got " +
                        std::to_string(scene));
  }
  std::string command = "phymul-run";
  for (const std::string& word : scene_words(study, scenes[scene - 1])) command += ' ' + quoted_word(word);
  std::printf("cd %s && %s\n", quoted_word(std::filesystem::current_path().string()).c_str(), command.c_str());
  return 0;
}

int synthesise(Study& study, const StudyOptions& options) {
  std::vector<double> values;
  for (const StudyUnknown& it : study.unknowns) {
    const auto given = std::ranges::find(options.synthesise, it.name, &std::pair<std::string, double>::first);
    if (given == options.synthesise.end()) throw phymul::Error("--synthesise: expected a value of " + it.name);
    values.push_back(given->second);
  }
  if (values.empty() || values.size() != options.synthesise.size()) {
    throw phymul::Error("--synthesise: expected a value of each unknown of the study, and of nothing else");
  }
  const SceneResult result = SceneSolver(study).solve(values);
  if (!result.failure.empty()) throw phymul::Error("--synthesise: " + result.failure);
  const double* moved = &result.values[target_values * study.targets.size()];
  NormalNoise noise(options.noise_seed);
  study.measurement.displacement.clear();
  for (std::size_t k = 0; k < study.measurement.point.size(); ++k) {
    phymul::Vec3& u = study.measurement.displacement.emplace_back(moved[3 * k], moved[3 * k + 1], moved[3 * k + 2]);
    for (int axis = 0; axis < 3; ++axis) u[axis] += study.measurement.deviation * noise.next();
  }
  write_measurement(study.measured_file, study.measurement);
  return 0;
}

/// Results of scenes in their order: those that are known, and the others, which all processes share.
std::vector<SceneResult> results_of(const Scenes& scenes, StudyJournal& journal, StudyRanks& ranks, bool quiet) {
  std::set<std::vector<double>> missing;
  Scenes to_do;
  for (const std::vector<double>& scene : scenes) {
    if (!journal.find(scene) && missing.insert(scene).second) to_do.push_back(scene);
  }
  {
    StudyProgress progress(quiet, scenes.size(), scenes.size() - to_do.size());
    ranks.solve(to_do, [&](SceneJob job) {
      const SceneResult& result = journal.add(job.values, std::move(job.result));
      progress.done(!result.failure.empty());
    });
  }
  std::vector<SceneResult> results;
  for (const std::vector<double>& scene : scenes) results.push_back(*journal.find(scene));
  return results;
}

int identify(const Study& study, const StudyOptions& options, StudyJournal& journal, StudyRanks& ranks) {
  if (journal.size() > 0 && !options.quiet) std::fprintf(stderr, "%zu scenes were done before\n", journal.size());
  // How many scenes the search will need is not known.
  auto next = std::chrono::steady_clock::now() + std::chrono::seconds(3);
  const SceneEvaluator evaluate = [&](const Scenes& scenes) {
    std::vector<SceneResult> results = results_of(scenes, journal, ranks, true);
    if (const auto now = std::chrono::steady_clock::now(); !options.quiet && now >= next) {
      std::fprintf(stderr, "%zu scenes solved so far\n", journal.size());
      next = now + std::chrono::seconds(3);
    }
    return results;
  };
  const StudyFit fit = fit_unknowns(study, evaluate, ranks.slots() > 1);
  write_fit(options.out + "/fit.csv", fit);
  if (!options.quiet) std::fprintf(stderr, "%zu scenes solved in all\n", journal.size());
  if (!fit.converged) std::fprintf(stderr, "phymul-study: the search did not converge; give other guesses\n");
  return fit.converged ? 0 : 3;
}

int tabulate(const Study& study, const StudyOptions& options, StudyJournal& journal, StudyRanks& ranks) {
  const Scenes scenes = study_table(study);
  const std::vector<SceneResult> results = results_of(scenes, journal, ranks, options.quiet);
  write_scenes(options.out + "/scenes.csv", study, scenes, results);
  write_spreads(options.out + "/targets.csv", study, scenes, results);
  std::size_t failed = 0;
  for (std::size_t k = 0; k < results.size(); ++k) {
    if (results[k].failure.empty() || ++failed > 3) continue;
    std::fprintf(stderr, "phymul-study: scene %zu has no result: %s\n", k + 1, results[k].failure.c_str());
  }
  if (failed > 3) std::fprintf(stderr, "phymul-study: ... and %zu more, in scenes.csv\n", failed - 3);
  return failed > 0 ? 2 : 0;
}

/// Everything before the work: what is wrong is said once, by one process, and all of them end.
struct Preparation {
  StudyOptions options;
  Study study;
  std::unique_ptr<SceneSolver> solver;
  std::unique_ptr<StudyJournal> journal;  // of rank 0
  std::uint32_t fingerprint = 0;

  /// True: the program has done what was asked for.
  bool prepare(int rank, int& exit_code) {
    enter_folder_of(options);
    study = read_study(options.study, options.synthesise.empty());
    if (options.show > 0 || !options.synthesise.empty()) {
      if (rank == 0) exit_code = options.show > 0 ? show(study, options.show) : synthesise(study, options);
      return true;
    }
    const std::vector<double> first = first_scene(study);
    solver = std::make_unique<SceneSolver>(study);
    solver->try_out(first);
    fingerprint = study_fingerprint(study, first);
    if (rank > 0) return false;
    std::filesystem::create_directories(options.out);
    journal = std::make_unique<StudyJournal>(options.out + "/results.txt", fingerprint);
    for (const std::string& note : journal->notes()) std::fprintf(stderr, "note: %s\n", note.c_str());
    return false;
  }
};

int threads_of(const StudyOptions& options, const StudyRanks& ranks) {
  if (options.threads > 0) return options.threads;
  return ranks.size() > 1 ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int run(int argc, char** argv, StudyRanks& ranks) {
  int exit_code = 0;
  Preparation it;
  const std::optional<StudyOptions> options = read_study_options(argc, argv, ranks.rank() == 0, exit_code);
  if (!options) return exit_code;
  it.options = *options;
  std::string problem;
  bool is_done = false;
  try {
    is_done = it.prepare(ranks.rank(), exit_code);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (const std::optional<std::string> verdict = ranks.agree(problem, it.fingerprint)) {
    if (!verdict->empty()) std::fprintf(stderr, "phymul-study: %s\n", verdict->c_str());
    return 1;
  }
  if (is_done) return exit_code;
  ranks.begin(threads_of(it.options, ranks), [&]() -> SceneWork {
    return [solver = *it.solver](const std::vector<double>& values) mutable { return solver.solve(values); };
  });
  if (ranks.rank() > 0) return 0;
  if (it.study.identifies()) return identify(it.study, it.options, *it.journal, ranks);
  return tabulate(it.study, it.options, *it.journal, ranks);
}

}  // namespace

int main(int argc, char** argv) {
  StudyRanks ranks(&argc, &argv);
  try {
    return run(argc, argv, ranks);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "phymul-study: %s\n", error.what());
    ranks.abort_if_awaited();
    return 1;
  }
}

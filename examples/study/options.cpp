// SPDX-License-Identifier: MIT
#include "options.h"

#include <phymul/version.h>

#include <CLI/CLI.hpp>
#include <sstream>

namespace {

std::pair<std::string, double> true_value(const std::string& word) {
  const std::size_t equals = word.find('=');
  double value = 0.0;
  if (equals == 0 || equals == std::string::npos || !CLI::detail::lexical_cast(word.substr(equals + 1), value) ||
      !(value > 0.0)) {
    throw CLI::ValidationError("--synthesise", "expected NAME=VALUE, VALUE above 0, got " + word);
  }
  return {word.substr(0, equals), value};
}

}  // namespace

std::optional<StudyOptions> read_study_options(int argc, char** argv, bool prints, int& exit_code) {
  StudyOptions options;
  CLI::App app{
      "Finds the rest shapes of a table of scenes: how they depend on parameters, how certain the place of a target\n"
      "is, or with which stiffness the body moves as it was measured to. Under mpirun, the processes share the work."};
  app.name("phymul-study");
  app.set_version_flag("--version", PHYMUL_VERSION);
  app.footer(
      "Writes into the --out folder: results.txt, which a study that was cut short goes on from; scenes.csv and\n"
      "targets.csv, or fit.csv. Exit code: 0 done, 1 wrong input, 2 some scenes have no result, 3 the fit did not "
      "converge.");
  app.add_option("study", options.study, "the study file")->required();
  app.add_option("--out", options.out, "folder for results; made where it is missing")->capture_default_str();
  app.add_option("--threads", options.threads,
                 "of each process; 0: one where there are several processes, else all processors")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  app.add_flag("--quiet", options.quiet, "say nothing on the way");
  auto* show = app.add_option("--show", options.show, "print the phymul-run command of this scene, and solve nothing")
                   ->option_text("SCENE")
                   ->check(CLI::Range(1, 10'000'000));
  auto* synthesise = app.add_option_function<std::vector<std::string>>(
                            "--synthesise",
                            [&options](const std::vector<std::string>& words) {
                              for (const std::string& word : words) options.synthesise.push_back(true_value(word));
                            },
                            "write the measured file as it would be with these values of the unknowns, noise included")
                         ->option_text("NAME=VALUE ...")
                         ->excludes(show);
  app.add_option("--noise-seed", options.noise_seed, "of --synthesise")->capture_default_str()->needs(synthesise);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream nowhere;
    exit_code = (prints ? app.exit(error) : app.exit(error, nowhere, nowhere)) == 0 ? 0 : 1;
    return std::nullopt;
  }
  return options;
}

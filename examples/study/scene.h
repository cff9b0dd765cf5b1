// SPDX-License-Identifier: MIT
//
// One scene of a study: from the values of its parameters to where its targets and measured points are at rest.
#pragma once

#include <phymul/model.h>

#include <optional>
#include <string>
#include <vector>

#include "file.h"
#include "run_options.h"

struct SceneResult {
  std::string failure;         ///< empty: found
  std::vector<double> values;  ///< m; of each target its place and its displacement, then displacements of points
};

/// Values of a target: place x y z, displacement x y z.
constexpr std::size_t target_values = 6;

/// The words of phymul-run with the values in place of {expressions}. Throws phymul::Error with file and line.
std::vector<std::string> scene_words(const Study& study, const std::vector<double>& values);

/// Solves scenes one after the other; keeps the body where only materials and loads differ. One per thread.
class SceneSolver {
 public:
  explicit SceneSolver(const Study& study) : study_(study) {}

  /// A pure function of the study and the values: the same bits in whichever order and process. A scene that cannot be
  /// built or has no rest shape is a result that says why.
  SceneResult solve(const std::vector<double>& values);

  /// Builds the scene without solving it. Throws phymul::Error: what is wrong with the study is seen before any work.
  void try_out(const std::vector<double>& values);

 private:
  phymul::Model dressed(const RunOptions& options);
  std::vector<double> solve_or_throw(const std::vector<double>& values, bool only_build);

  const Study& study_;
  std::optional<RunOptions> shape_options_;
  phymul::Model shape_;
};

/// CRC-32 of everything that a result depends on besides the values of the parameters: the words, the targets, the
/// content of the files named, the version of the library. `values`: of any scene.
std::uint32_t study_fingerprint(const Study& study, const std::vector<double>& values);

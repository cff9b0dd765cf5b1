// SPDX-License-Identifier: MIT
//
// What a study found: tables as CSV and as text for people.
#pragma once

#include <Eigen/Core>

#include <array>
#include <span>
#include <string>
#include <vector>

#include "file.h"
#include "fit.h"
#include "scene.h"

/// How a target's place varies over the sampled parameters.
struct TargetSpread {
  int found = 0, failed = 0;                             ///< scenes
  phymul::Vec3 mean = phymul::Vec3::Zero();              ///< m, place
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2, of the place; divided by found - 1
  std::array<double, 3> displacement{};                  ///< m, percentiles 5, 50, 95 of the size of the displacement
  std::array<double, 3> distance{};  ///< m, percentiles 50, 90, 95 of the distance from the mean place
};

/// Of sorted values, with linear interpolation between them; `share` in [0, 1].
double percentile(const std::vector<double>& sorted, double share);

/// `results`: scenes that differ in the sampled parameters alone. `target`: row of Study::targets.
TargetSpread target_spread(std::span<const SceneResult> results, std::size_t target);

/// One row per scene. A table is there whole or not at all. Throws phymul::Error where it cannot be written.
void write_scenes(const std::string& path, const Study& study, const std::vector<std::vector<double>>& scenes,
                  const std::vector<SceneResult>& results);

/// One row per combination of the lists and target; also printed.
void write_spreads(const std::string& path, const Study& study, const std::vector<std::vector<double>>& scenes,
                   const std::vector<SceneResult>& results);

/// One row per unknown; also printed.
void write_fit(const std::string& path, const StudyFit& fit);

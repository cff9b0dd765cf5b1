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

/// Of the tables, besides the parameters and, of scenes, the targets' own ones, as in tip_ux.
constexpr const char* scene_columns = "scene,status,reason";
constexpr const char* spread_columns =
    "target,scenes,failed,mean_x,mean_y,mean_z,var_x,cov_xy,cov_xz,var_y,cov_yz,var_z,displacement_p05,displacement_"
    "p50,"
    "displacement_p95,distance_p50,distance_p90,distance_p95";
constexpr std::array<const char*, target_values> target_columns{"x", "y", "z", "ux", "uy", "uz"};

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

// SPDX-License-Identifier: MIT
#include "tables.h"

#include <phymul/error.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "run_options.h"
#include "sampler.h"

namespace {

/// Under another name until it is whole.
void write_whole(const std::string& path, const std::string& text) {
  const std::string draft = path + ".draft";
  std::ofstream out(draft, std::ios::binary);
  out << text;
  out.close();
  std::error_code problem;
  if (out) std::filesystem::rename(draft, path, problem);
  if (!out || problem) {
    throw phymul::Error(phymul::ErrorCode::file_access, path + ": this file cannot be written; is the disk full?",
                        path);
  }
}

std::string quoted_field(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

template <class Numbers>
void append(std::string& row, const Numbers& numbers) {
  for (const double number : numbers) row += ',' + shortest_decimal(number);
}

std::vector<double> sorted(std::vector<double> values) {
  std::ranges::sort(values);
  return values;
}

}  // namespace

double percentile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return std::nan("");
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

TargetSpread target_spread(std::span<const SceneResult> results, std::size_t target) {
  TargetSpread spread;
  phymul::VecList places;
  std::vector<double> displacements, distances;
  for (const SceneResult& it : results) {
    if (!it.failure.empty()) {
      ++spread.failed;
      continue;
    }
    const double* values = &it.values[target_values * target];
    places.emplace_back(values[0], values[1], values[2]);
    displacements.push_back(phymul::Vec3(values[3], values[4], values[5]).norm());
  }
  spread.found = static_cast<int>(places.size());
  if (places.empty()) return spread;
  for (const phymul::Vec3& place : places) spread.mean += place / spread.found;
  for (const phymul::Vec3& place : places) {
    const phymul::Vec3 off = place - spread.mean;
    if (spread.found > 1) spread.covariance += off * off.transpose() / (spread.found - 1);
    distances.push_back(off.norm());
  }
  displacements = sorted(displacements);
  distances = sorted(distances);
  spread.displacement = {percentile(displacements, 0.05), percentile(displacements, 0.5),
                         percentile(displacements, 0.95)};
  spread.distance = {percentile(distances, 0.5), percentile(distances, 0.9), percentile(distances, 0.95)};
  return spread;
}

void write_scenes(const std::string& path, const Study& study, const std::vector<std::vector<double>>& scenes,
                  const std::vector<SceneResult>& results) {
  std::string text = "scene";
  for (const std::string& name : study.names()) text += ',' + name;
  text += ",status";
  for (const StudyTarget& target : study.targets) {
    for (const char* column : target_columns) text += ',' + target.name + '_' + column;
  }
  text += ",reason\n";
  const std::string no_values(target_values * study.targets.size(), ',');
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    text += std::to_string(k + 1);
    append(text, scenes[k]);
    if (results[k].failure.empty()) {
      text += ",ok";
      append(text, std::span(results[k].values).first(no_values.size()));
      text += ",\n";
    } else {
      text += ",failed" + no_values + ',' + quoted_field(results[k].failure) + '\n';
    }
  }
  write_whole(path, text);
}

void write_spreads(const std::string& path, const Study& study, const std::vector<std::vector<double>>& scenes,
                   const std::vector<SceneResult>& results) {
  std::string text, printed;
  for (const StudyParameter& it : study.parameters) {
    if (it.spread == Spread::list) text += it.name + ',';
  }
  text += std::string(spread_columns) + '\n';
  const std::size_t each = scenes_of_a_combination(study);
  for (std::size_t first = 0; first < scenes.size(); first += each) {
    std::string combination, named;
    for (std::size_t p = 0; p < study.parameters.size(); ++p) {
      if (study.parameters[p].spread != Spread::list) continue;
      const std::string value = shortest_decimal(scenes[first][p]);
      combination += value + ',';
      named += study.parameters[p].name + " = " + value + ", ";
    }
    for (std::size_t t = 0; t < study.targets.size(); ++t) {
      const TargetSpread it = target_spread(std::span(results).subspan(first, each), t);
      const Eigen::Matrix3d& c = it.covariance;
      text += combination + study.targets[t].name + ',' + std::to_string(it.found) + ',' + std::to_string(it.failed);
      if (it.found > 0) {
        append(text,
               std::array{it.mean.x(), it.mean.y(), it.mean.z(), c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)});
        append(text, it.displacement);
        append(text, it.distance);
      } else {
        text += std::string(15, ',');
      }
      text += '\n';
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(c);
      const double widest = std::sqrt(std::max(0.0, axes.eigenvalues()[2]));
      const phymul::Vec3 along = axes.eigenvectors().col(2);
      char line[400];
      std::snprintf(line, sizeof line,
                    ": %d scenes, %d failed; moves %.2f mm (5%% %.2f, 95%% %.2f); 95%% within %.2f mm of the mean "
                    "place (%.2f %.2f %.2f) mm; deviation %.2f mm along (%.2f %.2f %.2f)\n",
                    it.found, it.failed, 1e3 * it.displacement[1], 1e3 * it.displacement[0], 1e3 * it.displacement[2],
                    1e3 * it.distance[2], 1e3 * it.mean.x(), 1e3 * it.mean.y(), 1e3 * it.mean.z(), 1e3 * widest,
                    along.x(), along.y(), along.z());
      printed += named + study.targets[t].name + line;
    }
  }
  write_whole(path, text);
  std::fputs(printed.c_str(), stdout);
}

void write_fit(const std::string& path, const StudyFit& fit) {
  std::string text = "unknown,value,deviation";
  for (const FittedUnknown& it : fit.unknowns) text += ",correlation_" + it.name;
  text += '\n';
  for (std::size_t k = 0; k < fit.unknowns.size(); ++k) {
    const FittedUnknown& it = fit.unknowns[k];
    text += it.name;
    append(text, std::array{it.value, it.deviation});
    append(text, std::vector<double>(fit.correlation.row(k).begin(), fit.correlation.row(k).end()));
    text += '\n';
    std::printf("%s = %.5g, standard deviation %.2g (%.2g %%)\n", it.name.c_str(), it.value, it.deviation,
                100.0 * it.deviation / it.value);
  }
  write_whole(path, text);
  for (std::size_t k = 0; k < fit.unknowns.size(); ++k) {
    for (std::size_t j = 0; j < k; ++j) {
      std::printf("correlation of %s and %s: %.2f\n", fit.unknowns[j].name.c_str(), fit.unknowns[k].name.c_str(),
                  fit.correlation(k, j));
    }
  }
  std::printf("misfit %.3f of the deviation given, over %d coordinates%s\n", fit.misfit, fit.coordinates,
              fit.misfit > 2.0 ? ": model and measurement disagree by more than the noise, and the deviations above "
                                 "do not hold"
                               : "");
}

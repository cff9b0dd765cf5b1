// SPDX-License-Identifier: MIT
#include "fit.h"

#include <phymul/error.h>

#include <Eigen/Eigenvalues>
#include <unsupported/Eigen/NonLinearOptimization>

#include <cmath>
#include <utility>

namespace {

/// Of a logarithm: the error of a central difference is about 1e-5 of the derivative, the noise of rest shapes found to
/// a tolerance of 1e-8 less.
constexpr double difference = 0.01;
constexpr int most_scenes = 200;  // that are tried; derivatives are not counted
/// Of the largest eigenvalue of the normal equations: less is a direction that the measurement does not see.
constexpr double unseen = 1e-10;

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weighted residuals and their derivatives, as Eigen's solver wants them.
class Residuals {
 public:
  using InputType = VectorXd;
  using ValueType = VectorXd;
  using JacobianType = MatrixXd;

  Residuals(const Study& study, const SceneEvaluator& evaluate, bool ahead)
      : study_(study), evaluate_(evaluate), ahead_(ahead) {}

  int inputs() const { return static_cast<int>(study_.unknowns.size()); }
  int values() const { return static_cast<int>(3 * study_.measurement.point.size()); }

  int operator()(const VectorXd& x, VectorXd& residual) const {
    std::vector<VectorXd> places{x};
    if (ahead_) {
      for (VectorXd& place : around(x)) places.push_back(std::move(place));
    }
    residual = at(places, 1).front();
    return 0;
  }

  int df(const VectorXd& x, MatrixXd& jacobian) const {
    const std::vector<VectorXd> places = around(x), sides = at(places, places.size());
    for (int k = 0; k < inputs(); ++k) jacobian.col(k) = (sides[2 * k] - sides[2 * k + 1]) / (2.0 * difference);
    return 0;
  }

 private:
  std::vector<VectorXd> around(const VectorXd& x) const {
    std::vector<VectorXd> places;
    for (int k = 0; k < inputs(); ++k) {
      for (const double step : {difference, -difference}) places.emplace_back(x)[k] += step;
    }
    return places;
  }

  /// Of the first `wanted` places. One of the others may have no result: the search may never need it.
  std::vector<VectorXd> at(const std::vector<VectorXd>& places, std::size_t wanted) const {
    std::vector<std::vector<double>> scenes;
    for (const VectorXd& x : places) {
      const VectorXd values = x.array().exp();
      scenes.emplace_back(values.begin(), values.end());
    }
    const std::vector<SceneResult> results = evaluate_(scenes);
    std::vector<VectorXd> found;
    for (std::size_t k = 0; k < wanted; ++k) found.push_back(residual(scenes[k], results[k]));
    return found;
  }

  VectorXd residual(const std::vector<double>& scene, const SceneResult& result) const {
    if (!result.failure.empty()) {
      std::string where;
      for (std::size_t k = 0; k < scene.size(); ++k) {
        where += (k > 0 ? ", " : "") + study_.unknowns[k].name + " = " + std::to_string(scene[k]);
      }
      throw phymul::Error(study_.file + ": the scene of " + where + " has no result: " + result.failure +
                          "; give other guesses");
    }
    const std::size_t first = target_values * study_.targets.size();
    VectorXd it(values());
    for (int k = 0; k < values(); ++k) {
      const double measured = study_.measurement.displacement[k / 3][k % 3];
      it[k] = (result.values[first + k] - measured) / study_.measurement.deviation;
    }
    return it;
  }

  const Study& study_;
  const SceneEvaluator& evaluate_;
  bool ahead_;
};

/// Of the logarithms of the unknowns.
MatrixXd covariance(const Study& study, const MatrixXd& jacobian) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(jacobian.transpose() * jacobian);
  const VectorXd& size = modes.eigenvalues();
  if (!(size[0] > unseen * size[size.size() - 1])) {
    std::string names;
    for (Eigen::Index k = 0; k < size.size(); ++k) {
      if (std::abs(modes.eigenvectors()(k, 0)) > 0.1) names += (names.empty() ? "" : ", ") + study.unknowns[k].name;
    }
    throw phymul::Error(study.file + ": the measured displacements do not determine " + names +
                        "; seek fewer unknowns, measure other points, or impose forces rather than displacements");
  }
  return modes.eigenvectors() * size.cwiseInverse().asDiagonal() * modes.eigenvectors().transpose();
}

}  // namespace

StudyFit fit_unknowns(const Study& study, const SceneEvaluator& evaluate, bool ahead) {
  Residuals residuals(study, evaluate, ahead);
  VectorXd x(residuals.inputs());
  for (int k = 0; k < residuals.inputs(); ++k) x[k] = std::log(study.unknowns[k].guess);
  Eigen::LevenbergMarquardt<Residuals> search(residuals);
  search.parameters.xtol = search.parameters.ftol = 1e-7;
  search.parameters.maxfev = most_scenes;
  const Eigen::LevenbergMarquardtSpace::Status status = search.minimize(x);

  StudyFit fit;
  fit.converged = status > 0 && status != Eigen::LevenbergMarquardtSpace::TooManyFunctionEvaluation;
  fit.coordinates = residuals.values();
  MatrixXd jacobian(residuals.values(), residuals.inputs());
  residuals.df(x, jacobian);
  const MatrixXd of_logarithms = covariance(study, jacobian);
  const VectorXd relative = of_logarithms.diagonal().cwiseSqrt();
  for (int k = 0; k < residuals.inputs(); ++k) {
    const double value = std::exp(x[k]);
    fit.unknowns.push_back({study.unknowns[k].name, value, value * relative[k]});
  }
  const MatrixXd scale = relative.cwiseInverse().asDiagonal();
  fit.correlation = scale * of_logarithms * scale;
  VectorXd residual(residuals.values());
  residuals(x, residual);
  const int freedom = residuals.values() - residuals.inputs();
  fit.misfit = freedom > 0 ? residual.norm() / std::sqrt(freedom) : 0.0;
  return fit;
}

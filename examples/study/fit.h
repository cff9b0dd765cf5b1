// SPDX-License-Identifier: MIT
//
// Identification: the values of unknowns with which the body moves as it was measured to, by nonlinear least squares.
#pragma once

#include <Eigen/Core>

#include <functional>
#include <string>
#include <vector>

#include "file.h"
#include "scene.h"

struct FittedUnknown {
  std::string name;
  double value = 0.0;
  double deviation = 0.0;  ///< standard deviation that the noise of the measurement gives it
};

struct StudyFit {
  std::vector<FittedUnknown> unknowns;
  Eigen::MatrixXd correlation;  ///< [unknowns][unknowns]
  double misfit = 0.0;  ///< root of (sum of squared residuals over their variance) / (coordinates - unknowns): about 1
  int coordinates = 0;
  bool converged = false;
};

/// Solves scenes, possibly several at a time; results in the order of the scenes.
using SceneEvaluator = std::function<std::vector<SceneResult>(const std::vector<std::vector<double>>&)>;

/// Levenberg-Marquardt (MINPACK's, in Eigen) on the logarithms of the unknowns, which thereby stay positive;
/// derivatives by central differences of 1 %. `ahead`: asks for the scenes of the derivatives together with each scene
/// tried, which saves time where scenes are solved at the same time. The result does not depend on it. Throws
/// phymul::Error for a scene without a rest shape, and if the measurement does not determine the unknowns.
StudyFit fit_unknowns(const Study& study, const SceneEvaluator& evaluate, bool ahead);

// SPDX-License-Identifier: MIT
//
// Materials (StrainEnergy::stiffening) from tests of homogeneously strained specimens.
#pragma once

#include <phymul/model.h>

#include <span>
#include <vector>

namespace phymul {

enum class StrainTest {
  uniaxial,  ///< tension and compression, free to the sides
  shear      ///< simple shear: a cube whose top moves along its base
};

struct TestPoint {
  StrainTest test = StrainTest::uniaxial;
  double strain = 1.0;  ///< uniaxial: stretch, from 0.6 to 1.7, not 1; shear: amount, from -1 to 1, not 0
  double stress = 0.0;  ///< nominal (force over area at rest), Pa, not 0; of the sign of the strain
};

/// Nominal stress, Pa, of the material without its fibres and dissipation. Throws Error for a material or a strain out
/// of range.
double nominal_stress(const Material& material, StrainTest test, double strain);

enum class FitGoal {
  least_squares,  ///< of the relative errors
  largest_error   ///< the least largest relative error
};

struct FitOptions {
  FitGoal goal = FitGoal::least_squares;
  // Terms of Material::stiffening. The others stay as given; with none Young's modulus alone is fitted.
  bool exponential = true;   ///< exponential and exponent
  bool second = true;        ///< second
  bool second_fades = true;  ///< second_fades; of no effect if `second` is 0
};

struct MaterialFit {
  Material material{};           ///< the given one with young and stiffening fitted
  std::vector<double> stress{};  ///< Pa, of the material at each point
  double largest_error = 0.0;    ///< relative, over all points
};

/// Fits young and stiffening of a material to points of tests, all of them at once. Poisson's ratio, density and the
/// rest stay as given; `start.young` may be 0. A fit of what lies within the strains of the points says little beyond
/// them. Throws Error for points out of range, for fewer points than constants, and if no constants were found that
/// set_material() accepts.
MaterialFit fit_material(std::span<const TestPoint> points, const Material& start, const FitOptions& options = {});

}  // namespace phymul

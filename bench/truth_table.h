// SPDX-License-Identifier: MIT
//
// What the cases of bench/truth.sh find, beside what is known; and what they share.
#pragma once

#include <phymul/phymul.h>

#include <cmath>
#include <map>
#include <string>

#include "csv_row.h"

namespace phymul::bench {

/// What a value is known to be: the two ends of a measurement, or a closed form, whose ends are equal. NaN: unknown.
struct Known {
  double low = 0.0, high = 0.0;
  double mean() const { return (low + high) / 2; }
};

/// Writes rows (truth.csv) and curves (truth_curves.csv). Values have the units of the measurements' file.
class TruthTable {
 public:
  /// `measured`: CSV with the columns case,quantity,low,high. Throws Error.
  TruthTable(const std::string& measured, const std::string& folder);

  const Known& measured(const std::string& it, const std::string& quantity) const;  ///< throws Error if unknown
  /// `mesh` names body, step and material constants as far as they differ between the rows of a quantity.
  void row(const std::string& it, const std::string& quantity, const std::string& mesh, int particles, double ours,
           const Known& known);
  void row(const std::string& it, const std::string& quantity, const std::string& mesh, int particles, double ours) {
    row(it, quantity, mesh, particles, ours, measured(it, quantity));
  }
  void curve(const std::string& it, const std::string& name, double x, double y);
  /// Ours over the mean of what is known, less 1; by "case; quantity; mesh".
  const std::map<std::string, double>& errors() const { return errors_; }

 private:
  std::map<std::string, Known> known_;
  std::map<std::string, double> errors_;
  CsvFile rows_, curves_;
};

/// Bodies, loads and rest shapes that several cases use.
/// 100 x 30 x 30 mm of Dragon Skin 10 under gravity, its side x0 held; `across` a multiple of 3, cells are cubes.
Simulation silicone_beam(int across, const Material& material, const std::string& backend = "reference");
/// Rest shapes of long bodies need positions in double precision; "cpu" rounds them.
Simulation simulation(Model model, const Material& material, const std::string& backend = "reference");
/// u along the axes `driven`, exactly 0 along `held`; the other axes stay free.
void impose(Scene& scene, std::vector<Index> particles, const Vec3& u, const std::string& driven,
            const std::string& held = "");
Load push(LoadType type, const Vec3& each, std::vector<Index> particles);
/// Takes the simulation to rest. Throws Error with the case's name if that fails.
VecList rest(Simulation& sim, const std::string& name, double tolerance = 1e-7);
VecList displacement(const Simulation& sim);              ///< [N] m, of the present state
Vec3 at_point(const Simulation& sim, const Vec3& point);  ///< displacement, m, up to two cells outside the body
std::string text(const char* format, double a, double b = 0.0, double c = 0.0);

inline const Known not_known{NAN, NAN};

using TruthCase = void (*)(TruthTable& table, bool quick);
const std::map<std::string, TruthCase>& static_cases();
const std::map<std::string, TruthCase>& solid_cases();
const std::map<std::string, TruthCase>& motion_cases();

}  // namespace phymul::bench

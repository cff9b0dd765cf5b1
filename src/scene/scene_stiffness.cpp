// SPDX-License-Identifier: MIT
//
// The stiffness of materials, changed while a scene runs.
#include <phymul/error.h>
#include <phymul/scene.h>

#include <algorithm>
#include <utility>

#include "base/decimal.h"
#include "model/group.h"

namespace phymul {
namespace {

/// Far more than any tissue's, and far from what single precision cannot hold.
constexpr double most = 1e6;

void require_factor(const Model& model, double factor) {
  if (model.materials.empty()) {
    throw Error("scale_stiffness: expected a model with a material, got one without; use set_material first");
  }
  if (factor >= 1.0 / most && factor <= most) return;
  throw Error("scale_stiffness: expected a factor from 1e-6 to 1e6, got " + to_decimal(factor));
}

/// [materials] 1: some cell of the group has it. Throws Error if others have it too, or if there is no such cell.
std::vector<char> materials_of_group(const Model& model, std::string_view group) {
  const std::vector<char> chosen = cells_of_group(model, group);
  const std::string label = "scale_stiffness: group \"" + std::string(group) + "\" ";
  std::vector<char> of_group(model.materials.size(), 0);
  std::vector<Index> others(of_group.size(), 0);
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Index material = model.cells[row].material;
    if (material < 0) continue;
    if (chosen[row] != 0) {
      of_group[material] = 1;
    } else {
      ++others[material];
    }
  }
  for (std::size_t m = 0; m < others.size(); ++m) {
    if (of_group[m] == 0 || others[m] == 0) continue;
    throw Error(label + "shares its material (Young's modulus " + to_decimal(model.materials[m].young) + " Pa) with " +
                std::to_string(others[m]) +
                " cell(s) outside of it; give it one of its own with set_material, in which a density that differs "
                "in the last digits is enough");
  }
  if (std::ranges::find(of_group, char{1}) == of_group.end()) throw Error(label + "holds no cell with a material");
  return of_group;
}

}  // namespace

Scene& Scene::scale_stiffness(double factor) {
  require_factor(*model_, factor);
  set_factors(std::vector<double>(model_->materials.size(), factor));
  return *this;
}

Scene& Scene::scale_stiffness(std::string_view group, double factor) {
  require_factor(*model_, factor);
  const std::vector<char> chosen = materials_of_group(*model_, group);
  std::vector<double> factors = stiffness_factors_;
  factors.resize(chosen.size(), 1.0);
  for (std::size_t m = 0; m < chosen.size(); ++m) {
    if (chosen[m] != 0) factors[m] = factor;
  }
  set_factors(std::move(factors));
  return *this;
}

Scene& Scene::scale_stiffness(std::span<const double> factors) {
  for (const double factor : factors) require_factor(*model_, factor);
  if (!factors.empty() && factors.size() != model_->materials.size()) {
    throw Error("scale_stiffness: expected a factor for each of " + std::to_string(model_->materials.size()) +
                " material(s), or none, got " + std::to_string(factors.size()));
  }
  set_factors({factors.begin(), factors.end()});
  return *this;
}

/// Where there were none, or are none any more, solvers prepare anew.
void Scene::set_factors(std::vector<double> factors) {
  ++(stiffness_factors_.empty() || factors.empty() ? version_ : values_version_);
  stiffness_factors_ = std::move(factors);
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// The stiffness of materials, changed while a scene runs.
#include <phymul/error.h>
#include <phymul/scene.h>

#include <algorithm>
#include <utility>

#include "base/decimal.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

/// Far more than any tissue's, and far from what single precision cannot hold.
constexpr double most = 1e6;

void require_factor(const Model& model, double factor) {
  if (model.materials.empty()) {
    throw Error("scale_stiffness: expected a model with a material, got one without; use set_material first");
  }
  const bool has_thin = std::ranges::any_of(model.materials, [](const Material& of) { return of.thickness > 0.0; });
  if (has_thin && std::ranges::any_of(model.cells, [&](const Cell& cell) { return is_of_wall(model, cell); })) {
    throw Error(ErrorCode::not_supported,
                "scale_stiffness: expected a body without walls (materials with a thickness)");
  }
  if (factor >= 1.0 / most && factor <= most) return;
  throw Error("scale_stiffness: expected a factor from 1e-6 to 1e6, got " + to_decimal(factor));
}

std::size_t row_of(const Model& model, const Material& material, const std::string& who) {
  const auto known = std::ranges::find(model.materials, material);
  if (known != model.materials.end()) return static_cast<std::size_t>(known - model.materials.begin());
  std::string moduli;
  for (const Material& own : model.materials) moduli += (moduli.empty() ? "" : ", ") + to_decimal(own.young);
  throw Error(who + ": expected a material of the model, whose Young's moduli are " + moduli +
              " Pa; got another one, of " + to_decimal(material.young) + " Pa");
}

void require_tearing(const Model& model, const Tearing& law) {
  if (model.dimension == 2 || model.materials.empty()) {
    throw Error("tear: expected a body in three dimensions with a material; use set_material first");
  }
  bool tetrahedra = false;
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Cell& cell = model.cells[row];
    const bool can_tear = !is_of_wall(model, cell) && (!is_volume(cell.type) || cell.type == CellType::tetrahedron);
    tetrahedra = tetrahedra || (cell.type == CellType::tetrahedron && cell.material >= 0);
    if (can_tear || cell.material < 0) continue;
    throw Error(ErrorCode::not_supported,
                "tear: expected a body of tetrahedra without walls; " + cell_label(model, row) + " cannot tear");
  }
  if (!tetrahedra) throw Error(ErrorCode::not_supported, "tear: expected a body of tetrahedra, got one without");
  for (const auto& [value, name] : {std::pair(law.toughness, "a toughness, J/m^2,"), {law.radius, "a radius, m,"}}) {
    if (value >= 0.0 && std::isfinite(value)) continue;
    throw Error(std::string("tear: expected ") + name + " of at least 0, got " + to_decimal(value));
  }
}

}  // namespace

Scene& Scene::scale_stiffness(double factor) {
  require_factor(*model_, factor);
  set_factors(std::vector<double>(model_->materials.size(), factor));
  return *this;
}

Scene& Scene::scale_stiffness(const Material& material, double factor) {
  require_factor(*model_, factor);
  std::vector<double> factors = stiffness_factors_;
  factors.resize(model_->materials.size(), 1.0);
  factors[row_of(*model_, material, "scale_stiffness")] = factor;
  set_factors(std::move(factors));
  return *this;
}

Scene& Scene::tear(const Tearing& law) {
  require_tearing(*model_, law);
  tearing_.assign(law.toughness > 0.0 ? model_->materials.size() : 0, law);
  ++version_;
  return *this;
}

Scene& Scene::tear(const Material& material, const Tearing& law) {
  require_tearing(*model_, law);
  const std::size_t row = row_of(*model_, material, "tear");
  tearing_.resize(model_->materials.size());
  tearing_[row] = law;
  if (std::ranges::all_of(tearing_, [](const Tearing& own) { return own.toughness == 0.0; })) tearing_.clear();
  ++version_;
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

Scene& Scene::scale_stiffness(std::initializer_list<double> factors) {
  return scale_stiffness(std::span(factors.begin(), factors.size()));
}

/// Factors that are all 1 are none. Where there were none, or are none any more, solvers prepare anew.
void Scene::set_factors(std::vector<double> factors) {
  if (std::ranges::all_of(factors, [](double factor) { return factor == 1.0; })) factors.clear();
  ++(stiffness_factors_.empty() || factors.empty() ? version_ : values_version_);
  stiffness_factors_ = std::move(factors);
}

}  // namespace phymul

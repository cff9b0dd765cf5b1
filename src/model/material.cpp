// SPDX-License-Identifier: MIT
#include "material.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

#include "base/decimal.h"
#include "cell_geometry.h"
#include "group.h"

namespace phymul {
namespace {

/// Of a body of points that brings none: of jittered lattices those within some 1.8 spacings.
constexpr Index usual_neighbours = 20;

/// Sums density * volume / vertices over the cells that have a material. A particle in none of them keeps its mass.
/// An Error leaves the model as it was.
void sum_masses(Model& model) {
  std::vector<double> mass(model.rest.size(), 0.0);
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Cell& cell = model.cells[row];
    if (cell.material < 0 || cell.share == 0.0 || !is_tissue(model, cell)) continue;
    const double measure = tissue_volume(model, cell);
    if (!(measure > 0.0)) {
      throw Error(ErrorCode::invalid_model,
                  cell_label(model, row) + ": expected a positive volume to give it a mass, got " +
                      to_decimal(measure) + "; run check_mesh first, and mend or remove the cells it names");
    }
    const double share = model.materials[cell.material].density * measure / static_cast<double>(cell.particles.size());
    for (const Index i : cell.particles) mass[i] += share;
  }
  const MassBalance balance = balance_masses(model, mass);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    if (mass[i] > 0.0) {
      model.mass[i] = mass[i];
    } else if (model.mass[i] > 0.0) {
      ++kept;
    }
  }
  // Only the last call knows: materials are given one region after another.
  constexpr std::string_view without = " particle(s) are in no cell with a material and keep their mass";
  constexpr std::string_view longer = " times as long (Model::most_mass_moved)";
  std::erase_if(model.notes,
                [&](const std::string& note) { return note.ends_with(without) || note.ends_with(longer); });
  if (balance.moved > 0.0) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "set_material: %.1f %% of the mass moved to light particles beside it; the stable step is about %.1f",
                  100.0 * balance.moved, balance.gain);
    model.notes.push_back(text + std::string(longer));
  }
  if (kept > 0) model.notes.push_back("set_material: " + std::to_string(kept) + std::string(without));
}

/// Makes two triangles of each quad whose row is chosen: along its shorter diagonal, unless the two would lie on each
/// other there. The second one comes after all cells, and is in the components that the quad is in.
void divide_quads(Model& model, std::vector<char>& is_chosen) {
  std::vector<Index> second(model.cells.size(), -1);  // rows of the new cells
  Index divided = 0;
  for (std::size_t row = 0; row < second.size(); ++row) {
    if (is_chosen[row] == 0 || model.cells[row].type != CellType::quad) continue;
    const std::vector<Index> corner = model.cells[row].particles;
    const auto at = [&](std::size_t k) -> const Vec3& { return model.rest[corner[k % 4]]; };
    const auto are_unfolded = [&](std::size_t k) {
      const Vec3 diagonal = at(k + 2) - at(k);
      return (at(k + 1) - at(k)).cross(diagonal).dot(diagonal.cross(at(k + 3) - at(k))) > 0.0;
    };
    std::size_t k = (at(2) - at(0)).norm() <= (at(3) - at(1)).norm() ? 0 : 1;
    if (!are_unfolded(k) && are_unfolded(1 - k)) k = 1 - k;
    const std::vector<Index> one{corner[k], corner[k + 1], corner[(k + 2) % 4]};
    Cell other = model.cells[row];
    other.name.clear();
    other.particles = {corner[k], corner[(k + 2) % 4], corner[(k + 3) % 4]};
    for (const std::vector<Index>& half : {one, other.particles}) {
      if (area_vector(half, model.rest).norm() > 0.0) continue;
      throw Error(ErrorCode::invalid_model, cell_label(model, row) +
                                                ": expected a quad with an area on both sides of a diagonal; make it a "
                                                "triangle");
    }
    other.type = model.cells[row].type = CellType::triangle;
    model.cells[row].particles = one;
    second[row] = static_cast<Index>(model.cells.size());
    model.cells.push_back(std::move(other));
    is_chosen.push_back(1);
    ++divided;
  }
  for (Component& component : model.components) {
    for (std::vector<Index>* cells : {&component.cells, &component.cell_refs}) {
      for (std::size_t k = 0, count = cells->size(); k < count; ++k) {
        if (const Index row = second[(*cells)[k]]; row >= 0) cells->push_back(row);
      }
    }
  }
  model.notes.push_back("set_material: " + std::to_string(divided) + " quad(s) of a wall became two triangles each");
}

void assign_to_rows(Model& model, const Material& material, const std::vector<char>& is_chosen) {
  std::vector<Index> rows;  // of each cell, before and after: a copy of a large model would take long
  rows.reserve(model.cells.size());
  std::vector<Material> materials = model.materials;
  const auto known = std::find(materials.begin(), materials.end(), material);
  const Index row = static_cast<Index>(known - materials.begin());
  if (known == materials.end()) materials.push_back(material);
  for (std::size_t c = 0; c < is_chosen.size(); ++c) {
    rows.push_back(is_chosen[c] != 0 ? row : model.cells[c].material);
  }
  const auto exchange = [&] {
    for (std::size_t c = 0; c < rows.size(); ++c) std::swap(model.cells[c].material, rows[c]);
    std::swap(model.materials, materials);
  };
  exchange();
  try {
    sum_masses(model);
  } catch (...) {
    exchange();
    throw;
  }
  drop_unused_materials(model);
}

/// Whether cells of a type can have a material: walls' those with an area, others those that fill space.
bool takes(const Material& material, int dimension, CellType type) {
  return is_solid(material.thickness > 0.0 ? 2 : dimension, type);
}

/// Gives the material to the cells whose rows `chosen` accepts; an Error leaves the model as it was.
template <class Predicate>
void assign(Model& model, const Material& material, const std::string& nothing_chosen, Predicate chosen) {
  validate(model);
  if (material.thickness > 0.0 && model.dimension == 2) {
    throw Error(
        "set_material: expected a model in 3 dimensions for a material with a thickness (Law::walls), got one in "
        "2; set Model::dimension to 3 (a mesh in the plane z = 0 is read as a body in 2), or the thickness to 0");
  }
  if (!(model.most_mass_moved >= 0.0 && model.most_mass_moved < 1.0)) {
    throw Error("set_material: expected Model::most_mass_moved of at least 0 and below 1, got " +
                to_decimal(model.most_mass_moved));
  }
  std::vector<char> is_chosen(model.cells.size(), 0);
  bool any = false, any_quad = false;
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    const CellType type = model.cells[c].type;
    if (!takes(material, model.dimension, type) || !chosen(c)) continue;
    is_chosen[c] = 1;
    any = true;
    any_quad = any_quad || type == CellType::quad;
  }
  if (!any) throw Error(nothing_chosen);
  if (material.thickness > 0.0 && any_quad) {
    Model divided = model;
    divide_quads(divided, is_chosen);
    assign_to_rows(divided, material, is_chosen);
    model = std::move(divided);
  } else {
    assign_to_rows(model, material, is_chosen);
  }
}

/// Particles without cells: the same for all of them. Masses from their share of space, which takes neighbours.
void set_material_of_points(Model& model, const Material& material) {
  Model changed = model;
  if (changed.neighbours.entry.empty()) changed.neighbours.offset.assign(changed.rest.size() + 1, 0);
  validate(changed);
  if (material.fibre_ratio > 1.0) {
    throw Error(ErrorCode::not_supported, "set_material: a body of points has no fibres; give it cells (make_body)");
  }
  if (changed.neighbours.entry.empty() && changed.particle_count() > 1) {
    changed.neighbours = nearest_neighbours(changed.rest, std::min(usual_neighbours, changed.particle_count() - 1));
  }
  const std::vector<PointCell> cells = point_cells(changed, point_neighbours(changed));
  const double least = 1e-9 * std::pow(mean_spacing(changed), model.dimension);  // rounding of none
  double volume = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!(cells[i].volume > least)) {
      throw Error(ErrorCode::invalid_model,
                  "set_material: expected each particle to have neighbours around it that are not in one " +
                      std::string(model.dimension == 3 ? "plane" : "line") + ", but those of particle " +
                      std::to_string(model.file_index(static_cast<Index>(i))) +
                      " are; give it more, or set Model::mass and Model::stiffness instead");
    }
    changed.mass[i] = material.density * cells[i].volume;
    volume += cells[i].volume;
  }
  const std::string points = "set_material: no cell fills space; the particles are taken for a body of points, of ";
  std::erase_if(changed.notes, [&](const std::string& note) { return note.starts_with(points); });
  changed.notes.push_back(points + to_decimal(volume) + (model.dimension == 3 ? " m^3" : " m^2"));
  changed.materials = {material};
  model = std::move(changed);
}

std::string cells_for(const Model& model, const Material& material) {
  if (material.thickness > 0.0) return "triangles or quads";
  return model.dimension == 3 ? "volume cells (tetrahedra, wedges, pyramids or hexahedra)" : "triangles or quads";
}

/// dpsi/dX + dpsi/dY / s over mu/2; X, Y, k, b, c, d: topology.h.
double slope(const Stiffening& of, double X, double Y, double s) {
  const double within = 1.0 / (1.0 + of.second_fades * X);
  const double growth = 1.0 + of.exponential * std::expm1(std::min(of.exponent * X, most_exponent));
  return growth + of.second * within * (1.0 / s - 1.0 - of.second_fades * within * (Y - X));
}

/// Nominal stresses of an incompressible body, over mu.
double stretched(const Stiffening& of, double s) {
  return (s - 1.0 / (s * s)) * slope(of, s * s + 2.0 / s - 3.0, 2.0 * s + 1.0 / (s * s) - 3.0, s);
}

double sheared(const Stiffening& of, double amount) {
  return amount * slope(of, amount * amount, amount * amount, 1.0);
}

constexpr int strains = 100;  // at which the stress is compared with that at the one before

}  // namespace

void drop_unused_materials(Model& model) {
  std::vector<Index> new_row(model.materials.size(), -1);
  std::vector<Material> used;
  for (Cell& cell : model.cells) {
    if (cell.material < 0) continue;
    Index& row = new_row[cell.material];
    if (row < 0) {
      row = static_cast<Index>(used.size());
      used.push_back(model.materials[cell.material]);
    }
    cell.material = row;
  }
  model.materials = std::move(used);
}

void require_dissipation_in_range(const Material& material) {
  const auto require = [](const char* name, double value, const char* unit, bool holds, const char* expected) {
    if (holds && std::isfinite(value)) return;
    throw Error(std::string("material: expected ") + expected + " for " + name + ", got " + to_decimal(value) + unit);
  };
  require("retardation_time", material.retardation_time, " s", material.retardation_time >= 0.0, "0 s or more");
  require("relaxation_strength", material.relaxation_strength, "", material.relaxation_strength >= 0.0, "0 or more");
  const bool relaxes = material.relaxation_strength > 0.0;
  require("relaxation_time", material.relaxation_time, " s",
          relaxes ? material.relaxation_time > 0.0 : material.relaxation_time >= 0.0,
          relaxes ? "more than 0 s, because relaxation_strength is above 0," : "0 s or more");
}

void require_in_range(const Material& material) {
  require_dissipation_in_range(material);
  if (!(material.young > 0.0) || !std::isfinite(material.young)) {
    throw Error("material: expected a positive, finite Young's modulus in Pa, got " + to_decimal(material.young));
  }
  if (!(material.poisson > -1.0 && material.poisson < 0.5)) {
    throw Error("material: expected Poisson's ratio above -1 and below 1/2, got " + to_decimal(material.poisson) +
                "; take 0.49 for a nearly incompressible tissue");
  }
  if (!(material.density > 0.0) || !std::isfinite(material.density)) {
    throw Error("material: expected a positive, finite density in kg/m^3, got " + to_decimal(material.density));
  }
  if (!(material.fibre_ratio >= 1.0) || !std::isfinite(material.fibre_ratio)) {
    throw Error("material: expected a finite fibre_ratio of 1 (no fibres) or more, got " +
                to_decimal(material.fibre_ratio));
  }
  if (!(material.thickness >= 0.0) || !std::isfinite(material.thickness)) {
    throw Error("material: expected a finite thickness of 0 m (not a wall) or more, got " +
                to_decimal(material.thickness));
  }
  const bool plain = material.stiffening == Stiffening{};
  const bool dissipates = material.retardation_time > 0.0 || material.relaxation_strength > 0.0;
  if (material.thickness > 0.0 && (!plain || dissipates || material.fibre_ratio > 1.0)) {
    throw Error(
        "material: expected a wall (thickness above 0) to have neither fibres nor stiffening nor dissipation; "
        "leave these at their defaults");
  }
  if (plain) return;
  if (const std::string fault = fault_of(material.stiffening); !fault.empty()) throw Error("material: " + fault);
}

void set_material(Model& model, const Material& material) {
  require_in_range(material);
  if (material.thickness == 0.0 && is_body_of_points(model)) return set_material_of_points(model, material);
  assign(model, material,
         "set_material: expected " + cells_for(model, material) + " for this material, but there are none",
         [](std::size_t) { return true; });
}

void set_material(Model& model, const Material& material, std::string_view group_name) {
  require_in_range(material);
  validate(model);
  const std::vector<char> chosen =
      cells_of_group(model, group_name, [&](CellType type) { return takes(material, model.dimension, type); });
  assign(model, material,
         "set_material: expected group \"" + std::string(group_name) + "\" to hold all particles of some " +
             cells_for(model, material) + ", but it holds none whole",
         [&](std::size_t cell) { return chosen[cell] != 0; });
}

double set_material(Model& model, const Material& material, const Contains& contains) {
  require_in_range(material);
  const std::size_t cells = model.cells.size();
  std::vector<std::size_t> rows;
  assign(
      model, material,
      "set_material: expected the centres of some " + cells_for(model, material) + " in the region, but there are none",
      [&](std::size_t row) {
        if (!contains(cell_centre(model.cells[row], model.rest))) return false;
        rows.push_back(row);
        return true;
      });
  for (std::size_t row = cells; row < model.cells.size(); ++row) rows.push_back(row);  // of quads
  double volume = 0.0;
  for (const std::size_t row : rows) volume += tissue_volume(model, model.cells[row]);
  return volume;
}

std::string fault_of(const Stiffening& of) {
  const auto named = [](const char* name, double value) { return std::string(name) + ' ' + to_decimal(value); };
  const std::string all = named("exponential", of.exponential) + ", " + named("exponent", of.exponent) + ", " +
                          named("second", of.second) + ", " + named("second_fades", of.second_fades);
  const double least = std::min({of.exponential, of.exponent, of.second_fades});
  if (!(least >= 0.0) || !std::isfinite(of.exponential + of.exponent + of.second_fades + of.second)) {
    return "expected a stiffening of finite numbers, of which only second may be below 0, got " + all;
  }
  const auto falls = [&](const std::string& where) {
    return "expected a stiffening by which the stress rises with every stretch from 0.6 to 1.7 and every shear to 1, "
           "but "
           "by " +
           all + " it falls at " + where +
           "; bring second nearer to 0, or make second_fades, or exponential and exponent, larger";
  };
  double tension = 0.0, pressure = 0.0, shear = 0.0;
  for (int n = 1; n <= strains; ++n) {
    const double share = static_cast<double>(n) / strains, up = 1.0 + 0.7 * share, down = 1.0 - 0.4 * share;
    const double pulled = stretched(of, up), pressed = stretched(of, down), turned = sheared(of, share);
    if (!(pulled > tension)) return falls("a stretch of " + to_decimal(up));
    if (!(pressed < pressure)) return falls("a stretch of " + to_decimal(down));
    if (!(turned > shear)) return falls("a shear of " + to_decimal(share));
    tension = pulled, pressure = pressed, shear = turned;
  }
  return {};
}

}  // namespace phymul

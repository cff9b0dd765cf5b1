// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/model.h>

#include <array>
#include <cmath>
#include <span>

#include "base/decimal.h"
#include "cell_cutter.h"
#include "cell_geometry.h"
#include "file_extras.h"
#include "group.h"
#include "material.h"

namespace phymul {
namespace {

std::string quoted(const std::string& name) {
  return name.empty() ? "" : " \"" + name + '"';
}

std::string shown(const Vec3& v) {
  return '(' + to_decimal(v.x()) + ", " + to_decimal(v.y()) + ", " + to_decimal(v.z()) + ')';
}

/// "particle 7 (file index 12)"
std::string particle_label(const Model& model, std::size_t i) {
  std::string label = "particle " + std::to_string(i);
  const std::vector<Index>& number = extras_of(model).particle_index;
  if (i < number.size()) label += " (file index " + std::to_string(number[i]) + ')';
  return label;
}

void require_rows(const Model& model, const char* what, std::size_t size) {
  if (size == model.rest.size()) return;
  throw Error(ErrorCode::invalid_model, std::string("model: expected ") + std::to_string(model.rest.size()) +
                                            " rows in " + what + ", one per particle, got " + std::to_string(size));
}

/// [N] 1: all cells around it are removed, and some are, or it is a spare particle.
std::vector<char> without_tissue(const Model& model) {
  std::vector<char> removed(model.rest.size(), 0), solid(model.rest.size(), 0);
  for (const Cell& cell : model.cells) {
    const bool stands = is_solid(model.dimension, cell) || is_wall(model, cell);
    std::vector<char>* const found = stands ? &solid : cell.share == 0.0 ? &removed : nullptr;
    if (found == nullptr) continue;
    for (const Index i : cell.particles) {
      if (i >= 0 && i < model.particle_count()) (*found)[i] = 1;
    }
  }
  for (std::size_t i = 0; i < removed.size(); ++i) removed[i] = static_cast<char>(removed[i] != 0 && solid[i] == 0);
  for (const Index i : spare_particles_of(model)) removed[i] = 1;
  return removed;
}

constexpr const char* spare_last = "; spare particles (with_spare_particles) come after all others, without neighbours";

void validate_particles(const Model& model) {
  std::vector<char> may_be_massless;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    if (!model.rest[i].allFinite()) {
      throw Error(ErrorCode::invalid_model,
                  particle_label(model, i) + ": expected finite coordinates, got " + shown(model.rest[i]));
    }
    if (model.dimension == 2 && model.rest[i].z() != 0.0) {
      throw Error(ErrorCode::invalid_model, particle_label(model, i) +
                                                ": expected z = 0 in a two-dimensional model, got " +
                                                to_decimal(model.rest[i].z()) + " m");
    }
    const bool has_mass = model.mass[i] > 0.0 && std::isfinite(model.mass[i]);
    if (!has_mass && may_be_massless.empty()) may_be_massless = without_tissue(model);
    if (!has_mass && !(model.mass[i] == 0.0 && may_be_massless[i] != 0)) {
      throw Error(ErrorCode::invalid_model, particle_label(model, i) + ": expected a positive, finite mass, got " +
                                                to_decimal(model.mass[i]) + " kg" +
                                                (model.mass[i] == 0.0 ? spare_last : ""));
    }
    if (!(model.stiffness[i] >= 0.0) || !std::isfinite(model.stiffness[i])) {
      throw Error(ErrorCode::invalid_model, particle_label(model, i) +
                                                ": expected a finite stiffness of 0 or more, got " +
                                                to_decimal(model.stiffness[i]) + " N/m");
    }
  }
}

void validate_neighbours(const Model& model) {
  const RaggedList& list = model.neighbours;
  if (list.offset.empty() || list.offset.front() != 0) {
    throw Error(ErrorCode::invalid_model,
                "model: expected the neighbour offsets to start with 0; build the list with RaggedList::push_row");
  }
  require_rows(model, "neighbours", list.offset.size() - 1);
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    const Index from = list.offset[i], to = list.offset[i + 1];
    if (to < from || static_cast<std::size_t>(to) > list.entry.size()) {
      throw Error(ErrorCode::invalid_model, particle_label(model, i) +
                                                ": expected neighbour offsets that never decrease and end at " +
                                                std::to_string(list.entry.size()) + ", got a row from " +
                                                std::to_string(from) + " to " + std::to_string(to));
    }
    require_indices(
        std::span(list.entry).subspan(from, to - from), model.rest.size(), "neighbours",
        [&] { return particle_label(model, i) + ": "; }, ErrorCode::invalid_model);
  }
  if (static_cast<std::size_t>(list.offset.back()) != list.entry.size()) {
    throw Error(ErrorCode::invalid_model, "model: expected the last neighbour offset to be " +
                                              std::to_string(list.entry.size()) + ", got " +
                                              std::to_string(list.offset.back()));
  }
}

void validate_cells(const Model& model) {
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Cell& cell = model.cells[row];
    const int size = cell_size(cell.type);
    if (size > 0 && cell.particles.size() != static_cast<std::size_t>(size)) {
      throw Error(ErrorCode::invalid_model, cell_label(model, row) + ": expected " + std::to_string(size) +
                                                " particles, got " + std::to_string(cell.particles.size()));
    }
    const auto label = [&] { return cell_label(model, row) + ": "; };
    require_indices(cell.particles, model.rest.size(), "particles", label, ErrorCode::invalid_model);
    if (!(cell.share >= 0.0 && cell.share <= 1.0)) {
      throw Error(ErrorCode::invalid_model,
                  label() + "expected a share of 0 (removed) to 1, got " + to_decimal(cell.share));
    }
    const bool can_be_cut = cell.type == CellType::tetrahedron || cell.type == CellType::triangle;
    const bool finite = std::ranges::all_of(cell.cuts, [](const CellCut& cut) {
      return std::ranges::all_of(cut, [](double value) { return std::isfinite(value); });
    });
    if (!cell.cuts.empty() && !(can_be_cut && finite)) {
      throw Error(ErrorCode::invalid_model,
                  label() + "expected cuts of tetrahedra and triangles alone, by finite numbers");
    }
    if (cell.material == -1) continue;
    require_indices(std::array{cell.material}, model.materials.size(), "a material", label, ErrorCode::invalid_model);
  }
}

void validate_components(const Model& model) {
  for (std::size_t row = 0; row < model.components.size(); ++row) {
    const Component& component = model.components[row];
    const std::string where = "component " + std::to_string(row) + quoted(component.name);
    if (component.parent != -1 && (component.parent < 0 || static_cast<std::size_t>(component.parent) >= row)) {
      throw Error(ErrorCode::invalid_model,
                  where + ": expected a parent that stands before it, or -1, got " + std::to_string(component.parent));
    }
    const auto require = [&](const std::vector<Index>& indices, std::size_t count, const char* what) {
      require_indices(
          indices, count, what, [&] { return where + ": "; }, ErrorCode::invalid_model);
    };
    require(component.cells, model.cells.size(), "cells");
    require(component.cell_refs, model.cells.size(), "references to cells");
    require(component.particles, model.rest.size(), "particles");
  }
}

}  // namespace

void validate(const Model& model) {
  if (model.dimension != 2 && model.dimension != 3) {
    throw Error(ErrorCode::invalid_model, "model: expected dimension 2 or 3, got " + std::to_string(model.dimension));
  }
  if (model.rest.empty()) throw Error(ErrorCode::invalid_model, "model: expected at least one particle, got none");
  require_rows(model, "mass", model.mass.size());
  require_rows(model, "stiffness", model.stiffness.size());
  const FileExtras& extras = extras_of(model);
  for (const std::size_t rows : {extras.particle_index.size(), extras.particle_name.size(),
                                 extras.particle_fields.size(), extras.neighbourhood_index.size()}) {
    if (rows == 0 || rows == model.rest.size()) continue;
    throw Error(ErrorCode::invalid_model, "model: expected extras of " + std::to_string(model.rest.size()) +
                                              " particles, as the model has, got those of " + std::to_string(rows) +
                                              "; set Model::extras to null after removing or adding particles");
  }
  validate_particles(model);
  validate_neighbours(model);
  for (const Material& material : model.materials) require_in_range(material);
  validate_cells(model);
  validate_components(model);
}

}  // namespace phymul

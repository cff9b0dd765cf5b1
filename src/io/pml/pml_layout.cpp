// SPDX-License-Identifier: MIT
#include "pml_layout.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>

#include "base/decimal.h"
#include "base/index_table.h"
#include "model/file_extras.h"

namespace phymul {
namespace {

// Below what the reader takes, with room for the elements around.
constexpr std::size_t deepest = 200;

bool is_natural(const std::vector<Index>& order) {
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i] != static_cast<Index>(i)) return false;
  }
  return true;
}

std::string label(const Model& model, Index component) {
  return "component " + std::to_string(component) + " \"" + model.components[component].name + '"';
}

}  // namespace

PmlLayout::PmlLayout(const Model& model) : model_(model) {
  require_atom_numbers();
  sort_components();
  sort_cells();
  for (const Index row : roots[1]) walk(row, true);
  cell_order_.insert(cell_order_.end(), loose.begin(), loose.end());
  for (const Index row : roots[0]) walk(row, false);
  components_in_order = is_natural(component_order_);
  cells_in_order = is_natural(cell_order_);
  number_cells();
}

void PmlLayout::require_atom_numbers() const {
  const std::vector<Index>& numbers = extras_of(model_).particle_index;
  for (const Index number : numbers) {
    if (number < 0) throw Error("expected file indices of 0 or more, got " + std::to_string(number));
  }
  const IndexTable table(numbers);
  if (table.repeats().empty()) return;
  const auto [again, first] = table.repeats().front();
  throw Error("particle " + std::to_string(again) + ": expected a file index of its own, got " +
              std::to_string(numbers[again]) + ", which particle " + std::to_string(first) + " has");
}

void PmlLayout::sort_components() {
  children.resize(model_.components.size());
  for (std::size_t i = 0; i < model_.components.size(); ++i) {
    const Component& component = model_.components[i];
    const auto row = static_cast<Index>(i);
    (component.parent < 0 ? roots[component.exclusive] : children[component.parent]).push_back(row);
    if (!component.structural || component.name != "Neighborhoods") continue;
    if (neighbourhoods >= 0) throw Error(label(model_, row) + ": expected one component of this name, got two");
    neighbourhoods = row;
  }
}

void PmlLayout::sort_cells() {
  own_cells.resize(model_.components.size());
  references.resize(model_.components.size());
  std::vector<char> owned(model_.cells.size(), 0);
  for (std::size_t row = 0; row < model_.components.size(); ++row) {
    const Component& component = model_.components[row];
    for (const Index cell : component.cells) {
      (owned[cell] ? references : own_cells)[row].push_back(cell);
      owned[cell] = 1;
    }
    references[row].insert(references[row].end(), component.cell_refs.begin(), component.cell_refs.end());
  }
  for (std::size_t cell = 0; cell < owned.size(); ++cell) {
    if (!owned[cell]) loose.push_back(static_cast<Index>(cell));
  }
}

void PmlLayout::walk(Index root, bool exclusive) {
  std::vector<std::pair<Index, std::size_t>> open{{root, 1}};
  while (!open.empty()) {
    const auto [row, depth] = open.back();
    open.pop_back();
    require_writable(row, exclusive);
    if (depth > deepest) {
      throw Error(label(model_, row) + ": expected components nested at most " + std::to_string(deepest) + " deep");
    }
    component_order_.push_back(row);
    cell_order_.insert(cell_order_.end(), own_cells[row].begin(), own_cells[row].end());
    for (auto child = children[row].rbegin(); child != children[row].rend(); ++child) {
      open.emplace_back(*child, depth + 1);
    }
  }
}

void PmlLayout::require_writable(Index row, bool exclusive) const {
  const Component& component = model_.components[row];
  if (component.exclusive != exclusive) {
    throw Error(label(model_, row) + ": expected the same `exclusive` as its parent's");
  }
  if (component.structural && !children[row].empty()) {
    throw Error(label(model_, row) + ": expected no components inside a structural component");
  }
  const bool empty = own_cells[row].empty() && references[row].empty() && component.particles.empty();
  if (!component.structural && !empty) {
    throw Error(label(model_, row) + ": expected cells and particles in structural components only");
  }
  if (row != neighbourhoods) return;
  for (const Index cell : own_cells[row]) {
    if (model_.cells[cell].name.starts_with("Atom #")) {
      throw Error(label(model_, row) + ": expected neighbourhoods in Model::neighbours, got a cell named \"" +
                  model_.cells[cell].name + '"');
    }
  }
}

/// Cells keep the index of their file. Without one, a cell gets a new one where something refers to it.
void PmlLayout::number_cells() {
  std::int64_t next = 0;
  for (const Index number : extras_of(model_).neighbourhood_index) next = std::max(next, std::int64_t{number} + 1);
  std::vector<Index> in_file_order;
  for (std::size_t row = 0; row < model_.cells.size(); ++row) {
    cell_number.push_back(model_.cell_file_index(static_cast<Index>(row)));
    next = std::max(next, std::int64_t{cell_number.back()} + 1);
  }
  for (const Index row : cell_order_) in_file_order.push_back(cell_number[row]);
  const IndexTable table(in_file_order);
  for (const std::vector<Index>& rows : references) {
    for (const Index row : rows) {
      Index& number = cell_number[row];
      if (number < 0) {
        if (next > std::numeric_limits<Index>::max()) throw Error("expected cell indices below 2^31 - 1");
        number = static_cast<Index>(next++);
      } else if (model_.cell_file_index(row) >= 0 && cell_order_[table.find(number)] != row) {
        throw Error("cell " + std::to_string(row) +
                    ": expected a file index of its own, since a component refers to it, got " +
                    std::to_string(number) + ", which another cell has");
      }
    }
  }
}

std::optional<PmlMarks> parse_pml_marks(std::string_view text) {
  PmlMarks marks;
  for (text = trim(text); !text.empty(); text = trim(text)) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(word.size());
    if (word == "unnumbered") {
      marks.unnumbered = true;
    } else if (word == "wrapper") {
      marks.wrapper = true;
    } else if (word == "loose") {
      marks.loose = true;
    } else if (word == "unlisted") {
      marks.unlisted = true;
    } else if (word == "unweighed") {
      marks.unweighed = true;
    } else if (word.starts_with("row=")) {
      const std::optional<std::int64_t> row = parse_integer(word.substr(4));
      if (!row || *row < 0 || *row > std::numeric_limits<Index>::max()) return std::nullopt;
      marks.row = static_cast<Index>(*row);
    } else if (word.starts_with("share=")) {
      marks.share = parse_decimal(word.substr(6));
      if (!marks.share || !(*marks.share >= 0.0 && *marks.share <= 1.0)) return std::nullopt;
    } else if (word.starts_with("cut=")) {
      std::vector<double>& cut = marks.cuts.emplace_back();
      std::string_view left = word.substr(4);
      while (true) {
        const std::size_t end = left.find(',');
        const std::optional<double> value = parse_decimal(left.substr(0, end));
        if (!value) return std::nullopt;
        cut.push_back(*value);
        if (end == std::string_view::npos) break;
        left.remove_prefix(end + 1);
      }
    } else {
      return std::nullopt;
    }
  }
  return marks;
}

}  // namespace phymul

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "model/body_type.h"
#include "model/material.h"
#include "pml_reader.h"

namespace phymul {
namespace {

constexpr std::array<const char*, 4> material_names = {"young", "poisson", "density", "thickness"};
constexpr std::size_t needed_names = 3;  // of them

CellType cell_type(const XmlSource& xml, pugi::xml_node node, std::string_view name) {
  std::string known;
  for (int type = 0; type <= static_cast<int>(CellType::poly_vertex); ++type) {
    const char* const candidate = cell_name(static_cast<CellType>(type));
    if (name == candidate) return static_cast<CellType>(type);
    known += (type == 0 ? "" : ", ") + std::string(candidate);
  }
  xml.fail(node, "expected a cell type (" + known + "), got " + XmlSource::cite(name));
}

/// Puts every item in its wanted row and returns the new row of each. Throws by `fail` unless the rows are a
/// permutation.
template <class Item, class Fail>
std::vector<Index> permute(std::vector<Item>& items, const std::vector<Index>& wanted, Fail fail) {
  std::vector<char> taken(items.size(), 0);
  for (const Index row : wanted) {
    if (row < 0 || static_cast<std::size_t>(row) >= items.size() || taken[row]) fail();
    taken[row] = 1;
  }
  std::vector<Item> ordered(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) ordered[wanted[i]] = std::move(items[i]);
  items = std::move(ordered);
  return wanted;
}

bool any_given(const std::vector<Index>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](Index row) { return row >= 0; });
}

}  // namespace

void PmlReader::read_section(pugi::xml_node section, bool exclusive) {
  for (const pugi::xml_node child : section.children()) read_component(child, -1, exclusive);
}

void PmlReader::read_component(pugi::xml_node node, Index parent, bool exclusive) {
  const std::string_view kind = node.name();
  if (kind != "multiComponent" && kind != "structuralComponent") {
    const bool understood = kind == "color" && parent >= 0;
    if (understood) {
      model_.components[parent].colour = colour(node);
    } else {
      xml_.skip(node);
    }
    return;
  }
  const PmlMarks own = marks(node);
  if (kind == "multiComponent") {
    const Index row = own.wrapper ? -1 : add_component(node, own, parent, exclusive, false);
    for (const pugi::xml_node child : node.children()) read_component(child, row, exclusive);
    return;
  }
  const bool neighbourhoods = node.attribute("name").value() == std::string_view("Neighborhoods");
  if (neighbourhoods) open_neighbourhoods(node);
  const bool no_row = own.loose || (own.unlisted && neighbourhoods);
  read_structures(node, no_row ? -1 : add_component(node, own, parent, exclusive, true), neighbourhoods);
}

Index PmlReader::add_component(pugi::xml_node node, const PmlMarks& own, Index parent, bool exclusive,
                               bool structural) {
  Component component{.name = node.attribute("name").value(),
                      .parent = parent,
                      .exclusive = exclusive,
                      .structural = structural,
                      .attributes = xml_.other_attributes(node, {"name", pml_mark_attribute})};
  model_.components.push_back(std::move(component));
  component_rows_.push_back(own.row.value_or(-1));
  component_nodes_.push_back(node);
  unweighed_.push_back(own.unweighed);
  return static_cast<Index>(model_.components.size()) - 1;
}

void PmlReader::read_structures(pugi::xml_node node, Index component, bool neighbourhoods) {
  // A component's material is that of its cells; without cells it stays an attribute like any other.
  Index material = -1;
  if (component >= 0 && node.child("cell") && !needs_density(model_.components[component])) {
    material = take_material(node, model_.components[component].attributes);
  }
  for (const pugi::xml_node child : node.children()) {
    const std::string_view kind = child.name();
    if (kind == "cell") {
      const bool is_neighbourhood =
          neighbourhoods &&
          std::string_view(child.child("cellProperties").attribute("name").value()).starts_with("Atom #");
      if (is_neighbourhood) {
        read_neighbourhood(child, read_cell_head(child));
      } else {
        if (neighbourhoods)
          xml_.note(child,
                    "expected cells named \"Atom #<index>\" in \"Neighborhoods\"; "
                    "this one is read as an ordinary cell");
        read_cell(child, component, material);
      }
    } else if (kind == "atomRef" && component >= 0) {
      model_.components[component].particles.push_back(atom_row(child));
    } else if (kind == "cellRef" && component >= 0) {
      cell_references_.push_back({child, component, xml_.index(child, "index")});
    } else if (kind == "color" && component >= 0) {
      model_.components[component].colour = colour(child);
    } else if (kind != "nrOfStructures") {
      xml_.skip(child);
    }
  }
}

PmlReader::CellHead PmlReader::read_cell_head(pugi::xml_node cell) {
  CellHead head;
  head.node = cell.child("cellProperties");
  if (!head.node) xml_.fail(cell, "expected <cellProperties> in <cell>, got none");
  head.type = cell_type(xml_, head.node, xml_.text(head.node, "type"));
  head.marks = marks(head.node);
  for (const pugi::xml_attribute attribute : head.node.attributes()) {
    const std::string_view key = attribute.name();
    const std::string_view value = attribute.value();
    if (key == "index") head.index = xml_.index(head.node, "index", value);
    if (key == "name") head.name = value;
    if (key == "mass") head.mass = value;
    if (key == "stiffness") head.stiffness = value;
  }
  head.others = xml_.other_attributes(head.node, {"index", "name", "type", pml_mark_attribute});
  return head;
}

void PmlReader::read_cell(pugi::xml_node node, Index component, Index material) {
  CellHead head = read_cell_head(node);
  Cell cell;
  cell.type = head.type;
  cell.name = head.name;
  cell.attributes = std::move(head.others);
  cell.material = take_material(head.node, cell.attributes);
  if (cell.material < 0) cell.material = material;
  for (const pugi::xml_node child : node.children()) {
    if (child.name() == std::string_view("color")) cell.colour = colour(child);
  }
  read_cell_parts(node, cell.particles);
  const int size = cell_size(cell.type);
  if (size > 0 && cell.particles.size() != static_cast<std::size_t>(size)) {
    xml_.fail(head.node, std::string("expected ") + std::to_string(size) + " <atomRef> in a cell of type " +
                             cell_name(cell.type) + ", got " + std::to_string(cell.particles.size()));
  }
  cell.share = head.marks.share.value_or(1.0);
  for (const std::vector<double>& values : head.marks.cuts) {
    const bool can_be_cut = cell.type == CellType::tetrahedron || cell.type == CellType::triangle;
    if (!can_be_cut || values.size() != cell.particles.size()) {
      xml_.fail(head.node,
                std::string("expected a cut only of a tetrahedron or a triangle, with a number for each of its "
                            "particles, got ") +
                    std::to_string(values.size()) + " numbers of a cell of type " + cell_name(cell.type));
    }
    std::ranges::copy(values, cell.cuts.emplace_back(CellCut{}).begin());
  }
  if (model_.cells.size() >= largest_count) xml_.fail(node, "expected fewer than 2^31 cells, got more");
  if (component >= 0) model_.components[component].cells.push_back(static_cast<Index>(model_.cells.size()));
  model_.cells.push_back(std::move(cell));
  cell_rows_.push_back(head.marks.row.value_or(-1));
  cell_numbers_.push_back(head.index);
  extras_.cell_index.push_back(head.marks.unnumbered ? -1 : head.index);
  cell_nodes_.push_back(node);
}

void PmlReader::read_cell_parts(pugi::xml_node cell, std::vector<Index>& particles) {
  for (const pugi::xml_node child : cell.children()) {
    const std::string_view kind = child.name();
    if (kind == "atomRef") {
      particles.push_back(atom_row(child));
    } else if (kind != "cellProperties" && kind != "color" && kind != "nrOfStructures") {
      xml_.skip(child);
    }
  }
}

Index PmlReader::atom_row(pugi::xml_node atom_ref) const {
  const Index number = xml_.index(atom_ref, "index");
  const Index row = atoms_.find(number);
  if (row >= 0) return row;
  xml_.fail(atom_ref, "expected the index of an atom, got " + std::to_string(number) +
                          ", which no atom has; add the atom or remove the <atomRef>");
}

void PmlReader::require_material(pugi::xml_node node, const Material& material) const {
  try {
    require_in_range(material);
  } catch (const Error& error) {
    xml_.fail(node, error.what());
  }
}

Index PmlReader::take_material(pugi::xml_node node, std::vector<Attribute>& attributes) {
  std::array<std::optional<double>, material_names.size()> constants;
  std::size_t given = 0;
  for (std::size_t i = 0; i < material_names.size(); ++i) {
    const auto found = std::find_if(attributes.begin(), attributes.end(),
                                    [&](const Attribute& attribute) { return attribute.name == material_names[i]; });
    if (found == attributes.end()) continue;
    if (i < needed_names) ++given;
    constants[i] = parse_decimal(found->value);
  }
  if (given == 0) return -1;
  if (given < needed_names) {
    xml_.note(node, "expected young (Pa), poisson and density (kg/m^3) together, got some of them; no material is set");
    return -1;
  }
  for (std::size_t i = 0; i < material_names.size(); ++i) {
    if (i < needed_names || node.attribute(material_names[i])) xml_.number(node, material_names[i]);
  }
  Material material{*constants[0], *constants[1], *constants[2]};
  material.thickness = constants[needed_names].value_or(0.0);
  require_material(node, material);
  std::erase_if(attributes, [](const Attribute& attribute) {
    return std::find(material_names.begin(), material_names.end(), attribute.name) != material_names.end();
  });
  const auto [entry, is_new] =
      material_rows_.try_emplace({material.young, material.poisson, material.density, material.thickness},
                                 static_cast<Index>(model_.materials.size()));
  if (is_new) model_.materials.push_back(material);
  return entry->second;
}

void PmlReader::resolve_cell_references() {
  const IndexTable cells(cell_numbers_);
  note_repeated_cells(cells);
  if (cell_references_.empty()) return;
  const IndexTable neighbourhoods(extras_.neighbourhood_index);
  for (const CellReference& reference : cell_references_) {
    const Index row = cells.find(reference.index);
    if (row >= 0) {
      model_.components[reference.component].cell_refs.push_back(row);
    } else if (neighbourhoods.find(reference.index) >= 0) {
      xml_.note(reference.node, "expected the index of a cell that is no neighbourhood; this <cellRef> is left out");
    } else {
      xml_.fail(reference.node, "expected the index of a cell, got " + std::to_string(reference.index) +
                                    ", which no cell has; add the cell or remove the <cellRef>");
    }
  }
}

void PmlReader::note_repeated_cells(const IndexTable& cells) {
  for (const auto& [again, first] : cells.repeats()) {
    xml_.note(cell_nodes_[again], "expected each cell index once, got " + std::to_string(cell_numbers_[again]) +
                                      " again; a <cellRef> to it means the cell on line " +
                                      std::to_string(xml_.line(cell_nodes_[first])));
  }
}

void PmlReader::restore_cell_rows() {
  if (!any_given(cell_rows_)) return;
  const std::vector<Index> row = permute(model_.cells, cell_rows_, [this] { fail_rows("cell"); });
  std::vector<Index> index(row.size());
  for (std::size_t i = 0; i < row.size(); ++i) index[row[i]] = extras_.cell_index[i];
  extras_.cell_index = std::move(index);
  for (Component& component : model_.components) {
    for (Index& cell : component.cells) cell = row[cell];
    for (Index& cell : component.cell_refs) cell = row[cell];
  }
}

void PmlReader::restore_component_rows() {
  if (!any_given(component_rows_)) return;
  const std::vector<Index> row = permute(model_.components, component_rows_, [this] { fail_rows("component"); });
  for (std::size_t i = 0; i < model_.components.size(); ++i) {
    Index& parent = model_.components[i].parent;
    if (parent >= 0) parent = row[parent];
    if (parent >= static_cast<Index>(i)) fail_rows("component");
  }
}

void PmlReader::fail_rows(const char* what) const {
  xml_.fail(xml_.root(), std::string("expected the row=N of every ") + what +
                             " to count from 0 without gaps, parents before children, got something else; remove the "
                             "attributes \"" +
                             pml_mark_attribute + "\" to read the file in its own order");
}

}  // namespace phymul

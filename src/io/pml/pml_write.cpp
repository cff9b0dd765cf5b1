// SPDX-License-Identifier: MIT
#include <phymul/pml.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ostream>

#include "base/decimal.h"
#include "base/files.h"
#include "io/xml/xml_writer.h"
#include "model/body_type.h"
#include "model/cell_cutter.h"
#include "model/file_extras.h"
#include "pml_layout.h"

namespace phymul {
namespace {

/// One writing of a model.
class PmlWriter {
 public:
  PmlWriter(const Model& model, std::ostream& out, const PmlOptions& options)
      : model_(model), xml_(out), length_(options.length_unit), layout_(model) {
    const std::vector<Index> spare = spare_particles_of(model);
    for (auto last = spare.rbegin(); last != spare.rend() && *last + 1 == particles_; ++last) --particles_;
  }

  void write();

 private:
  void write_counts();
  void write_atoms();
  void write_section(const char* element, bool exclusive);
  void write_component(Index row);
  void write_cell(Index row, bool material_known);
  void write_loose_cells();
  void write_neighbourhoods();
  void write_material(const Material& material);
  void write_attributes(const std::vector<Attribute>& attributes, std::initializer_list<std::string_view> taken,
                        const char* element);
  void write_colour(const std::optional<Colour>& colour);
  void write_mark(const std::string& words);
  Index common_material(const Component& component, const std::vector<Index>& cells) const;

  const Model& model_;
  const FileExtras& extras_ = extras_of(model_);
  XmlWriter xml_;
  DecimalUnit length_;
  Index particles_ = model_.particle_count();  // without spare ones at the end, which have no mass

  PmlLayout layout_;
};

bool is_material_name(std::string_view name) {
  return name == "young" || name == "poisson" || name == "density" || name == "thickness";
}

bool has_material_names(const std::vector<Attribute>& attributes) {
  return std::any_of(attributes.begin(), attributes.end(),
                     [](const Attribute& attribute) { return is_material_name(attribute.name); });
}

void PmlWriter::write() {
  xml_.open("physicalModel");
  if (!model_.name.empty()) xml_.attribute("name", model_.name);
  if (model_.dimension != 3) xml_.attribute("dimension", Index{model_.dimension});
  write_counts();
  write_attributes(
      extras_.attributes,
      {"name", "dimension", "nrOfAtoms", "nrOfExclusiveComponents", "nrOfInformativeComponents", "nrOfCells"},
      "physicalModel");
  write_atoms();
  write_section("exclusiveComponents", true);
  if (!layout_.roots[0].empty()) write_section("informativeComponents", false);
  xml_.close();
  xml_.finish();
}

/// Counts as the tools of the field make them: structural components, and neighbourhoods among the cells.
void PmlWriter::write_counts() {
  std::size_t structural[2] = {0, 0};
  for (const Component& component : model_.components) structural[component.exclusive] += component.structural;
  xml_.attribute("nrOfAtoms", particles_);
  xml_.attribute("nrOfExclusiveComponents", structural[1]);
  xml_.attribute("nrOfInformativeComponents", structural[0]);
  xml_.attribute("nrOfCells",
                 model_.cells.size() + (layout_.neighbourhoods >= 0 ? static_cast<std::size_t>(particles_) : 0));
}

void PmlWriter::write_atoms() {
  const Component& list = extras_.atom_list;
  xml_.open("atoms");
  xml_.open("structuralComponent");
  if (!list.name.empty()) xml_.attribute("name", list.name);
  if (extras_.particle_index.empty()) write_mark("unnumbered");
  write_attributes(list.attributes, {"name", pml_mark_attribute}, "structuralComponent");
  write_colour(list.colour);
  xml_.leaf("nrOfStructures", "value", static_cast<std::size_t>(particles_));
  constexpr const char* axes[] = {"x", "y", "z"};
  std::string number;
  for (Index row = 0; row < particles_; ++row) {
    xml_.open("atom");
    xml_.open("atomProperties");
    xml_.attribute("index", model_.file_index(row));
    for (int axis = 0; axis < 3; ++axis) {
      number.clear();
      length_.append(number, model_.rest[row][axis]);
      xml_.raw_attribute(axes[axis], number);
    }
    xml_.attribute("mass", model_.mass[row]);
    if (model_.mass[row] == 0.0) write_mark("share=0");
    xml_.attribute("stiffness", model_.stiffness[row]);
    if (!extras_.particle_name.empty() && !extras_.particle_name[row].empty()) {
      xml_.attribute("name", extras_.particle_name[row]);
    }
    if (!extras_.particle_fields.empty()) {
      write_attributes(extras_.particle_fields[row],
                       {"index", "x", "y", "z", "mass", "stiffness", "name", pml_mark_attribute}, "atomProperties");
    }
    xml_.close();
    xml_.close();
  }
  xml_.close();
  xml_.close();
}

void PmlWriter::write_section(const char* element, bool exclusive) {
  const std::vector<Index>& roots = layout_.roots[exclusive];
  const bool implicit_neighbours =
      layout_.neighbourhoods < 0 && model_.neighbours == neighbours_from_cells(model_.cells, model_.particle_count());
  const bool hidden_neighbourhoods = exclusive && layout_.neighbourhoods < 0 && !implicit_neighbours;
  const bool extra = hidden_neighbourhoods || (exclusive && !layout_.loose.empty());
  // PML wants one multiComponent here.
  const bool wrapped = extra || roots.size() != 1 || model_.components[roots.front()].structural;
  xml_.open(element);
  if (wrapped) {
    xml_.open("multiComponent");
    xml_.attribute("name", std::string_view(exclusive ? "Exclusive Components" : "Informative Components"));
    write_mark("wrapper");
  }
  for (const Index row : roots) write_component(row);
  if (exclusive && !layout_.loose.empty()) write_loose_cells();
  if (hidden_neighbourhoods) {
    xml_.open("structuralComponent");
    xml_.attribute("name", std::string_view("Neighborhoods"));
    write_mark("unlisted");
    write_neighbourhoods();
    xml_.close();
  }
  if (wrapped) xml_.close();
  xml_.close();
}

void PmlWriter::write_component(Index row) {
  const Component& component = model_.components[row];
  xml_.open(component.structural ? "structuralComponent" : "multiComponent");
  if (!component.name.empty()) xml_.attribute("name", component.name);
  const Index material = common_material(component, layout_.own_cells[row]);
  if (material >= 0) write_material(model_.materials[material]);
  const std::vector<Index> cells = cells_of(component);
  const bool unweighed = needs_density(component) &&
                         std::ranges::any_of(cells, [this](Index cell) { return model_.cells[cell].material < 0; });
  std::string marks = unweighed ? "unweighed" : "";
  if (!layout_.components_in_order) marks += (marks.empty() ? "row=" : " row=") + std::to_string(row);
  if (!marks.empty()) write_mark(marks);
  write_attributes(component.attributes, {"name", pml_mark_attribute}, "component");
  write_colour(component.colour);
  for (const Index child : layout_.children[row]) write_component(child);
  if (component.structural) {
    const bool neighbourhoods = row == layout_.neighbourhoods;
    std::vector<Index> particles;  // those that are written
    std::ranges::copy_if(component.particles, std::back_inserter(particles),
                         [this](Index i) { return i < particles_; });
    const std::size_t structures = layout_.own_cells[row].size() + layout_.references[row].size() + particles.size();
    xml_.leaf("nrOfStructures", "value", structures + (neighbourhoods ? static_cast<std::size_t>(particles_) : 0));
    for (const Index cell : layout_.own_cells[row]) write_cell(cell, material >= 0);
    for (const Index cell : layout_.references[row])
      xml_.leaf("cellRef", "index", static_cast<std::size_t>(layout_.cell_number[cell]));
    for (const Index particle : particles) {
      xml_.leaf("atomRef", "index", static_cast<std::size_t>(model_.file_index(particle)));
    }
    if (neighbourhoods) write_neighbourhoods();
  }
  xml_.close();
}

/// The material of all these cells, where they have the same one and the component says nothing else of it.
Index PmlWriter::common_material(const Component& component, const std::vector<Index>& cells) const {
  if (cells.empty() || has_material_names(component.attributes)) return -1;
  const Index material = model_.cells[cells.front()].material;
  const bool common = std::all_of(cells.begin(), cells.end(), [&](Index cell) {
    return model_.cells[cell].material == material && !has_material_names(model_.cells[cell].attributes);
  });
  return common ? material : -1;
}

void PmlWriter::write_cell(Index row, bool material_known) {
  const Cell& cell = model_.cells[row];
  const Index number = layout_.cell_number[row];
  xml_.open("cell");
  xml_.open("cellProperties");
  if (number >= 0) xml_.attribute("index", number);
  xml_.attribute("type", std::string_view(cell_name(cell.type)));
  if (!cell.name.empty()) xml_.attribute("name", cell.name);
  const bool has_material = cell.material >= 0 && !material_known;
  if (has_material) write_material(model_.materials[cell.material]);
  std::string marks;
  const auto add = [&](std::string_view word) {
    if (!marks.empty()) marks += ' ';
    marks += word;
  };
  if (number >= 0 && model_.cell_file_index(row) < 0) add("unnumbered");
  if (!layout_.cells_in_order) add("row=" + std::to_string(row));
  if (cell.share != 1.0) add("share=" + to_decimal(cell.share));
  for (const CellCut& cut : cell.cuts) {
    add("cut=");
    for (std::size_t v = 0; v < cell.particles.size(); ++v) {
      if (v > 0) marks += ',';
      append_decimal(marks, cut[v]);
    }
  }
  if (!marks.empty()) write_mark(marks);
  for (const Attribute& attribute : cell.attributes) {
    // A part of a material that was left from a file gives way to the material set since.
    if (!has_material || !is_material_name(attribute.name)) {
      write_attributes({attribute}, {"index", "type", "name", pml_mark_attribute}, "cellProperties");
    }
  }
  xml_.close();
  write_colour(cell.colour);
  xml_.leaf("nrOfStructures", "value", cell.particles.size());
  for (const Index particle : cell.particles) {
    xml_.leaf("atomRef", "index", static_cast<std::size_t>(model_.file_index(particle)));
  }
  xml_.close();
}

void PmlWriter::write_loose_cells() {
  xml_.open("structuralComponent");
  xml_.attribute("name", std::string_view("Elements"));
  write_mark("loose");
  xml_.leaf("nrOfStructures", "value", layout_.loose.size());
  for (const Index cell : layout_.loose) write_cell(cell, false);
  xml_.close();
}

void PmlWriter::write_neighbourhoods() {
  auto fields = extras_.neighbourhood_fields.begin();
  for (Index row = 0; row < particles_; ++row) {
    xml_.open("cell");
    xml_.open("cellProperties");
    if (!extras_.neighbourhood_index.empty() && extras_.neighbourhood_index[row] >= 0) {
      xml_.attribute("index", extras_.neighbourhood_index[row]);
    }
    xml_.attribute("type", std::string_view("POLY_VERTEX"));
    xml_.attribute("name", "Atom #" + std::to_string(model_.file_index(row)));
    const bool has_fields = fields != extras_.neighbourhood_fields.end() && fields->particle == row;
    if (has_fields)
      write_attributes(fields->attributes, {"index", "type", "name", pml_mark_attribute}, "cellProperties");
    xml_.close();
    if (has_fields) write_colour((fields++)->colour);
    xml_.leaf("nrOfStructures", "value", static_cast<std::size_t>(model_.neighbours.size(row)));
    for (const Index* other = model_.neighbours.begin(row); other != model_.neighbours.end(row); ++other) {
      xml_.leaf("atomRef", "index", static_cast<std::size_t>(model_.file_index(*other)));
    }
    xml_.close();
  }
}

void PmlWriter::write_material(const Material& material) {
  xml_.attribute("young", material.young);
  xml_.attribute("poisson", material.poisson);
  xml_.attribute("density", material.density);
  if (material.thickness > 0.0) xml_.attribute("thickness", material.thickness);  // m
}

void PmlWriter::write_attributes(const std::vector<Attribute>& attributes,
                                 std::initializer_list<std::string_view> taken, const char* element) {
  for (const Attribute& attribute : attributes) {
    if (std::find(taken.begin(), taken.end(), attribute.name) != taken.end()) {
      throw Error("expected further attributes of <" + std::string(element) +
                  "> under other names than its own, got \"" + attribute.name + '"');
    }
    xml_.attribute(attribute.name, attribute.value);
  }
}

void PmlWriter::write_colour(const std::optional<Colour>& colour) {
  if (!colour) return;
  constexpr const char* parts[] = {"r", "g", "b", "a"};
  xml_.open("color");
  for (std::size_t i = 0; i < colour->size(); ++i) xml_.attribute(parts[i], (*colour)[i]);
  xml_.close();
}

void PmlWriter::write_mark(const std::string& words) {
  xml_.attribute(pml_mark_attribute, words);
}

void require_unit(const PmlOptions& options) {
  if (options.length_unit > 0.0 && std::isfinite(options.length_unit)) return;
  throw Error("PmlOptions: expected a positive length_unit in metres, got " + to_decimal(options.length_unit));
}

}  // namespace

void write_pml(const Model& model, std::ostream& out, const PmlOptions& options) {
  require_unit(options);
  validate(model);
  PmlWriter(model, out, options).write();
}

void write_pml(const Model& model, const std::string& path, const PmlOptions& options) {
  replace_file(path, [&](std::ostream& out) { write_pml(model, out, options); });
}

}  // namespace phymul

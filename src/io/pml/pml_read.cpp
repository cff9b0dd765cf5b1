// SPDX-License-Identifier: MIT
#include <phymul/check.h>

#include <array>
#include <cmath>
#include <new>
#include <stdexcept>

#include "base/byte_source.h"
#include "base/files.h"
#include "model/material.h"
#include "pml_reader.h"

namespace phymul {
namespace {

void require_usable(const PmlOptions& options) {
  const auto refuse = [](const char* what, double got) {
    throw Error(std::string("PmlOptions: expected ") + what + ", got " + to_decimal(got));
  };
  if (!(options.length_unit > 0.0) || !std::isfinite(options.length_unit)) {
    refuse("a positive length_unit in metres", options.length_unit);
  }
  if (!(options.default_mass > 0.0) || !std::isfinite(options.default_mass)) {
    refuse("a positive default_mass in kg", options.default_mass);
  }
  if (!(options.default_stiffness >= 0.0) || !std::isfinite(options.default_stiffness)) {
    refuse("a default_stiffness of 0 N/m or more", options.default_stiffness);
  }
}

}  // namespace

PmlReader::PmlReader(std::string text, std::string source, const PmlOptions& options)
    : xml_(std::move(text), std::move(source)), options_(options), length_(options.length_unit) {}

Model PmlReader::read() {
  const pugi::xml_node root = xml_.root();
  const std::string_view name = root.name();
  if (name != "physicalModel") {
    xml_.fail(root, "expected <physicalModel>, got <" + std::string(name) + '>' +
                        (name == "loads" ? "; read loads with read_lml" : ""));
  }
  read_root(root);
  pugi::xml_node atoms, exclusive, informative;
  for (const pugi::xml_node child : root.children()) {
    const std::string_view kind = child.name();
    pugi::xml_node* const section = kind == "atoms"                   ? &atoms
                                    : kind == "exclusiveComponents"   ? &exclusive
                                    : kind == "informativeComponents" ? &informative
                                                                      : nullptr;
    if (section == nullptr) {
      xml_.skip(child);
    } else if (*section) {
      xml_.fail(child, "expected one <" + std::string(kind) + ">, got a second one; the first is on line " +
                           std::to_string(xml_.line(*section)));
    } else {
      *section = child;
    }
  }
  if (!atoms) xml_.fail(root, "expected <atoms> in <physicalModel>, got none");
  read_atoms(atoms);
  xml_.discard(atoms);
  if (exclusive) {
    read_section(exclusive, true);
  } else {
    xml_.note(root, "no <exclusiveComponents>: the body has no parts of its own");
  }
  if (informative) read_section(informative, false);
  resolve_cell_references();
  finish_neighbourhoods();
  finish_particles();
  restore_cell_rows();
  restore_component_rows();
  drop_unused_materials(model_);
  model_.extras = std::move(extras_).share();
  model_.notes = xml_.take_notes();
  return std::move(model_);
}

void PmlReader::read_root(pugi::xml_node root) {
  model_.name = root.attribute("name").value();
  const pugi::xml_attribute dimension = root.attribute("dimension");
  if (dimension) {
    model_.dimension = xml_.index(root, "dimension", dimension.value());
    if (model_.dimension != 2 && model_.dimension != 3) {
      xml_.fail(root, "expected dimension 2 or 3, got " + XmlSource::cite(dimension.value()));
    }
  }
  // The counts are hints, often wrong: never used, written anew.
  extras_.attributes = xml_.other_attributes(
      root, {"name", "dimension", "nrOfAtoms", "nrOfExclusiveComponents", "nrOfInformativeComponents", "nrOfCells"});
}

void PmlReader::read_atoms(pugi::xml_node atoms) {
  bool first = true;
  for (const pugi::xml_node child : atoms.children()) {
    if (child.name() != std::string_view("structuralComponent")) {
      xml_.skip(child);
      continue;
    }
    if (!first) xml_.note(child, "expected one <structuralComponent> in <atoms>; the atoms of this one are added");
    read_atom_list(child, first);
    first = false;
  }
  if (model_.rest.empty()) xml_.fail(atoms, "expected at least one <atom> in <atoms>, got none");
  number_atoms(atoms);
  drop_row_numbers();
}

void PmlReader::read_atom_list(pugi::xml_node list, bool first) {
  Component& kept = extras_.atom_list;
  if (first) {
    kept.name = list.attribute("name").value();
    kept.attributes = xml_.other_attributes(list, {"name", pml_mark_attribute});
    unnumbered_ = marks(list).unnumbered;
  }
  // Counted, not believed: @value of nrOfStructures is a hint.
  std::size_t count = 0;
  for (pugi::xml_node atom = list.child("atom"); atom; atom = atom.next_sibling("atom")) ++count;
  const std::size_t total = model_.rest.size() + count;
  if (total > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
    xml_.fail(list, "expected fewer than 2^31 atoms, got " + std::to_string(total));
  }
  model_.rest.reserve(total);
  model_.mass.reserve(total);
  model_.stiffness.reserve(total);
  extras_.particle_index.reserve(total);
  for (const pugi::xml_node child : list.children()) {
    const std::string_view kind = child.name();
    if (kind == "atom") {
      read_atom(child);
    } else if (kind == "color") {
      if (first) kept.colour = colour(child);
    } else if (kind != "nrOfStructures") {
      xml_.skip(child);
    }
  }
}

void PmlReader::read_atom(pugi::xml_node atom) {
  const pugi::xml_node node = atom.child("atomProperties");
  if (!node) xml_.fail(atom, "expected <atomProperties> in <atom>, got none");
  for (const pugi::xml_node child : atom.children()) {
    if (child != node) xml_.skip(child);
  }
  constexpr std::array<const char*, 3> axes = {"x", "y", "z"};
  std::array<bool, 3> given{};
  Vec3 place(0, 0, 0);
  Index number = -1;
  double mass = unset, stiffness = unset;
  std::string_view name;
  bool others = false;
  for (const pugi::xml_attribute attribute : node.attributes()) {
    const std::string_view key = attribute.name();
    const std::string_view value = attribute.value();
    if (key == "index") {
      number = xml_.index(node, "index", value);
    } else if (key == "x" || key == "y" || key == "z") {
      const int axis = key[0] - 'x';
      const std::optional<double> coordinate = length_.parse(value);
      if (!coordinate) {
        xml_.fail(node, "expected a finite number with a decimal point in " + std::string(key) + ", got " +
                            XmlSource::cite(value));
      }
      place[axis] = *coordinate;
      given[static_cast<std::size_t>(axis)] = true;
    } else if (key == "mass") {
      mass = positive(node, "mass", value, marks(node).share == 0.0);
    } else if (key == "stiffness") {
      stiffness = positive(node, "stiffness", value, true);
    } else if (key == "name") {
      name = value;
    } else if (key != pml_mark_attribute) {
      others = true;
    }
  }
  if (number < 0) xml_.fail(node, "expected attribute \"index\" in <atomProperties>, got none");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (given[axis] || (axis == 2 && model_.dimension == 2)) continue;
    xml_.fail(node, std::string("expected attribute \"") + axes[axis] + "\" in <atomProperties>, got none");
  }
  if (model_.dimension == 2 && place.z() != 0.0) {
    xml_.fail(node, "expected z = 0 in a file of dimension 2, got " + XmlSource::cite(node.attribute("z").value()));
  }
  const std::size_t row = model_.rest.size();
  model_.rest.push_back(place);
  model_.mass.push_back(mass);
  model_.stiffness.push_back(stiffness);
  extras_.particle_index.push_back(number);
  // Most files name no atom: these lists start with the first that has something.
  if (!name.empty() || !extras_.particle_name.empty()) {
    extras_.particle_name.resize(row);
    extras_.particle_name.emplace_back(name);
  }
  std::vector<Attribute> fields =
      xml_.other_attributes(node, {"index", "x", "y", "z", "mass", "stiffness", "name", pml_mark_attribute});
  if (others || !extras_.particle_fields.empty()) {
    extras_.particle_fields.resize(row);
    extras_.particle_fields.push_back(std::move(fields));
  }
}

void PmlReader::number_atoms(pugi::xml_node atoms) {
  atoms_ = IndexTable(extras_.particle_index);
  if (!atoms_.repeats().empty()) fail_repeated_atom(atoms, extras_.particle_index[atoms_.repeats().front().first]);
}

void PmlReader::fail_repeated_atom(pugi::xml_node atoms, Index number) const {
  std::size_t first = 0;
  for (const pugi::xml_node list : atoms.children("structuralComponent")) {
    for (const pugi::xml_node atom : list.children("atom")) {
      const pugi::xml_node node = atom.child("atomProperties");
      if (xml_.index(node, "index") != number) continue;
      if (first != 0) {
        xml_.fail(node, "expected each atom index once, got " + std::to_string(number) +
                            " again; it is first on line " + std::to_string(first));
      }
      first = xml_.line(node);
    }
  }
  xml_.fail(atoms, "expected each atom index once, got " + std::to_string(number) + " twice");
}

void PmlReader::drop_row_numbers() {
  if (!unnumbered_) return;
  for (Index row = 0; row < model_.particle_count(); ++row) {
    if (extras_.particle_index[row] != row) return;
  }
  extras_.particle_index = {};
}

double PmlReader::positive(pugi::xml_node node, const char* attribute, std::string_view value,
                           bool zero_allowed) const {
  const double number = xml_.number(node, attribute, value);
  if (number > 0.0 || (zero_allowed && number == 0.0)) return number;
  xml_.fail(node, std::string("expected a ") + attribute + (zero_allowed ? " of 0 or more" : " above 0") + ", got " +
                      XmlSource::cite(value));
}

PmlMarks PmlReader::marks(pugi::xml_node node) const {
  const std::string_view text = node.attribute(pml_mark_attribute).value();
  if (text.empty()) return {};
  const std::optional<PmlMarks> parsed = parse_pml_marks(text);
  if (!parsed) {
    xml_.fail(node, std::string("expected attribute \"") + pml_mark_attribute +
                        "\" as write_pml makes it (unnumbered, wrapper, loose, unlisted, unweighed, row=N), got " +
                        XmlSource::cite(text));
  }
  return *parsed;
}

std::optional<Colour> PmlReader::colour(pugi::xml_node node) {
  const bool opaque = !node.attribute("a");
  const Colour read = {xml_.number(node, "r"), xml_.number(node, "g"), xml_.number(node, "b"),
                       opaque ? 1.0 : xml_.number(node, "a")};
  for (const double part : read) {
    if (part >= 0.0 && part <= 1.0) continue;
    xml_.note(node, "expected the parts of a colour between 0 and 1; this colour is left out");
    return std::nullopt;
  }
  return read;
}

Model read_pml_text(std::string text, const std::string& source, const PmlOptions& options) {
  require_usable(options);
  if (text.size() > options.max_bytes) {
    fail_access(source, "expected at most " + std::to_string(options.max_bytes) + " bytes, got " +
                            std::to_string(text.size()) + "; raise max_bytes if the file is meant");
  }
  try {
    // The text and its tree are gone before the mesh is checked.
    return reading(source, [&] {
      Model model = PmlReader(std::move(text), source, options).read();
      validate(model);
      check_mesh(model, source);
      return model;
    });
  } catch (const std::bad_alloc&) {
    fail_memory(source);
  } catch (const std::length_error&) {
    fail_memory(source);
  }
}

Model read_pml(const std::string& path, const PmlOptions& options) {
  require_usable(options);
  return read_pml_text(read_whole_file(path, options.max_bytes), path, options);
}

}  // namespace phymul

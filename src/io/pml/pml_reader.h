// SPDX-License-Identifier: MIT
//
// One reading of a PML file. Particles first, then components with their cells; what refers forward is kept as nodes
// and resolved at the end, while the XML tree still stands.
#pragma once

#include <phymul/pml.h>
#include <pugixml.hpp>

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/decimal.h"
#include "base/index_table.h"
#include "io/xml/xml_source.h"
#include "model/file_extras.h"
#include "pml_layout.h"

namespace phymul {

class PmlReader {
 public:
  PmlReader(std::string text, std::string source, const PmlOptions& options);

  /// The model as the file has it, cells not yet oriented. Call once.
  Model read();

 private:
  // Attributes of one cellProperties, already told apart.
  struct CellHead {
    pugi::xml_node node;  // cellProperties
    CellType type = CellType::atom;
    Index index = -1;
    std::string_view name;
    std::string_view mass, stiffness;  // data() == nullptr: not there
    PmlMarks marks;
    std::vector<Attribute> others;  // mass and stiffness among them
  };

  struct BodyToWeigh {
    pugi::xml_node node;
    Index material;
  };

  struct CellReference {
    pugi::xml_node node;
    Index component;
    Index index;
  };

  // pml_read.cpp: the root and the particles
  void read_root(pugi::xml_node root);
  void read_atoms(pugi::xml_node atoms);
  void read_atom_list(pugi::xml_node list, bool first);
  void read_atom(pugi::xml_node atom);
  void number_atoms(pugi::xml_node atoms);
  [[noreturn]] void fail_repeated_atom(pugi::xml_node atoms, Index number) const;
  void drop_row_numbers();
  double positive(pugi::xml_node node, const char* attribute, std::string_view value, bool zero_allowed) const;
  PmlMarks marks(pugi::xml_node node) const;
  std::optional<Colour> colour(pugi::xml_node node);

  // pml_read_components.cpp: the tree of components and its cells
  void read_section(pugi::xml_node section, bool exclusive);
  void read_component(pugi::xml_node node, Index parent, bool exclusive);
  Index add_component(pugi::xml_node node, const PmlMarks& own, Index parent, bool exclusive, bool structural);
  void read_structures(pugi::xml_node node, Index component, bool neighbourhoods);
  void read_cell(pugi::xml_node node, Index component, Index material);
  CellHead read_cell_head(pugi::xml_node cell);
  void read_cell_parts(pugi::xml_node cell, std::vector<Index>& particles);
  Index atom_row(pugi::xml_node atom_ref) const;
  void require_material(pugi::xml_node node, const Material& material) const;
  Index take_material(pugi::xml_node node, std::vector<Attribute>& attributes);
  void resolve_cell_references();
  void note_repeated_cells(const IndexTable& cells);
  [[noreturn]] void fail_rows(const char* what) const;
  void restore_component_rows();
  void restore_cell_rows();

  // pml_read_neighbourhoods.cpp
  void open_neighbourhoods(pugi::xml_node component);
  void read_neighbourhood(pugi::xml_node cell, const CellHead& head);
  void finish_neighbourhoods();
  void keep_neighbourhood_fields(pugi::xml_node cell, Index row);
  void note_missing(const std::vector<Index>& rows);
  void note_defaults();
  void finish_particles();

  // pml_read_neighbourhoods.cpp: what the attribute bodyType adds
  void take_body_constants();
  void take_masses_of_densities();
  void add_bodies_to_weigh();
  void weigh_bodies();
  void fill_immovable_bodies();

  static constexpr std::size_t largest_count = std::numeric_limits<Index>::max();
  static constexpr double unset = std::numeric_limits<double>::quiet_NaN();

  XmlSource xml_;
  PmlOptions options_;
  DecimalUnit length_;
  Model model_;
  FileExtras extras_;
  IndexTable atoms_;
  bool unnumbered_ = false;

  std::vector<CellReference> cell_references_;
  std::vector<Index> component_rows_;  // [components] wanted row, -1: none given
  std::vector<pugi::xml_node> component_nodes_;
  std::vector<char> unweighed_;  // [components] PmlMarks::unweighed
  std::vector<BodyToWeigh> to_weigh_;
  std::vector<Index> cell_rows_;     // [cells] likewise
  std::vector<Index> cell_numbers_;  // [cells] as in the file, -1: none
  std::vector<pugi::xml_node> cell_nodes_;
  std::map<std::array<double, 4>, Index> material_rows_;  // of young, poisson, density and thickness

  pugi::xml_node neighbourhoods_;                   // the component, where there is one
  double component_mass_ = unset;                   // of that component
  double component_stiffness_ = unset;              // likewise
  std::vector<pugi::xml_node> neighbourhood_cell_;  // [N] or empty
};

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Physical Model Language: the body as an XML file.
#pragma once

#include <phymul/model.h>

#include <cstddef>
#include <iosfwd>
#include <string>

namespace phymul {

struct PmlOptions {
  double length_unit = 1e-3;       ///< metres per file unit; PML files are in millimetres by habit
  double default_mass = 1.0;       ///< kg, where neither atom nor neighbourhood cell nor its component has one
  double default_stiffness = 1.0;  ///< N/m, likewise
  std::size_t max_bytes = std::size_t{4} << 30;  ///< larger files are refused
};

/// Reads a body. Neighbourhoods come from the structuralComponent "Neighborhoods" where there is one, else from the
/// cells. Mass and stiffness: atom, then its neighbourhood cell, then that cell's component, then the default, which is
/// noted with its value (the stiffness where no cell has a material): 1 kg a particle is nobody's tissue. Cells are
/// oriented and the mesh is checked (check.h); what was found stands in Model::notes. Throws Error
/// ("file:line: expected ..., got ...; do ...") and leaves nothing behind.
Model read_pml(const std::string& path, const PmlOptions& options = {});

/// The same from memory; `source` stands for the file name in messages.
Model read_pml_text(std::string text, const std::string& source, const PmlOptions& options = {});

/// Writes the model so that read_pml with the same options gives an equal one, unknown attributes included. Coordinates
/// come back bit by bit where length_unit is a power of ten, else within two units in the last place. Not written:
/// fibres, dissipation, and the material of a body of points, since materials are in cells. A cell that two components
/// define is written in the first and referred to in the second.
/// Throws Error when the file cannot be written; an existing file is replaced only by a complete one.
void write_pml(const Model& model, const std::string& path, const PmlOptions& options = {});
void write_pml(const Model& model, std::ostream& out, const PmlOptions& options = {});

}  // namespace phymul

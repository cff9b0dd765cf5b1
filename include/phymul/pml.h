// SPDX-License-Identifier: MIT
//
// Physical Model Language: the body as an XML file.
#pragma once

#include <phymul/model.h>

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace phymul {

struct PmlOptions {
  double length_unit = 1e-3;       ///< metres per file unit; PML files are in millimetres by habit
  double default_mass = 1.0;       ///< kg, where neither atom nor neighbourhood cell nor its component has one
  double default_stiffness = 1.0;  ///< N/m, likewise
  std::size_t max_bytes = std::size_t{4} << 30;  ///< larger files are refused
};

class Scene;

/// Reads a body. Neighbourhoods come from the structuralComponent "Neighborhoods" where there is one, else from the
/// cells. Mass and stiffness: atom, then its neighbourhood cell, then that cell's component, then the default, which is
/// noted with its value (the stiffness where no cell has a material): 1 kg a particle is nobody's tissue. Bodies of the
/// bodyType FEM, stiffSpring and rigid come before the default: with their mass, with a density times volume, and with
/// a shape stiffness of 0 unless they are FEM. FEM with young and poisson gets the density of its masses. Cells are
/// oriented and the mesh is checked (check.h); what was found stands in Model::notes. Throws Error
/// ("file:line: expected ..., got ...; do ...") and leaves nothing behind.
Model read_pml(const std::string& path, const PmlOptions& options = {});

/// The same from memory; `source` stands for the file name in messages.
Model read_pml_text(std::string text, const std::string& source, const PmlOptions& options = {});

/// Adds what the components of scene.model() are by their attribute bodyType, as in the scenes of SOFA's reader of PML:
/// - "rigid", or any other body with mass="0": its particles are held where they are.
/// - "stiffSpring": a joint with a spring along each edge, and each long diagonal of a hexahedron, of its cells without
///   a material; stiffness in N/m and damping in N s/m (0 if omitted) are attributes.
/// - "interaction": the same along its lines between particles of the components that body1 and body2 name.
/// - "FEM": nothing, because the materials are in the model.
/// Joints have the names of their components, numbered from the second one of a name. Contacts are switched on, with
/// their defaults, if two components have collision="true". Returns a sentence for each of these components, also where
/// nothing is added; none for a model without them. Call it once. Throws Error, and changes nothing, for constants that
/// are no numbers of 0 or more, lines that do not join two particles of the named bodies, and joints that the scene has
/// already.
std::vector<std::string> add_body_types(Scene& scene);

/// Writes the model so that read_pml with the same options gives an equal one, unknown attributes included. Coordinates
/// come back bit by bit where length_unit is a power of ten, else within two units in the last place. Not written:
/// fibres, stiffening, dissipation, spare particles, and the material of a body of points, since materials are in
/// cells. A cell that two components define is written in the first and referred to in the second. Throws Error when
/// the file cannot be written; an existing file is replaced only by a complete one.
void write_pml(const Model& model, const std::string& path, const PmlOptions& options = {});
void write_pml(const Model& model, std::ostream& out, const PmlOptions& options = {});

}  // namespace phymul

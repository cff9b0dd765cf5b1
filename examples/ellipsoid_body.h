// SPDX-License-Identifier: MIT
//
// An ellipsoid of hexahedra, with a shell around it where wanted: an organ, and what it lies in.
#pragma once

#include <phymul/model.h>

struct EllipsoidShape {
  phymul::Vec3 semi_axes{0.03, 0.02, 0.015};  ///< m, of the organ, centred at the origin
  double shell = 0.0;                         ///< m that the shell adds to each semi-axis
  phymul::Vec3 shell_shift{0, 0, 0};          ///< m, of the shell's outer side against the organ
  int core = 6;          ///< cells across the inner block, even: so the planes of symmetry lie between cells
  int organ_layers = 2;  ///< cells from the block to the organ's surface, >= 1
  int shell_layers = 0;  ///< cells through the shell
};

/// A rounded block in the middle and layers around it, so that no cell is flattened, as those at the edges of a cube
/// bent to a ball would be. Groups: "organ" and "surface" (the organ's), "shell", "skin" (the outer side) and "rind"
/// (the outermost layer) where there is one.
phymul::Model make_ellipsoid(const EllipsoidShape& shape);

/// Gives the cells of organ and shell their materials; set_material's masses for both.
void set_materials(phymul::Model& model, const EllipsoidShape& shape, const phymul::Material& organ,
                   const phymul::Material& around);

// SPDX-License-Identifier: MIT
//
// Bodies of the tools, read from a file, or that fill a surface or a labelled image of one.
#pragma once

#include <phymul/body.h>
#include <phymul/scene.h>

#include <optional>
#include <string>
#include <vector>

struct FileBody {
  phymul::Model model;
  std::optional<phymul::Surface> surface;  ///< that the body fills; a note says what it became
};

bool is_pml(const std::string& path);  ///< by the file's ending, as the next two

/// Whether read_surface() reads it.
bool is_surface(const std::string& path);

/// Whether read_labels() reads it.
bool is_label_image(const std::string& path);

/// Particles in the ball of x, y, z and radius, m, which stand at `ball`. Throws phymul::Error that begins with the
/// option's name if there are none.
std::vector<phymul::Index> particles_in_ball(const phymul::Model& model, const double* ball,
                                             const std::string& option = "--fix-near");

/// Holds the parts of a surface that are in the balls, m, each x y z radius, as Scene::hold(). `spacing`: of the body
/// that fills it. Throws phymul::Error that begins with "--hold-near: " if there are balls but no surface, or no part
/// of it is inside.
void hold_in_balls(phymul::Scene& scene, const phymul::Surface* surface, double spacing,
                   const std::vector<double>& balls);

/// m per length unit of a body's file: as asked for, else (0) millimetres for PML and metres for others, as the readers
/// have it.
double length_unit(const std::string& path, double asked);

/// A body without the material of the options. The regions of a labelled image are groups of their names; a note
/// compares their volumes. unit: 0 where none was given, as spacing. from_file: with the file's own masses and
/// stiffnesses. fine_balls: m, each x y z radius spacing, as fine_near(). Throws phymul::Error as the readers,
/// make_body() and fine_near() do, and where an option is missing or means nothing for such a file.
FileBody read_body_file(const std::string& path, double unit, double spacing, bool from_file,
                        const std::vector<double>& fine_balls = {});

/// Whether a cut goes through a cell: then the body's tissue is to be shown (phymul/surface.h), not its cells.
bool is_cut(const phymul::Model& model);

/// The same body with spare particles (phymul/body.h) for four cuts through its middle.
phymul::Model with_room_for_cuts(const phymul::Model& model);

// SPDX-License-Identifier: MIT
//
// Bodies of the tools that fill a surface or a labelled image from a file.
#pragma once

#include <phymul/body.h>
#include <phymul/scene.h>

#include <string>
#include <vector>

struct SurfaceBody {
  phymul::Surface surface;
  phymul::Model model;  ///< its inside; a note says what it became
};

/// By the file's ending: whether read_surface() reads it.
bool is_surface(const std::string& path);

/// By the file's ending: whether read_labels() reads it.
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

/// fine_balls: m, each x y z radius spacing, as fine_near(). Throws phymul::Error as read_surface(), make_body() and
/// fine_near() do, and where the spacing is 0: none was given.
SurfaceBody fill_surface(const std::string& path, double metres_per_unit, double spacing,
                         const std::vector<double>& fine_balls = {});

/// The regions of a labelled image, each a group of its name; a note compares their volumes. Throws phymul::Error as
/// read_labels(), make_body() and fine_near() do, and where the spacing is 0: none was given.
phymul::Model fill_labels(const std::string& path, double spacing, const std::vector<double>& fine_balls = {});

/// The same body with spare particles (phymul/body.h) for four cuts through its middle.
phymul::Model with_room_for_cuts(const phymul::Model& model);

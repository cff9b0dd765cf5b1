// SPDX-License-Identifier: MIT
#include "view_options.h"

#include <phymul/phymul.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <utility>

namespace {

constexpr const char* keys =
    "In the window:\n"
    "  left drag      on a particle: pull it; elsewhere: turn the view\n"
    "  right drag     shift the view;  wheel: zoom;  f: whole body\n"
    "  x              scalpel, or no longer: a left drag cuts along its way, through the whole depth of the body\n"
    "  z              undo the last cut: back to the moment before it\n"
    "  space          pause;  n: one step;  r: back to the rest shape, uncut\n"
    "  b              next backend\n"
    "  s e l p a o    surface, edges, links, particles, attractors (without a material), outline of the rest shape\n"
    "  k              the file's own surface, or that of a cut body, or the body's cells\n"
    "  t              surface lets through;  c: colours by displacement;  + -: their scale\n"
    "  q, escape      end";

FileBody shape_or_file(const ViewOptions& options) {
  const std::string& name = options.body;
  if (name == "tetrahedron") return {phymul::make_tetrahedron(0.01), {}};
  if (name == "cylinder") return {phymul::make_cylinder(0.010, 0.040, 3, 8, 11), {}};
  if (name == "block") return {phymul::make_block({0.04, 0.03, 0.02}, 12, 9, 6), {}};
  if (name == "strip") return {phymul::make_strip(0.04, 0.02, 12, 6, true), {}};
  if (!std::filesystem::exists(name)) {
    throw phymul::Error(name + ": expected a file, or one of tetrahedron, cylinder, block, strip");
  }
  return read_body_file(name, options.length_unit, options.spacing, options.from_file);
}

}  // namespace

FileBody make_view_body(const ViewOptions& options) {
  FileBody body = shape_or_file(options);
  phymul::Model& model = body.model;
  const bool has_volume = std::any_of(model.cells.begin(), model.cells.end(),
                                      [](const phymul::Cell& cell) { return phymul::is_volume(cell.type); });
  if (!options.from_file && model.dimension == 3 && has_volume) phymul::set_material(model, options.material);
  return body;
}

std::optional<ViewOptions> read_view_options(int argc, char** argv, int& exit_code) {
  ViewOptions options;
  CLI::App app{"Shows a body in a window while it moves, and lets a mouse pull it."};
  app.name("phymul-view");
  app.set_version_flag("--version", PHYMUL_VERSION);
  app.footer(keys);
  app.add_option(
         "body", options.body,
         "a .pml, .msh, .vtk or .vtu file, a surface (.stl, .obj, .ply, .gltf, .glb), a labelled image (.nii, .nii.gz, "
         ".nrrd, .nhdr), or tetrahedron, cylinder, block, strip")
      ->capture_default_str();
  app.add_option("--unit", options.length_unit, "metres per length unit of the body's file [1e-3 for .pml, else 1]")
      ->check(CLI::PositiveNumber);
  app.add_option("--spacing", options.spacing, "mean distance between the particles that fill a surface or image, m")
      ->check(CLI::PositiveNumber);
  app.add_option("loads", options.loads, "what acts on it: .lml")->check(CLI::ExistingFile);
  app.add_option("--fix", options.fixed_groups, "hold this group of particles; may be given several times")
      ->allow_extra_args(false);
  app.add_option("--fix-near", options.fixed_balls, "hold the particles in a ball, m; may be given several times")
      ->option_text("X Y Z RADIUS")
      ->type_size(4)
      ->allow_extra_args(false);
  app.add_option("--hold-near", options.held_balls,
                 "hold the part of the surface in a ball, m; may be given several times")
      ->option_text("X Y Z RADIUS")
      ->type_size(4)
      ->allow_extra_args(false);
  app.add_option("--backend", options.backend, "solver by name")->capture_default_str();
  app.add_flag("--from-file", options.from_file, "masses, stiffnesses and materials of the file alone");
  app.add_option("--young", options.material.young, "Young's modulus, Pa")->capture_default_str();
  app.add_option("--poisson", options.material.poisson, "Poisson's ratio")->capture_default_str();
  app.add_option("--damping", options.damping_rate, "rate of loss of velocity, 1/s")->capture_default_str();
  app.add_option("--step", options.step_share, "step, as a share of the stable one")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--width", options.width, "pixels")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--height", options.height, "pixels")->check(CLI::PositiveNumber)->capture_default_str();
  auto* frames =
      app.add_option("--frames", options.frames, "end after so many")->check(CLI::PositiveNumber)->group("Scripts");
  app.add_option("--png", options.png, "write the last frame there")->needs(frames)->group("Scripts");
  app.add_flag("--hidden", options.hidden, "no window on the screen")->group("Scripts");
  app.add_option("--keys", options.keys, "press these, one a frame")->group("Scripts");
  app.add_option("--drag", options.drag, "as the mouse, pixels; may be given several times")
      ->option_text("X0 Y0 X1 Y1")
      ->type_size(4)
      ->allow_extra_args(false)
      ->group("Scripts");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? 0 : 1;
    return std::nullopt;
  }
  return options;
}

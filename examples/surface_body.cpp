// SPDX-License-Identifier: MIT
#include "surface_body.h"

#include <phymul/error.h>
#include <phymul/surface_file.h>

#include <algorithm>
#include <array>
#include <filesystem>

bool is_surface(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return std::ranges::any_of(std::array{".stl", ".STL", ".obj", ".ply", ".gltf", ".glb"},
                             [&](const char* known) { return extension == known; });
}

SurfaceBody fill_surface(const std::string& path, double metres_per_unit, double spacing) {
  if (spacing == 0.0) throw phymul::Error(path + ": a surface is filled; give --spacing, m");
  SurfaceBody body;
  body.surface = phymul::read_surface(path, metres_per_unit);
  phymul::BodyReport report;
  body.model = phymul::make_body(body.surface, {.spacing = spacing}, &report);
  body.model.notes.push_back(path + ": filled with " + std::to_string(report.particles) + " particles in " +
                             std::to_string(report.cells) + " tetrahedra");
  return body;
}

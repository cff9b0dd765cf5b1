// SPDX-License-Identifier: MIT
#include "surface_body.h"

#include <phymul/error.h>
#include <phymul/surface_file.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <limits>

bool is_surface(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::any_of(std::array{".stl", ".obj", ".ply", ".gltf", ".glb"},
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

std::vector<phymul::Index> particles_in_ball(const phymul::Model& model, const double* ball) {
  const phymul::Vec3 centre(ball[0], ball[1], ball[2]);
  double nearest = std::numeric_limits<double>::infinity();
  const std::vector<phymul::Index> found = model.particles_in([&](const phymul::Vec3& at) {
    nearest = std::min(nearest, (at - centre).norm());
    return (at - centre).norm() <= ball[3];
  });
  if (found.empty()) {
    throw phymul::Error("--fix-near: no particle is so near; the nearest is " + std::to_string(nearest) + " m away");
  }
  return found;
}

// SPDX-License-Identifier: MIT
#include "surface_body.h"

#include <phymul/error.h>
#include <phymul/label_file.h>
#include <phymul/mesh.h>
#include <phymul/pml.h>
#include <phymul/surface_file.h>
#include <phymul/surface_patch.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <string_view>

namespace {

bool ends_in_one_of(const std::string& path, std::initializer_list<std::string_view> endings) {
  std::string lower = path;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::any_of(endings, [&](std::string_view known) { return lower.ends_with(known); });
}

/// Empty without balls.
phymul::SpacingField finest_of(const std::vector<double>& fine_balls, double spacing) {
  std::vector<phymul::SpacingField> fields;
  for (std::size_t k = 0; k + 4 < fine_balls.size(); k += 5) {
    const double* ball = &fine_balls[k];
    fields.push_back(phymul::fine_near({ball[0], ball[1], ball[2]}, ball[3], ball[4], spacing));
  }
  if (fields.empty()) return {};
  return [fields, spacing](const phymul::Vec3& place) {
    double least = spacing;
    for (const phymul::SpacingField& field : fields) least = std::min(least, field(place));
    return least;
  };
}

FileBody filled(const std::string& path, bool is_image, double unit, double spacing,
                const std::vector<double>& fine_balls) {
  const phymul::SpacingField finest = finest_of(fine_balls, spacing);
  FileBody body;
  phymul::BodyReport report;
  if (is_image) {
    body.model = phymul::make_body(phymul::read_labels(path), {.spacing = spacing, .spacing_at = finest}, &report);
  } else {
    body.surface = phymul::read_surface(path, unit);
    body.model = phymul::make_body(*body.surface, {.spacing = spacing, .spacing_at = finest}, &report);
  }
  std::string note = path + ": filled with " + std::to_string(report.particles) + " particles in " +
                     std::to_string(report.cells) + " tetrahedra";
  for (const phymul::RegionReport& region : report.regions) {
    char text[64];
    std::snprintf(text, sizeof text, "\": %.4g of %.4g ml", 1e6 * region.volume, 1e6 * region.wanted_volume);
    note += "; \"" + region.name + text;
  }
  body.model.notes.push_back(std::move(note));
  return body;
}

}  // namespace

bool is_pml(const std::string& path) {
  return ends_in_one_of(path, {".pml"});
}

bool is_surface(const std::string& path) {
  return ends_in_one_of(path, {".stl", ".obj", ".ply", ".gltf", ".glb"});
}

bool is_label_image(const std::string& path) {
  return ends_in_one_of(path, {".nii", ".nii.gz", ".nrrd", ".nhdr"});
}

double length_unit(const std::string& path, double asked) {
  if (asked > 0.0) return asked;
  return is_pml(path) ? phymul::PmlOptions{}.length_unit : phymul::MeshOptions{}.length_unit;
}

FileBody read_body_file(const std::string& path, double unit, double spacing, bool from_file,
                        const std::vector<double>& fine_balls) {
  const bool is_image = is_label_image(path);
  if (is_image || is_surface(path)) {
    const std::string kind = is_image ? "a labelled image" : "a surface";
    if (spacing == 0.0) throw phymul::Error(path + ": " + kind + " is filled; give --spacing, m");
    if (from_file) throw phymul::Error("--from-file: " + kind + " has no masses and stiffnesses, got " + path);
    if (is_image && unit > 0.0) throw phymul::Error("--unit: " + path + " says its unit itself");
    return filled(path, is_image, length_unit(path, unit), spacing, fine_balls);
  }
  if (!fine_balls.empty()) {
    throw phymul::Error("--fine-near: expected a surface or a labelled image to be filled, got " + path);
  }
  if (spacing != 0.0) {
    throw phymul::Error("--spacing: " + path + " is neither a surface nor a labelled image to be filled");
  }
  const double metres = length_unit(path, unit);
  return {
      is_pml(path) ? phymul::read_pml(path, {.length_unit = metres}) : phymul::read_mesh(path, {.length_unit = metres}),
      {}};
}

std::vector<phymul::Index> particles_in_ball(const phymul::Model& model, const double* ball,
                                             const std::string& option) {
  const phymul::Vec3 centre(ball[0], ball[1], ball[2]);
  if (!centre.allFinite() || !(ball[3] >= 0.0)) {
    throw phymul::Error(option + ": expected a finite place and a radius of 0 or more, m");
  }
  double nearest = std::numeric_limits<double>::infinity();
  const std::vector<phymul::Index> found = model.particles_in([&](const phymul::Vec3& at) {
    nearest = std::min(nearest, (at - centre).norm());
    return (at - centre).norm() <= ball[3];
  });
  if (found.empty()) {
    throw phymul::Error(option + ": no particle is so near; the nearest is " + std::to_string(nearest) + " m away");
  }
  return found;
}

void hold_in_balls(phymul::Scene& scene, const phymul::Surface* surface, double spacing,
                   const std::vector<double>& balls) {
  if (balls.empty()) return;
  if (surface == nullptr) {
    throw phymul::Error(
        "--hold-near: expected a surface that is filled; --fix-near holds the particles of other bodies");
  }
  for (std::size_t k = 0; k < balls.size(); k += 4) {
    const phymul::Vec3 centre(balls[k], balls[k + 1], balls[k + 2]);
    const double radius = balls[k + 3];
    const auto inside = [&](const phymul::Vec3& at) { return (at - centre).norm() <= radius; };
    try {
      scene.hold(phymul::sample_surface(*surface, spacing / 3.0, inside));
    } catch (const phymul::Error& error) {
      throw phymul::Error("--hold-near: " + std::string(error.what()));
    }
  }
}

bool is_cut(const phymul::Model& model) {
  return std::ranges::any_of(model.cells, [](const phymul::Cell& cell) { return !cell.cuts.empty(); });
}

phymul::Model with_room_for_cuts(const phymul::Model& model) {
  const double across = std::cbrt(model.particle_count());  // particles in a row
  return with_spare_particles(model, static_cast<phymul::Index>(4.0 * 2.3 * across * across));
}

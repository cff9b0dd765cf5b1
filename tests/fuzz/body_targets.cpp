// SPDX-License-Identifier: MIT
#include <phymul/body.h>
#include <phymul/label_file.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "fuzz_target.h"

namespace phymul::fuzz {
namespace {

constexpr Index most_particles = 3000;

/// What make_body() gives is a body that simulates: valid, in the limits asked for.
void check_body(const Model& body, const BodyReport& report) {
  check_model(body);
  require(body.particle_count() <= most_particles, "more particles than allowed");
  require(report.particles == body.particle_count() && report.volume > 0.0, "a report of another body");
}

void check_image(const LabelImage& image) {
  require(image.label.size() == std::size_t(image.size[0]) * std::size_t(image.size[1]) * std::size_t(image.size[2]),
          "an image of other sizes than its voxels");
  require(image.origin.allFinite(), "an image that is nowhere");
}

/// Places of all triangles' corners.
VecList corners(const Surface& surface) {
  VecList places;
  for (const auto& triangle : surface.triangles) {
    for (const Index corner : triangle) places.push_back(surface.vertices.at(corner));
  }
  return places;
}

/// Whether no edge has more than two triangles.
bool is_simple(const Surface& surface) {
  std::map<std::pair<Index, Index>, int> triangles;
  for (const auto& [a, b, c] : surface.triangles) {
    for (const auto& side : {std::minmax(a, b), std::minmax(b, c), std::minmax(c, a)}) ++triangles[side];
  }
  return std::ranges::all_of(triangles, [](const auto& edge) { return edge.second <= 2; });
}

void read_image(std::string_view bytes, const char* ending) {
  const std::string path = file_with(bytes, ending);
  accepts_file(path, [&] { check_image(read_labels(path)); });
}

}  // namespace

void nifti(std::string_view bytes) {
  read_image(bytes, ".nii");
}

void nrrd(std::string_view bytes) {
  // Not files that name others: teem would open whatever they name.
  if (bytes.find("file:") == std::string_view::npos) read_image(bytes, ".nrrd");
}

void surface(std::string_view bytes) {
  Numbers in(bytes);
  Surface any;
  const int vertices = in.between(0, 31), triangles = in.between(0, 63);
  for (int k = 0; k < vertices; ++k) any.vertices.push_back(0.1 * in.point());
  for (int k = 0; k < triangles; ++k) any.triangles.push_back({in.between(-1, 32), in.between(-1, 32), in.below(32)});
  const Surface before = any;
  if (!accepts([&] { mend_surface(any); })) {
    require(any.triangles == before.triangles && any.vertices.size() == before.vertices.size(), "refused, but changed");
    return;
  }
  Surface again = any;
  mend_surface(again);  // may number vertices anew, and nothing else
  // Shells that cross along an edge that they share are not found; what is outside of them is then any one's.
  require(!is_simple(any) || corners(again) == corners(any), "mended twice it is another one");
  BodyReport report;
  accepts([&] {
    const double spacing = 0.02 + 0.02 * std::abs(in.real());
    check_body(make_body(any, {.spacing = spacing, .most_particles = most_particles}, &report), report);
  });
}

void labels(std::string_view bytes) {
  Numbers in(bytes);
  LabelImage image;
  for (Index& size : image.size) size = in.between(1, 6);
  image.origin = 0.1 * in.point();
  for (Vec3& step : image.step) step += 1e-3 * in.point();
  image.label.resize(std::size_t(image.size[0]) * std::size_t(image.size[1]) * std::size_t(image.size[2]));
  LabelBodyOptions options{.spacing = 1e-3 * (0.5 + 4 * std::abs(in.real())), .most_particles = most_particles};
  options.most_volume_error = 0.01 * in.below(100);
  if (in.below(4) == 0) options.regions = {{1, "one"}, {2, in.below(2) == 0 ? "one" : "two"}};
  for (std::uint16_t& label : image.label) label = static_cast<std::uint16_t>(in.below(4));
  BodyReport report;
  accepts([&] { check_body(make_body(image, options, &report), report); });
}

}  // namespace phymul::fuzz

// SPDX-License-Identifier: MIT
#include "scene_picture.h"

#include <phymul/camera.h>
#include <phymul/error.h>
#include <phymul/monitor.h>
#include <phymul/shapes.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "canvas.h"
#include "raster.h"
#include "tool_mesh.h"

namespace {

using phymul::Colour;
using phymul::Index;
using phymul::Vec3;
using phymul::VecList;

constexpr int top_margin = 80, bottom_margin = 60, side_margin = 30, bar_margin = 130;  // pixels
constexpr Colour edge_colour{0.0, 0.0, 0.0, 0.22}, rest_colour{0.35, 0.35, 0.35, 0.7};
/// Faces that meet at less than about 45 degrees are taken for one curved surface.
constexpr double smooth = 0.7;

Vec3 normal_of(const Face& face, const VecList& x) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < face.corners.size(); ++k) {
    sum += x[face.corners[k]].cross(x[face.corners[(k + 1) % face.corners.size()]]);
  }
  return sum.stableNormalized();
}

/// The shortest turn from the z axis to a direction. Eigen's FromTwoVectors looks for the axis of half a turn by a
/// singular value decomposition, which takes longer to compile than the rest of this file.
phymul::Quaternion turn_from_z(const Vec3& direction) {
  const Vec3 d = direction.normalized();
  if (d.z() < -1.0 + 1e-12) return {0.0, -1.0, 0.0, 0.0};
  const double s = std::sqrt(2.0 * (1.0 + d.z()));
  return {0.5 * s, -d.y() / s, d.x() / s, 0.0};
}

constexpr double ball_radius = 0.055;  // of a particle, in spacings
constexpr double marked_ball = 1.25;   // times as large: held or driven

/// One picture: what is drawn into the raster.
class Sheet {
 public:
  Sheet(const phymul::Model& model, const BodySurface& surface, const VecList& x, const phymul::Camera& camera,
        int width, int height, double full_scale)
      : raster(camera, width, height),
        model_(model),
        surface_(surface),
        x_(x),
        full_scale_(full_scale),
        axes_(axes_of(camera)) {
    for (const Face& face : surface.faces) normals_.push_back(normal_of(face, x));
    faces_at_.resize(x.size());
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
      for (const Index i : surface.faces[f].corners) faces_at_[i].push_back(f);
    }
    for (const SurfaceEdge& edge : surface.edges) edge_ += (x[edge.ends[0]] - x[edge.ends[1]]).norm();
    edge_ /= static_cast<double>(std::max<std::size_t>(surface.edges.size(), 1));
  }

  Raster raster;

  void add_faces(double opacity) {
    for (std::size_t f = 0; f < surface_.faces.size(); ++f) {
      const std::vector<Index>& ring = surface_.faces[f].corners;
      for (std::size_t k = 2; k < ring.size(); ++k) {
        raster.triangle({corner(ring[0], f), corner(ring[k - 1], f), corner(ring[k], f)}, 0.0, opacity);
      }
    }
  }

  /// Particles as balls, links as rods, attractors as small balls.
  void add_inside(const ScenePictureOptions& options) {
    const double radius = ball_radius * mean_spacing(model_);
    for (Index i = 0; i < model_.particle_count(); ++i) {
      const bool held = std::ranges::count(options.held, i) > 0, driven = std::ranges::count(options.driven, i) > 0;
      const Colour colour = held ? held_colour : driven ? driven_colour : colour_at(moved(i));
      add_ball(x_[i], (held || driven ? marked_ball : 1.0) * radius, colour);
      for (const Index* j = model_.neighbours.begin(i); j != model_.neighbours.end(i); ++j) {
        if (i < *j) add_rod(x_[i], x_[*j], 0.4 * radius, colour_at(0.5 * (moved(i) + moved(*j))));
      }
      if (options.attractors.empty()) continue;
      add_ball(options.attractors[i], 0.6 * radius, attractor_colour);
      raster.line(x_[i], options.attractors[i], attractor_colour, 2.0, 0.0);
    }
  }

  void add_edges(const std::vector<char>& on_outline) {
    for (const auto& [ends, faces] : surface_.edges) {
      const Vec3 &a = x_[ends[0]], &b = x_[ends[1]];
      if (surface_.faces.empty()) {
        raster.line(a, b, colour_at(0.5 * (moved(ends[0]) + moved(ends[1]))), 1.2, 0.0);
      } else if (on_outline[ends[0]] && on_outline[ends[1]]) {
        raster.line(a, b, organ_colour, 2.4, 0.05 * edge_);
      } else {
        raster.line(a, b, edge_colour, 0.7, 0.03 * edge_);
      }
    }
  }

  /// The rest shape's contour, and its outline, over everything.
  void add_rest(const std::vector<char>& on_outline) {
    const VecList& rest = model_.rest;
    std::vector<Vec3> normals;
    for (const Face& face : surface_.faces) normals.push_back(normal_of(face, rest));
    for (const auto& [ends, faces] : surface_.edges) {
      const Vec3 &a = rest[ends[0]], &b = rest[ends[1]];
      const bool organ = on_outline[ends[0]] && on_outline[ends[1]];
      const bool open = faces[0] < 0 || faces[1] < 0;
      const auto sees = [&](int f) { return normals[f].dot(axes_.towards_eye) > 1e-9; };
      const bool contour = open || sees(faces[0]) != sees(faces[1]);
      if (organ || contour) raster.dashed_line(a, b, organ ? organ_colour : rest_colour, 1.2, 1e3, 4.0);
    }
  }

  void add_marks(const std::vector<Index>& particles, const std::vector<char>& on_surface, double metres_a_pixel,
                 const Colour& colour) {
    const Vec3 half = 2.5 * metres_a_pixel * axes_.right;
    for (const Index i : particles) {
      if (on_surface[i]) raster.line(x_[i] - half, x_[i] + half, colour, 5.0, 0.1 * edge_);
    }
  }

  void add_tool(const PictureTool& tool, double around) {
    for (const ToolTriangle& t : triangles_of(tool.shape, tool.pose, around)) {
      std::array<Raster::Corner, 3> corners;
      for (int k = 0; k < 3; ++k) corners[k] = {t.place[k], t.normal[k], tool.colour};
      raster.triangle(corners, 0.35);
    }
  }

 private:
  double moved(Index i) const { return (x_[i] - model_.rest[i]).norm(); }
  Colour colour_at(double displacement) const {
    return phymul::displacement_colour(full_scale_ > 0.0 ? std::min(displacement / full_scale_, 1.0) : 0.0);
  }
  void add_ball(const Vec3& at, double radius, const Colour& colour) {
    add_tool({phymul::Sphere{radius}, {.position = at}, colour, ""}, 0.0);
  }
  void add_rod(const Vec3& from, const Vec3& to, double radius, const Colour& colour) {
    const phymul::ToolPose pose{.position = from, .orientation = turn_from_z(to - from)};
    add_tool({phymul::Capsule{.radius = radius, .length = (to - from).norm()}, pose, colour, ""}, 0.0);
  }

  Raster::Corner corner(Index i, std::size_t face) const {
    Vec3 normal = Vec3::Zero();
    for (const std::size_t other : faces_at_[i]) {
      if (normals_[other].dot(normals_[face]) > smooth) normal += normals_[other];
    }
    return {x_[i], normal.stableNormalized(), colour_at(moved(i))};
  }

  const phymul::Model& model_;
  const BodySurface& surface_;
  const VecList& x_;
  const double full_scale_;  // m
  const phymul::CameraAxes axes_;
  std::vector<Vec3> normals_;                       // [faces]
  std::vector<std::vector<std::size_t>> faces_at_;  // [particles]
  double edge_ = 0.0;                               // m, mean
};

void draw_point(cairo_t* c, const Vec3& at, const PicturePoint& point) {
  cairo_set_source_rgb(c, point.colour[0], point.colour[1], point.colour[2]);
  cairo_new_path(c);
  if (point.cross) {
    cairo_set_line_width(c, 2.2);
    for (const double side : {-1.0, 1.0}) {
      cairo_move_to(c, at.x() - 6.0, at.y() - side * 6.0);
      cairo_line_to(c, at.x() + 6.0, at.y() + side * 6.0);
    }
    cairo_stroke(c);
    return;
  }
  cairo_arc(c, at.x(), at.y(), 4.5, 0.0, 6.2832);
  cairo_fill_preserve(c);
  cairo_set_source_rgb(c, 1, 1, 1);
  cairo_set_line_width(c, 1.3);
  cairo_stroke(c);
}

std::vector<KeyEntry> key_of(const ScenePictureOptions& options, bool deformed) {
  std::vector<KeyEntry> key;
  for (const PictureTool& tool : options.tools) {
    if (!tool.words.empty()) key.push_back({KeyEntry::Mark::ball, tool.colour, tool.words});
  }
  key.insert(key.end(), options.key.begin(), options.key.end());
  const KeyEntry::Mark mark = options.inside ? KeyEntry::Mark::ball : KeyEntry::Mark::square;
  if (!options.held.empty()) key.push_back({mark, held_colour, "held"});
  if (!options.driven.empty()) key.push_back({mark, driven_colour, "driven"});
  if (!options.attractors.empty()) key.push_back({mark, attractor_colour, "attractors"});
  if (deformed) key.push_back({KeyEntry::Mark::dashes, rest_colour, "at rest"});
  return key;
}

}  // namespace

ScenePictures::ScenePictures(const phymul::Model& model, std::vector<char> shown, const std::vector<Index>& outline)
    : model_(model), on_surface_(model.rest.size(), 0), on_outline_(model.rest.size(), 0) {
  if (shown.empty()) {
    surface_ = surface_of(model);
  } else {
    phymul::Model part;
    part.rest = model.rest;
    for (std::size_t c = 0; c < model.cells.size(); ++c) {
      if (shown[c]) part.cells.push_back(model.cells[c]);
    }
    surface_ = surface_of(part);
  }
  if (surface_.faces.empty()) on_surface_.assign(on_surface_.size(), 1);
  for (const Face& face : surface_.faces) {
    for (const Index i : face.corners) on_surface_[i] = 1;
  }
  for (const Index i : outline) on_outline_[i] = 1;
}

void ScenePictures::draw(const phymul::State& state, const ScenePictureOptions& options,
                         const std::string& path) const {
  if (state.position.size() != model_.rest.size() || !phymul::is_finite(state)) {
    throw phymul::Error(path + ": expected a state of the model with finite positions");
  }
  const int width = options.width - side_margin - bar_margin, height = options.height - top_margin - bottom_margin;
  VecList frame = options.frame;
  if (frame.empty()) {
    frame = model_.rest;
    frame.insert(frame.end(), state.position.begin(), state.position.end());
  }
  if (options.inside) {  // with the balls around the particles
    const double radius = marked_ball * ball_radius * mean_spacing(model_);
    for (std::size_t k = 0, count = frame.size(); k < count; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-radius, radius}) frame.emplace_back(frame[k] + side * Vec3::Unit(axis));
      }
    }
  }
  const double largest = displacement_norms(model_, state).max;
  const double full_scale = options.full_scale > 0.0 ? options.full_scale : largest;
  const bool deformed = largest > 1e-3 * full_scale;
  const Vec3 eye = model_.dimension == 2 ? Vec3(Vec3::UnitZ()) : options.eye;
  const phymul::Camera camera = phymul::framing(frame, eye, static_cast<double>(width) / height);
  const double scale = phymul::pixels_per_metre(camera, camera.target, height);

  Sheet sheet(model_, surface_, state.position, camera, width, height, full_scale);
  if (options.inside) {
    sheet.add_inside(options);
    sheet.add_faces(0.3);
  } else {
    sheet.add_faces(1.0);
    if (options.mesh) sheet.add_edges(on_outline_);
    sheet.add_marks(options.held, on_surface_, 1.0 / scale, held_colour);
    sheet.add_marks(options.driven, on_surface_, 1.0 / scale, driven_colour);
  }
  for (const PictureTool& tool : options.tools) sheet.add_tool(tool, 0.8 * body_size(model_));
  if (deformed) sheet.add_rest(on_outline_);

  Canvas canvas(options.width, options.height);
  canvas.put(sheet.raster.image(), side_margin, top_margin);
  for (const PicturePoint& point : options.points) {
    draw_point(canvas.cairo(), to_pixel(camera, point.place, width, height) + Vec3(side_margin, top_margin, 0.0),
               point);
  }
  draw_title(canvas.cairo(), side_margin, options.title, options.subtitle);
  draw_colour_bar(canvas.cairo(), options.width - bar_margin + 50.0, top_margin + 40.0, 260.0, full_scale);
  const double y = options.height - 24.0;
  const double end = draw_length_bar(canvas.cairo(), side_margin, y, 0.2 * options.width, scale);
  draw_key(canvas.cairo(), end + 75.0, y, key_of(options, deformed));
  canvas.save(path);
}

void draw_tissue(const phymul::Model& model, const phymul::State& state, const ScenePictureOptions& options,
                 const std::string& path) {
  const phymul::TissueSurface surface = tissue_surface(model);
  const phymul::Model visible = triangle_body(surface.at(model.rest), surface.triangles);
  phymul::State seen;
  seen.position = surface.at(state.position);
  seen.velocity.assign(seen.position.size(), Vec3::Zero());
  ScenePictures(visible).draw(seen, options, path);
}

std::vector<char> cells_beyond(const phymul::Model& model, const Vec3& point, const Vec3& normal) {
  std::vector<char> shown;
  for (const phymul::Cell& cell : model.cells) {
    Vec3 middle = Vec3::Zero();
    for (const Index i : cell.particles) middle += model.rest[i] / static_cast<double>(cell.particles.size());
    shown.push_back(normal.dot(middle - point) > 0.0 ? 1 : 0);
  }
  return shown;
}

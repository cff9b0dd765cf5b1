// SPDX-License-Identifier: MIT
#include "body_drawing.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/box_tree.h"
#include "model/group.h"

namespace phymul::gl {
namespace {

constexpr double reach = 4.0;           // of what is seen around the body, in its radii, before and behind it
constexpr double lift = 2e-3;           // of edges over their faces, in the body's radii
constexpr double particle_size = 0.08;  // radius of a ball in spacings
constexpr double mark_size = 1.25;      // of marks and attractors, in particles
constexpr double attractor_size = 0.6;  // the same
constexpr double link_size = 0.025;     // radius of a rod in spacings
constexpr float sharp_edge = 0.6f;      // cosine of the least angle between faces that shows at rest
constexpr float dash_length = 11.0f;    // pixels, with its gap

const Colour body_colour{0.66, 0.74, 0.84, 1.0};
const Colour particle_colour{0.30, 0.42, 0.58, 1.0};
const Colour link_colour{0.52, 0.56, 0.62, 1.0};
const Colour attractor_colour{0.74, 0.16, 0.52, 1.0};
const Colour line_colour{0.0, 0.0, 0.0, 1.0};
const Colour rest_colour{0.42, 0.42, 0.42, 1.0};

Eigen::Vector3f rgb(const Colour& colour) {
  return {static_cast<float>(colour[0]), static_cast<float>(colour[1]), static_cast<float>(colour[2])};
}

std::vector<Eigen::Vector3f> scale_colours() {
  std::vector<Eigen::Vector3f> colours;
  for (int k = 0; k <= 16; ++k) colours.push_back(rgb(displacement_colour(k / 16.0)));
  return colours;
}

/// To pixels from -1 to 1: x, y across the view, z between the planes. Column-major, as GL wants it.
Eigen::Matrix4d projection_of(const Camera& camera, double aspect, double near, double far) {
  Eigen::Matrix4d p = Eigen::Matrix4d::Zero();
  if (camera.view_angle > 0.0) {
    const double scale = 1.0 / std::tan(0.5 * camera.view_angle);
    p(0, 0) = scale / aspect;
    p(1, 1) = scale;
    p(2, 2) = -(far + near) / (far - near);
    p(2, 3) = -2.0 * far * near / (far - near);
    p(3, 2) = -1.0;
  } else {
    p(0, 0) = 2.0 / (camera.view_height * aspect);
    p(1, 1) = 2.0 / camera.view_height;
    p(2, 2) = -2.0 / (far - near);
    p(2, 3) = -(far + near) / (far - near);
    p(3, 3) = 1.0;
  }
  return p;
}

}  // namespace

void Drawing::use() {
  glUseProgram(program_.id());
  units_ = 0;
}

void Drawing::input(const std::string& name, const TextureView& texture) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + units_));
  glBindTexture(GL_TEXTURE_2D, texture.id);
  set(name.c_str(), units_++);
  set((name + "_log2").c_str(), texture.log2_width);
}

void Drawing::draw(std::size_t count) {
  // gl_VertexID is an int, and so is a count: beyond that many, another call would have to say where it starts.
  constexpr std::size_t most = 357'913'941;
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * std::min(count, most)));
}

struct BodyDrawing::Eye {
  Eigen::Matrix4f view, projection;
  Eigen::Vector4f place;  // of the eye, from the centre; w = 0: direction towards it
  bool parallel = false;
  double pixels_per_metre = 1.0;  // of the target, at the body's centre
  double pixel_size = 1.0;
  Eigen::Vector2f viewport;
  float displacement_scale = 0.0f;
};

BodyDrawing::BodyDrawing(const Model& model, const ShaderLibrary& library, const Skin* skin)
    : model_(model), library_(library), centre_(bounding_box(model.rest).center()), spacing_(mean_spacing(model)) {
  std::vector<Float4> rest;
  for (const Vec3& x : model.rest) {
    rest.push_back(float4(x - centre_));
    radius_ = std::max(radius_, (x - centre_).norm());
  }
  if (!(radius_ > 0.0)) radius_ = 1.0;
  if (!(spacing_ > 0.0)) spacing_ = 0.1 * radius_;
  rest_ = Texture::table(rest, "rest");
  still_ = Texture::table(std::vector<Float4>(model.rest.size(), Float4{}), "displacement at rest");
  no_list_ = Texture::table(std::vector<std::int32_t>{-1}, "no list");
  if (skin) carry(*skin);

  const DisplayLists lists = display_lists(model);
  face_count_ = lists.faces.size();
  edge_count_ = lists.edges.size();
  link_count_ = lists.links.size();
  if (face_count_ > 0) faces_ = Texture::table(lists.faces, "faces");
  if (link_count_ > 0) links_ = Texture::table(lists.links, "links");
  if (edge_count_ == 0) return;
  std::vector<Int2> ends;
  std::vector<Float4> normals;
  for (const SurfaceEdge& edge : lists.edges) {
    ends.push_back(edge.ends);
    for (const Vec3& normal : edge.normal) normals.push_back(float4(normal));
    edge_length_ += (model.rest[edge.ends[0]] - model.rest[edge.ends[1]]).norm() / static_cast<double>(edge_count_);
  }
  edges_ = Texture::table(ends, "edges");
  edge_normals_ = Texture::table(normals, "normals");
}

void BodyDrawing::carry(const Skin& skin) {
  std::vector<Int4> particles(2 * skin.size(), Int4{0, 0, 0, 0});
  std::vector<Float4> weights(2 * skin.size(), Float4{});
  for (std::size_t k = 0; k < skin.size(); ++k) {
    for (std::size_t e = 0; e < skin.particles(k).size(); ++e) {
      particles[2 * k + e / 4][e % 4] = skin.particles(k)[e];
      weights[2 * k + e / 4][e % 4] = static_cast<float>(skin.weights(k)[e]);
    }
  }
  carriers_ = Texture::table(particles, "particles of a skin");
  shares_ = Texture::table(weights, "weights of a skin");
}

BodyDrawing::Eye BodyDrawing::eye_of(const Camera& camera, const DisplayOptions& options,
                                     const Viewport& viewport) const {
  const CameraAxes axes = axes_of(camera);
  const Vec3 from_centre = camera.eye - centre_;
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.block<1, 3>(0, 0) = axes.right.transpose();
  view.block<1, 3>(1, 0) = axes.up.transpose();
  view.block<1, 3>(2, 0) = axes.towards_eye.transpose();
  view.block<3, 1>(0, 3) = -(view.block<3, 3>(0, 0) * from_centre);

  const double distance = axes.towards_eye.dot(from_centre);
  double near = camera.near_plane, far = camera.far_plane;
  if (near == 0.0 && far == 0.0) {
    near = distance - reach * radius_;
    far = distance + reach * radius_;
    if (camera.view_angle > 0.0) near = std::max(near, 0.01 * radius_);
    far = std::max(far, near + radius_);
  }
  const bool parallel = camera.view_angle == 0.0;
  if (parallel ? !(camera.view_height > 0.0) : !(camera.view_angle > 0.0 && camera.view_angle < std::numbers::pi)) {
    throw Error(ErrorCode::invalid_argument,
                "Display: expected a Camera::view_angle from 0 to below pi, and where it is 0 a view_height above 0");
  }
  if (!(far > near) || !(parallel || near > 0.0)) {
    throw Error(
        ErrorCode::invalid_argument,
        "Display: expected Camera::far_plane behind near_plane, and with a view_angle both in front of the eye");
  }
  if (!(options.surface_opacity >= 0.0 && options.surface_opacity <= 1.0)) {
    throw Error(ErrorCode::invalid_argument, "Display: expected DisplayOptions::surface_opacity from 0 to 1");
  }

  Eye eye;
  eye.parallel = parallel;
  eye.view = view.cast<float>();
  eye.projection =
      projection_of(camera, static_cast<double>(viewport.width) / viewport.height, near, far).cast<float>();
  const Vec3& place = eye.parallel ? axes.towards_eye : from_centre;
  eye.place << place.cast<float>(), eye.parallel ? 0.0f : 1.0f;
  eye.pixel_size = viewport.pixel_size;
  // Negative where the eye has passed the body's centre.
  eye.pixels_per_metre = std::abs(pixels_per_metre(camera, eye.parallel ? camera.target : centre_, viewport.height));
  eye.viewport = {static_cast<float>(viewport.width), static_cast<float>(viewport.height)};
  if (options.full_scale > 0.0) eye.displacement_scale = static_cast<float>(1.0 / options.full_scale);
  return eye;
}

Drawing& BodyDrawing::begin(Drawing& drawing, const char* name, const char* fragment) {
  if (!drawing) {
    ShaderRequest vertex{.files = {"display/display_body.glsl"}, .defines = {}};
    if (carriers_) vertex.defines.emplace_back("SKIN", 1);
    if (std::string_view(fragment) == "display/display_line.frag")
      vertex.files.emplace_back("display/display_line.glsl");
    vertex.files.emplace_back(name);
    drawing = Drawing(library_, vertex, {.files = {"display/display_colour.glsl", fragment}, .defines = {}});
    drawing.use();
    drawing.set("scale_colour", scale_colours());
    drawing.set("light", Eigen::Vector3f(-0.5f, 0.6f, 1.0f).normalized());  // from the upper left, behind the eye
  }
  drawing.use();
  return drawing;
}

void BodyDrawing::set_body(Drawing& drawing, const TextureView& displacement, const Eye& eye, const Colour& colour,
                           bool by_displacement) {
  drawing.input("rest", view_of(rest_));
  drawing.input("displacement", displacement);
  if (carriers_) {
    drawing.input("carriers", view_of(carriers_));
    drawing.input("shares", view_of(shares_));
  }
  drawing.set("view", eye.view);
  drawing.set("projection", eye.projection);
  drawing.set("parallel_rays", eye.parallel ? 1 : 0);
  drawing.set("displacement_scale", eye.displacement_scale);
  drawing.set("by_displacement", by_displacement && eye.displacement_scale > 0.0f ? 1 : 0);
  drawing.set("plain_colour", rgb(colour));
}

void BodyDrawing::set_line(Drawing& drawing, const Eye& eye, double half_width, double opacity) const {
  drawing.set("viewport", eye.viewport);
  drawing.set("half_width", static_cast<float>(std::max(half_width * eye.pixel_size, 0.7)));  // thinner ones break up
  drawing.set("lift", static_cast<float>(lift * radius_));
  drawing.set("opacity", static_cast<float>(opacity));
  drawing.set("dash", 0.0f);
  drawing.set("tube", 0);
}

void BodyDrawing::draw_surface(const Placement& placement, const DisplayOptions& options, const Eye& eye) {
  Drawing& drawing = begin(surface_, "display/display_surface.vert", "display/display_surface.frag");
  set_body(drawing, placement.displacement, eye, body_colour, true);
  drawing.input("faces", view_of(faces_));
  drawing.set("opacity", static_cast<float>(options.surface_opacity));
  if (options.surface_opacity >= 1.0) {
    drawing.draw(face_count_);
    return;
  }
  glDepthMask(GL_FALSE);
  glEnable(GL_CULL_FACE);
  for (const GLenum away : {GL_FRONT, GL_BACK}) {  // what is behind first
    glCullFace(away);
    drawing.draw(face_count_);
  }
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_TRUE);
}

/// Lines between the particles of `pairs`; null: between each particle and itself, by the second displacements.
Drawing& BodyDrawing::begin_pairs(const TextureView& displacement, const TextureView& second, const Texture* pairs,
                                  const Eye& eye, const Colour& colour, bool by_displacement) {
  Drawing& drawing = begin(pair_, "display/display_pair.vert", "display/display_line.frag");
  set_body(drawing, displacement, eye, colour, by_displacement);
  drawing.input("second_displacement", second);
  drawing.input("pairs", view_of(pairs ? *pairs : no_list_));
  drawing.set("paired", pairs ? 1 : 0);
  return drawing;
}

void BodyDrawing::draw_edges(const Placement& placement, const Eye& eye) {
  Drawing& drawing = begin_pairs(placement.displacement, placement.displacement, &edges_, eye, line_colour, false);
  // A fine mesh would be all lines.
  const double strength = 0.45 * std::min(1.0, eye.pixels_per_metre * edge_length_ / eye.pixel_size / 15.0);
  set_line(drawing, eye, 0.55, strength);
  drawing.draw(edge_count_);
}

void BodyDrawing::draw_links(const Placement& placement, const Eye& eye) {
  Drawing& drawing = begin_pairs(placement.displacement, placement.displacement, &links_, eye, link_colour, true);
  const double rod = link_size * spacing_ * eye.pixels_per_metre / eye.pixel_size;
  set_line(drawing, eye, std::clamp(rod, 0.6, 6.0), 1.0);
  drawing.set("tube", 1);
  drawing.set("lift", 0.0f);
  drawing.draw(link_count_);
}

void BodyDrawing::draw_attractors(const Placement& placement, const DisplayOptions& options, const Eye& eye) {
  Drawing& drawing = begin_pairs(placement.displacement, placement.attractor, nullptr, eye, attractor_colour, false);
  set_line(drawing, eye, 1.1, 1.0);
  drawing.draw(model_.rest.size());
  draw_balls(placement.attractor, nullptr, model_.rest.size(), attractor_size * ball_radius(options), attractor_colour,
             false, eye);
}

double BodyDrawing::ball_radius(const DisplayOptions& options) const {
  return options.particle_radius > 0.0 ? options.particle_radius : particle_size * spacing_;
}

void BodyDrawing::draw_balls(const TextureView& displacement, const Texture* list, std::size_t count, double radius,
                             const Colour& colour, bool by_displacement, const Eye& eye) {
  if (count == 0) return;
  Drawing& drawing = begin(ball_, "display/display_ball.vert", "display/display_ball.frag");
  set_body(drawing, displacement, eye, colour, by_displacement);
  const double least = 1.5 * eye.pixel_size / eye.pixels_per_metre;  // pixels
  drawing.set("radius", static_cast<float>(std::max(radius, least)));
  drawing.input("list", view_of(list ? *list : no_list_));
  drawing.set("listed", list ? 1 : 0);
  drawing.draw(count);
}

void BodyDrawing::draw_marks(const Placement& placement, const DisplayOptions& options, const Eye& eye) {
  for (const DisplayMark& mark : options.marks) {
    if (mark.particles.empty()) continue;
    require_indices(mark.particles, model_.rest.size(), "particles",
                    [] { return std::string("DisplayOptions::marks: "); });
    const Texture list = Texture::table(mark.particles, "marks");
    draw_balls(placement.displacement, &list, mark.particles.size(), mark_size * ball_radius(options), mark.colour,
               false, eye);
  }
}

void BodyDrawing::draw_rest_shape(const Eye& eye, double opacity) {
  Drawing& drawing = begin(contour_, "display/display_contour.vert", "display/display_line.frag");
  set_body(drawing, view_of(still_), eye, rest_colour, false);
  set_line(drawing, eye, 0.8, opacity);
  drawing.set("dash", static_cast<float>(dash_length * eye.pixel_size));
  drawing.set("sharp", sharp_edge);
  drawing.set("eye", eye.place);
  drawing.input("pairs", view_of(edges_));
  drawing.input("normals", view_of(edge_normals_));
  drawing.draw(edge_count_);
}

void BodyDrawing::draw(const Placement& placement, const Camera& camera, const DisplayOptions& options,
                       const Viewport& viewport) {
  const Eye eye = eye_of(camera, options, viewport);
  glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
  glScissor(viewport.x, viewport.y, viewport.width, viewport.height);
  glEnable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_CULL_FACE);
  const Colour& background = options.background;
  glClearColor(static_cast<float>(background[0]), static_cast<float>(background[1]), static_cast<float>(background[2]),
               static_cast<float>(background[3]));
  glFrontFace(GL_CCW);
  const GLfloat farthest = 1.0f;  // a host may clear to another depth; this leaves its own value alone
  glClear(GL_COLOR_BUFFER_BIT);
  glClearBufferfv(GL_DEPTH, 0, &farthest);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);

  // What hides first, then what lets through: blending needs what is behind.
  const bool solid = options.surface && face_count_ > 0 && options.surface_opacity >= 1.0;
  if (solid) draw_surface(placement, options, eye);
  if (options.links && link_count_ > 0) draw_links(placement, eye);
  if (options.particles) {
    draw_balls(placement.displacement, nullptr, model_.rest.size(), ball_radius(options), particle_colour, true, eye);
  }
  draw_marks(placement, options, eye);
  if (options.attractors && placement.attractor.id != 0) draw_attractors(placement, options, eye);
  if (options.surface && face_count_ > 0 && !solid) draw_surface(placement, options, eye);
  if (options.edges && edge_count_ > 0) draw_edges(placement, eye);
  if (options.rest_shape && edge_count_ > 0) {
    draw_rest_shape(eye, 0.9);
    glDisable(GL_DEPTH_TEST);  // the part behind the body, faintly
    draw_rest_shape(eye, 0.3);
  }
}

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
//
// BodyDrawing: the layers of DisplayOptions, drawn into the framebuffer bound at the time. Constant tables of one body
// on the device, and a program per layer, made when a layer is first asked for.
#pragma once

#include <phymul/display.h>
#include <phymul/skin.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "gl/objects/program.h"
#include "gl/objects/texture.h"
#include "view/display_lists.h"

namespace phymul::gl {

/// A texture by name, which a solver may own; rows as in Texture::table.
struct TextureView {
  GLuint id = 0;
  int log2_width = 0;
};

inline TextureView view_of(const Texture& texture) {
  return {texture.id(), texture.log2_width()};
}

/// A program that draws triangles out of tables in textures, without vertex attributes.
class Drawing {
 public:
  Drawing() = default;
  Drawing(const ShaderLibrary& library, const ShaderRequest& vertex, const ShaderRequest& fragment)
      : program_(library, vertex, fragment) {}

  explicit operator bool() const { return program_.id() != 0; }

  /// Before set, input and draw.
  void use();

  void set(const char* name, int value) { glUniform1i(program_.uniform(name), value); }
  void set(const char* name, float value) { glUniform1f(program_.uniform(name), value); }
  void set(const char* name, const Eigen::Vector2f& value) { glUniform2fv(program_.uniform(name), 1, value.data()); }
  void set(const char* name, const Eigen::Vector3f& value) { glUniform3fv(program_.uniform(name), 1, value.data()); }
  void set(const char* name, const Eigen::Vector4f& value) { glUniform4fv(program_.uniform(name), 1, value.data()); }
  void set(const char* name, const Eigen::Matrix4f& value) {
    glUniformMatrix4fv(program_.uniform(name), 1, GL_FALSE, value.data());
  }
  void set(const char* name, const std::vector<Eigen::Vector3f>& values) {
    glUniform3fv(program_.uniform(name), static_cast<GLsizei>(values.size()), values.front().data());
  }

  /// The texture behind sampler `name`, and `name`_log2 that finds a row in it.
  void input(const std::string& name, const TextureView& texture);

  /// `count` things of six vertices each: two triangles. A vertex array must be bound.
  void draw(std::size_t count);

 private:
  Program program_;
  int units_ = 0;  // bound since use()
};

/// Where the particles are: textures of displacements from the rest shape, m. Attractors only where they are shown.
struct Placement {
  TextureView displacement;
  TextureView attractor;
};

struct Viewport {
  int x = 0, y = 0, width = 0, height = 0;  ///< pixels, from the lower left
  double pixel_size = 1.0;                  ///< pixels of the target per pixel of the picture that is to come of it
};

class BodyDrawing {
 public:
  /// The model must outlive it. With a skin the model is its surface, and Placement is of the body that carries it.
  BodyDrawing(const Model& model, const ShaderLibrary& library, const Skin* skin = nullptr);

  /// Clears the rectangle and draws. Changes program, textures, viewport, scissor, depth, blending and culling.
  void draw(const Placement& placement, const Camera& camera, const DisplayOptions& options, const Viewport& viewport);

 private:
  struct Eye;  ///< matrices and lengths of one call
  Eye eye_of(const Camera& camera, const DisplayOptions& options, const Viewport& viewport) const;
  void carry(const Skin& skin);
  Drawing& begin(Drawing& drawing, const char* name, const char* fragment);
  Drawing& begin_pairs(const TextureView& displacement, const TextureView& second, const Texture* pairs, const Eye& eye,
                       const Colour& colour, bool by_displacement);
  void set_body(Drawing& drawing, const TextureView& displacement, const Eye& eye, const Colour& colour,
                bool by_displacement);
  void set_line(Drawing& drawing, const Eye& eye, double half_width, double opacity) const;

  double ball_radius(const DisplayOptions& options) const;
  void draw_surface(const Placement& placement, const DisplayOptions& options, const Eye& eye);
  void draw_edges(const Placement& placement, const Eye& eye);
  void draw_links(const Placement& placement, const Eye& eye);
  void draw_attractors(const Placement& placement, const DisplayOptions& options, const Eye& eye);
  void draw_balls(const TextureView& displacement, const Texture* list, std::size_t count, double radius,
                  const Colour& colour, bool by_displacement, const Eye& eye);
  void draw_marks(const Placement& placement, const DisplayOptions& options, const Eye& eye);
  void draw_rest_shape(const Eye& eye, double opacity);

  const Model& model_;
  const ShaderLibrary library_;
  Vec3 centre_;               // of the rest shape, m
  double radius_ = 0.0;       // of a sphere around the rest shape, m
  double spacing_ = 0.0;      // m
  double edge_length_ = 0.0;  // mean, of the surface's edges, m
  std::size_t face_count_ = 0, edge_count_ = 0, link_count_ = 0;
  Texture rest_, faces_, edges_, edge_normals_, links_;
  Texture carriers_, shares_;  // of a skin: two texels a point, particles and their weights
  Texture still_;              // displacements of the rest shape
  Texture no_list_;  // stands in for a list that a shader does not look at: each sampler needs a texture of its kind
  Drawing surface_, pair_, contour_, ball_;
};

/// As phymul::make_display. `solver` null: the positions are given by show(). `skin` null: the body itself is shown.
std::unique_ptr<Display> make_display(const Model& model, const Solver* solver, std::shared_ptr<const VisibleSkin> skin,
                                      const GlOptions& options);

}  // namespace phymul::gl

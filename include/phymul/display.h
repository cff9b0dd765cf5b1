// SPDX-License-Identifier: MIT
//
// Display: draws a body with OpenGL, to a picture in memory or into a window of the host. If zero_copy(), the vertex
// shader reads the displacements in the texture of the GL solver, and no position leaves the device. Otherwise the
// positions are uploaded for each picture.
#pragma once

#include <phymul/camera.h>
#include <phymul/gl.h>
#include <phymul/skin.h>
#include <phymul/solver.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace phymul {

/// Rows from top to bottom, four bytes a pixel: red, green, blue, alpha.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;

  const std::uint8_t* pixel(int x, int y) const { return &rgba[4 * (std::size_t(y) * std::size_t(width) + x)]; }
};

/// Colour of a displacement over the largest one shown, clamped to [0, 1]: from nearly white over blue to dark purple.
/// Even steps look even, also to the colour-blind and in grey print, and a body at rest shows its shape.
Colour displacement_colour(double share);

/// Particles to be marked, such as held or driven ones.
struct DisplayMark {
  std::vector<Index> particles;
  Colour colour{0, 0, 0, 1};
};

struct DisplayOptions {
  bool surface = true;           ///< outer faces, lit; of a plane body its cells
  double surface_opacity = 1.0;  ///< [0, 1]; below 1 the inside shows through
  bool edges = true;             ///< of the outer faces
  bool links = false;            ///< between neighbours
  bool particles = false;        ///< as balls
  bool attractors = false;       ///< P* as small balls, with a line from each particle to its own, along its force
  bool rest_shape = false;       ///< contour and sharp edges of the rest shape, dashed
  double full_scale = 0.0;       ///< m, displacement at the end of the colour scale; 0: one colour for all
  double particle_radius = 0.0;  ///< m; 0: 0.08 of the mean spacing
  Colour background{1, 1, 1, 1};
  std::vector<DisplayMark> marks{};  ///< drawn as balls, a little larger than particles
};

/// Throws Error if a context, a shader or memory fails, as the GL backends do. Not thread-safe.
class Display {
 public:
  virtual ~Display() = default;
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  /// An antialiased picture of the present state. Waits for the device. Throws Error for a size below 1 x 1 or above
  /// what the driver supports, and, as draw() does, for a camera without a view: a view_angle below 0 or of pi and
  /// more, a far plane not beyond the near one, with a view_angle the near plane not in front of the eye, without one
  /// no view_height.
  virtual Image render(const Camera& camera, const DisplayOptions& options, int width, int height) = 0;

  /// Draws into a rectangle of the framebuffer that the caller has bound. Pixels count from its lower left corner.
  /// Overwrites colour and depth there. Throws Error unless the display was made with GlContext::current.
  virtual void draw(const Camera& camera, const DisplayOptions& options, int x, int y, int width, int height) = 0;

  /// Shows these positions, [N] m, from now on; attractors [N] m or empty. Throws Error for other sizes, and if the
  /// display was made for a solver, whose particles it shows.
  virtual void show(std::span<const Vec3> position, std::span<const Vec3> attractor = {}) = 0;

  /// True if the particles are drawn from the texture of the solver.
  virtual bool zero_copy() const = 0;

  virtual std::string device() const = 0;  ///< the renderer, by its own name

 protected:
  Display() = default;
};

/// A display of the solver's state at each call, with what cuts and removed cells have left; the solver must outlive
/// it. With GlContext::own it draws in the context of a GL solver, otherwise in one of its own. With GlContext::current
/// it draws in the context of the caller, without a copy if the solver uses that context or one that shares objects
/// with it. Throws Error if GL is missing.
std::unique_ptr<Display> make_display(const Solver& solver, const GlOptions& gl = {});

/// A display of a skin instead of the body itself: of these triangles of points of the skin (counter-clockwise seen
/// from outside). The vertex shader moves them with the particles of the solver. In DisplayOptions, particles are then
/// the points and links the edges of triangles; there are no attractors. Copies the skin. Throws Error for an empty
/// skin, for a triangle of a missing point, and for a skin of another body (Skin::is_bound_to).
std::unique_ptr<Display> make_display(const Solver& solver, const Skin& skin,
                                      std::span<const std::array<Index, 3>> triangles, const GlOptions& gl = {});

/// A display of the positions given to show(), at first of the rest shape. The model must outlive it.
std::unique_ptr<Display> make_display(const Model& model, const GlOptions& gl = {});

}  // namespace phymul

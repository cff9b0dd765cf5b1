// SPDX-License-Identifier: MIT
//
// Display: draws a body with OpenGL, to a picture in memory or into a host's window. What a GL backend computed is
// drawn from the texture it lies in: the vertex shader fetches each particle's displacement there, and no position ever
// leaves the device. The positions of other backends are uploaded for each picture.
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

/// The scale of displacements, share in [0, 1] of the largest one shown: from nearly white over blue to dark purple.
/// Even steps look even, also to the colour-blind and in grey print, and a body at rest shows its shape.
Colour displacement_colour(double share);

/// Particles to be marked, such as held or driven ones.
struct DisplayMark {
  std::vector<Index> particles;
  Colour colour{0, 0, 0, 1};
};

struct DisplayOptions {
  bool surface = true;           ///< outer faces, lit; of a plane body its cells
  double surface_opacity = 1.0;  ///< below 1 what is inside shows through
  bool edges = true;             ///< of the outer faces
  bool links = false;            ///< between neighbours
  bool particles = false;        ///< as balls
  bool attractors = false;       ///< P* as small balls, and a line from each particle to its own: the way of its force
  bool rest_shape = false;       ///< contour and sharp edges of the rest shape, dashed
  double full_scale = 0.0;       ///< m, displacement at the end of the colour scale; 0: one colour for all
  double particle_radius = 0.0;  ///< m; 0: 0.08 of the mean spacing
  Colour background{1, 1, 1, 1};
  std::vector<DisplayMark> marks{};  ///< drawn as balls, a little larger than particles
};

/// Throws Error where a context, a shader or memory fails, as the GL backends do. Not thread-safe.
class Display {
 public:
  virtual ~Display() = default;
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  /// An antialiased picture of the present state. Waits for the device.
  virtual Image render(const Camera& camera, const DisplayOptions& options, int width, int height) = 0;

  /// Draws into a rectangle of the framebuffer that the caller has bound, pixels from its lower left corner; overwrites
  /// colour and depth there. Only where the display was made with GlContext::current.
  virtual void draw(const Camera& camera, const DisplayOptions& options, int x, int y, int width, int height) = 0;

  /// Shows these positions, [N] m, from now on; attractors [N] or empty. Throws Error where the display was made for a
  /// solver, whose particles it shows.
  virtual void show(std::span<const Vec3> position, std::span<const Vec3> attractor = {}) = 0;

  /// True where the particles are drawn from the solver's own texture.
  virtual bool zero_copy() const = 0;

  virtual std::string device() const = 0;  ///< the renderer, by its own name

 protected:
  Display() = default;
};

/// A display of what the solver holds at each call; the solver must outlive it. With GlContext::own it draws in the
/// context of a GL solver, and in one of its own otherwise. With GlContext::current it draws in the caller's, and
/// without a copy where the solver runs in that one or shares objects with it. Throws Error where GL is missing.
std::unique_ptr<Display> make_display(const Solver& solver, const GlOptions& gl = {});

/// A display of a skin instead of the body itself: of these triangles of the skin's points (counter-clockwise seen from
/// outside), which the vertex shader moves with the solver's particles. What DisplayOptions says of particles is then
/// meant of the points; links are edges of triangles, and there are no attractors. The skin is copied. Throws Error for
/// a triangle of a point that there is not and for a skin of another body.
std::unique_ptr<Display> make_display(const Solver& solver, const Skin& skin,
                                      std::span<const std::array<Index, 3>> triangles, const GlOptions& gl = {});

/// A display of positions given by show(); the rest shape at first. The model must outlive it.
std::unique_ptr<Display> make_display(const Model& model, const GlOptions& gl = {});

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// An organ on a page: a body that fills a surface, a hand that pulls it, and its picture.
#pragma once

#include <phymul/body.h>
#include <phymul/camera.h>
#include <phymul/display.h>
#include <phymul/scene.h>
#include <phymul/skin.h>
#include <phymul/solver.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

/// The tissue of every body of the page.
phymul::Material organ_tissue();

/// Fills a surface and gives it the tissue.
phymul::Model organ_body(const phymul::Surface& surface, double spacing);

/// Particles in the lowest fifth of the body, which stands on them.
std::vector<phymul::Index> organ_foot(const phymul::Model& model);

/// Particles that a hand takes at a place of the rest shape: those within `reach`, m, but none of the foot.
std::vector<phymul::Index> organ_patch(const phymul::Model& model, const phymul::Vec3& place, double reach);

/// Imposes one displacement, m, on the particles, reached between two times, s: a load for each axis.
std::vector<phymul::Load> organ_pull(const std::vector<phymul::Index>& particles, const phymul::Vec3& from,
                                     const phymul::Vec3& to, double start, double end);

/// What a hand does, or did last, to a body of any spacing.
struct Pull {
  phymul::Vec3 place{0, 0, 0};         ///< m, taken there, in the rest shape
  phymul::Vec3 displacement{0, 0, 0};  ///< m, from there
  double reach = 0.0;                  ///< m, of the hand around the place
};

class Organ {
 public:
  /// Draws in the WebGL context that is current. Throws Error as what it calls does.
  Organ(std::shared_ptr<const phymul::Surface> surface, double spacing, const std::string& backend);

  void use(const std::string& backend);  ///< the state continues there
  void reset();

  /// Simulates at most `wall_time`, s, and less where the machine is slower than that.
  void advance(double wall_time);
  void draw(int width, int height);

  void turn(double right, double up);  ///< rad, the eye around the body
  void zoom(double factor);

  bool take(double x, double y, int width, int height);  ///< the body under a pixel; false: there is none
  void move(double x, double y, int width, int height);
  void release();
  bool holds() const { return held_.has_value(); }
  const Pull& last_pull() const { return pull_; }

  const phymul::Solver& solver() const { return *solver_; }
  const phymul::Model& model() const { return *model_; }
  const std::string& failure() const { return failure_; }
  double time() const { return time_; }              ///< s
  double steps_per_second() const { return rate_; }  ///< of the last half second
  double speed() const { return rate_ * dt_; }       ///< simulated seconds in a second
  double largest_displacement() const;               ///< m, of a point of the surface

 private:
  phymul::Camera camera(int width, int height) const;
  void make_display();
  void count(int steps, double wall_time);

  std::shared_ptr<const phymul::Surface> surface_;
  std::unique_ptr<const phymul::Model> model_;
  phymul::Scene scene_;
  phymul::Skin skin_;
  std::shared_ptr<const phymul::TopologyTextures> topology_;
  phymul::Spectrum spectrum_;
  std::unique_ptr<phymul::Solver> solver_;
  std::unique_ptr<phymul::Display> display_;  // looks at the solver
  double dt_ = 0.0, time_ = 0.0, owed_ = 0.0;
  double rate_ = 0.0, counted_time_ = 0.0;
  int counted_steps_ = 0;
  std::string failure_;

  double turned_ = -1.1, raised_ = 0.35, zoom_ = 1.0;  // rad, rad, 1
  Pull pull_;
  struct Held {
    std::vector<phymul::Index> particles;
    std::size_t first_row = 0;     // of its loads
    double depth = 0.0;            // m, from the eye
    phymul::Vec3 offset{0, 0, 0};  // m, from the place under the mouse to the displacement
  };
  std::optional<Held> held_;
};

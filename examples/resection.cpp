// SPDX-License-Identifier: MIT
//
// resection [--out DIR] [--quick]: two strokes of a scalpel cut a wedge out of the left lobe of a liver; a grasper
// lifts it, and it is removed. Writes the forces on the scalpel and the grasper (resection.csv), and pictures.
#include <phymul/bodies.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "example_run.h"
#include "liver_shape.h"
#include "scene_picture.h"

namespace {

using phymul::Index;
using phymul::Vec3;

// m; x to the patient's right, y to the front, z to the head (RAS).
const Vec3 apex(-0.085, 0.012, 0.018), front(-0.085, 0.042, 0.018);
constexpr double half_angle = 0.6, stroke = 0.065, beyond = 0.020;  // rad, m; beyond the apex, so that the cuts cross
constexpr double tick = 2e-3;                                       // s
const phymul::Blade blade{.width = 0.08, .toughness = 8.0};

/// The edge stands along z and goes toward the apex; `side`: -1, 1.
phymul::ToolPose scalpel_at(double side, double way) {
  const Vec3 forward(-side * std::sin(half_angle), -std::cos(half_angle), 0.0);
  phymul::Mat3 axes;
  axes.col(0) = Vec3::UnitZ();
  axes.col(2) = -forward;
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {.position = apex + (way - stroke) * forward, .orientation = phymul::Quaternion(Eigen::Quaterniond(axes))};
}

class Pictures {
 public:
  Pictures(const phymul::Simulation& sim, const ExampleOptions& options) : sim_(sim), options_(options) {
    sheet_.full_scale = 0.02;
    sheet_.eye = Vec3(-0.55, 1.0, 0.9);
    sheet_.mesh = false;
    sheet_.frame = sim.model().rest;
    sheet_.frame.push_back(front + Vec3(0, 0.03, 0.08));
  }

  void draw(const std::string& title, const std::string& subtitle, std::vector<PictureTool> tools, const char* file) {
    sheet_.title = title;
    sheet_.subtitle = subtitle;
    sheet_.tools = std::move(tools);
    draw_tissue(sim_.model(), sim_.state(), sheet_, options_.file(file));
  }

 private:
  const phymul::Simulation& sim_;
  const ExampleOptions& options_;
  ScenePictureOptions sheet_;
};

void run(const ExampleOptions& options) {
  phymul::Model model = make_body(liver(), {.spacing = 0.010});
  set_material(model, {.young = 4e3, .poisson = 0.45, .density = 1060});
  std::vector<Index> bare;  // grown to the diaphragm behind and above
  for (const Index i : model.group("surface")) {
    if (model.rest[i].y() < -0.02 && model.rest[i].z() > 0.0) bare.push_back(i);
  }
  phymul::Simulation sim(with_spare_particles(std::move(model), 600),
                         {.backend = "cpu", .damping = {.rate = 40.0}, .solver = {.threads = 1}});
  sim.scene().attach(bare, phymul::World{}, {.stiffness = 2e6, .damping = 2e3, .name = "diaphragm"});
  std::printf("%zu particles, 600 of them spare\n", sim.model().rest.size());
  Pictures pictures(sim, options);
  Curve curve(options.file("resection.csv"), "time_s,scalpel_N,grasper_N");

  // It holds the wedge to be against the scalpel.
  const phymul::Sphere jaw{0.006};
  const auto grasper = sim.scene().add_tool("grasper", {.shape = jaw, .pose = {.position = front}});
  grasper.grasp(0.006);
  double hardest = 0.0;
  const double speed = options.quick ? 0.2 : 0.05;  // m/s
  for (const double side : {-1.0, 1.0}) {
    const auto scalpel = sim.scene().add_tool("scalpel", {.shape = blade, .pose = scalpel_at(side, 0.0)});
    for (double way = 0.0; way < stroke + beyond;) {
      way += speed * tick;
      scalpel.move_to(scalpel_at(side, way));
      const double time = advance(sim, tick);
      const double force = sim.force_on(scalpel).mean_force.norm();
      hardest = std::max(hardest, force);
      curve.add({time, force, 0.0});
      if (side < 0.0 || way < 0.6 * stroke || way >= 0.6 * stroke + speed * tick) continue;
      pictures.draw("1. The second stroke of a scalpel through the left lobe", text("%.2f N on it; 8 J/m^2", force),
                    {{blade, sim.pose_of(scalpel), needle_colour, "scalpel"},
                     {jaw, sim.pose_of(grasper), probe_colour, "grasper"}},
                    "resection_1.png");
    }
    sim.scene().remove_tool("scalpel");
  }
  std::vector<phymul::ConnectedBody> pieces = connected_bodies(sim.model());
  std::ranges::sort(pieces, std::greater<>(), &phymul::ConnectedBody::volume);
  require(pieces.size() >= 2 && pieces[1].volume > 1e-5, "the wedge is not free");
  const phymul::ConnectedBody wedge = pieces[1];
  for (std::size_t k = 2; k < pieces.size(); ++k) {  // crumbs of single cells
    require(pieces[k].volume < 1e-8, "another piece");
    sim.remove_cells(pieces[k].cells);
  }
  const Vec3 lift(0.0, 0.025, 0.065);
  const double duration = options.quick ? 0.3 : 1.0;  // s
  for (double time = 0.0; time < 1.3 * duration; time += tick) {
    grasper.move_to({.position = front + std::min(time / duration, 1.0) * lift});
    const double now = advance(sim, tick);
    curve.add({now, 0.0, sim.force_on(grasper).mean_force.norm()});
  }
  Vec3 moved = Vec3::Zero();
  for (const Index i : wedge.particles) {
    moved += (sim.state().position[i] - sim.model().rest[i]) / static_cast<double>(wedge.particles.size());
  }
  pictures.draw("2. The wedge is lifted out",
                text("%.1f ml of %.0f", 1e6 * wedge.volume, 1e6 * (pieces[0].volume + pieces[1].volume)),
                {{jaw, sim.pose_of(grasper), probe_colour, "grasper"}}, "resection_2.png");

  sim.scene().remove_tool("grasper");
  sim.remove_cells(wedge.cells);
  for (double time = 0.0; time < 0.4 * duration; time += tick) advance(sim, tick);
  pictures.draw("3. It is removed", "the notch with the faces of both cuts", {}, "resection_3.png");
  std::printf("%.1f ml of %.0f; at most %.2f N on the scalpel; lifted by %.1f mm\n", 1e6 * wedge.volume,
              1e6 * (pieces[0].volume + pieces[1].volume), hardest, 1e3 * moved.norm());
  require((moved - lift).norm() < 0.1 * lift.norm(), "the wedge does not follow the grasper");
  require(connected_bodies(sim.model()).size() == 1, "something is left of the wedge");
}

}  // namespace

int main(int argc, char** argv) {
  return run_example(argc, argv, "A wedge of a liver is cut out, lifted and removed: forces as CSV, and pictures.",
                     run);
}

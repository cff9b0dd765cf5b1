// SPDX-License-Identifier: MIT
//
// A suture: a half circle of a needle goes through both edges of a wound, is let go and taken again on the way, and
// draws a thread, which is pulled and tied. Writes suture_1.svg to suture_3.svg: sections of tissue, needle and thread.
#include <phymul/phymul.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>

namespace {

using phymul::Vec3;

constexpr double arc = 0.008, top = 0.01, middle = 0.006, gap = 0.004;  // m

phymul::Model edge(double x) {
  return phymul::moved(phymul::make_block({0.016, 2 * middle, top}, 8, 6, 5), {x, 0, 0});
}

/// So far round the circle, rad, from where the tip touches the skin, 7 mm from the middle.
phymul::ToolPose pose_at(double angle) {
  const double above = std::sqrt(arc * arc - 0.007 * 0.007), at = std::asin(above / arc) + angle;
  return {.position = Vec3(0, middle, top + above) - arc * Vec3(std::cos(at), 0, std::sin(at)),
          .orientation = phymul::Quaternion(Eigen::AngleAxisd(-at, Vec3::UnitY()))};
}

/// N against going in, along the circle.
double resistance(const phymul::ToolForce& force, const phymul::ToolPose& at) {
  const Vec3 to_centre = arc * (at.orientation * Vec3::UnitX());
  return (force.mean_torque - to_centre.cross(force.mean_force)).dot(at.orientation * Vec3::UnitY()) / arc;
}

class Section {
 public:
  Section(const std::string& path, const phymul::Simulation& sim) : out_(path), sim_(sim) {
    out_ << "<svg xmlns='http://www.w3.org/2000/svg' width='800' height='500' viewBox='-20 -20 40 25'>\n"
         << "<rect x='-20' y='-20' width='40' height='25' fill='white'/>\n";
  }
  ~Section() { out_ << "</svg>\n"; }
  void line(const phymul::VecList& points, const char* colour, double width) {
    out_ << "<polyline fill='none' stroke='" << colour << "' stroke-width='" << width << "' points='";
    for (const Vec3& x : points) out_ << 1e3 * x.x() << ',' << -1e3 * x.z() << ' ';
    out_ << "'/>\n";
  }
  /// Lines of the mesh in the plane of the needle.
  void tissue() {
    const phymul::VecList &rest = sim_.model().rest, now = sim_.state().position;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      for (std::size_t j = i + 1; j < rest.size() && std::abs(rest[i].y() - middle) < 1e-4; ++j) {
        if (std::abs((rest[i] - rest[j]).norm() - 0.002) < 1e-6 && std::abs(rest[j].y() - middle) < 1e-4) {
          line({now[i], now[j]}, "#c0605a", 0.1);
        }
      }
    }
  }

 private:
  std::ofstream out_;
  const phymul::Simulation& sim_;
};

}  // namespace

int main() try {
  const phymul::Model left = edge(-0.016 - 0.5 * gap), right = edge(0.5 * gap);
  const std::array<phymul::NamedBody, 2> both{{{"left", &left}, {"right", &right}}};
  phymul::Simulation sim(phymul::merge_models(both),
                         {.material = {.young = 20e3, .poisson = 0.45, .density = 1000}, .damping = {.rate = 40}});
  phymul::Scene& scene = sim.scene();
  scene.fix("left/x0").fix("right/x1");

  const phymul::Needle half_circle{.length = std::numbers::pi * arc,
                                   .radius = 0.3e-3,
                                   .puncture = 0.04,
                                   .cutting = 0.015,
                                   .static_friction = 2.0,
                                   .kinetic_friction = 1.5,
                                   .spread = 0.003,
                                   .arc_radius = arc,
                                   .leaving = 0.03};
  const auto needle = scene.add_tool("needle", {.shape = half_circle, .pose = pose_at(-0.1), .friction = 0.3});
  const auto thread = scene.swage("suture", {.length = 0.12, .friction = 0.1}, "needle");
  const auto draw = [&](const std::string& path) {
    Section section(path, sim);
    section.tissue();
    section.line(sim.solver().needle_points("needle", 60), "#404040", 0.6);
    section.line(sim.solver().thread_state(thread).position, "#2060c0", 0.3);
  };

  double most = 0.0;
  for (int degree = 1; degree <= 330; ++degree) {
    const phymul::ToolPose pose = pose_at(degree * std::numbers::pi / 180 - 0.1);
    if (degree == 70 || degree == 150 || degree == 190) {  // let go, and taken at another place
      needle.release();
      if (!sim.advance(0.1).ok()) return 1;
      needle.move_to(pose);
      if (!sim.advance(0.05).ok()) return 1;
    }
    needle.move_to(pose);
    if (const auto report = sim.advance(0.003); !report.ok()) return std::puts(report.message().c_str()), 1;
    most = std::max(most, resistance(sim.force_on(needle), pose));
    if (degree % 10 == 0) {
      std::printf("%3d degrees  %6.1f mN  %zu passages\n", degree, 1e3 * most,
                  sim.solver().thread_state(thread).passages.size());
      most = 0.0;
    }
    if (degree == 110) draw("suture_1.svg");
  }
  draw("suture_2.svg");

  thread.pull(phymul::ThreadTip::first, {0.05, 0, 0.01});
  thread.pull(phymul::ThreadTip::last, {-0.05, 0, 0.01});
  if (!sim.advance(0.5).ok()) return 1;
  const auto passages = static_cast<phymul::Index>(sim.solver().thread_state(thread).sewn.size());
  thread.tie(0, passages - 1, 4);
  thread.pull(phymul::ThreadTip::first, Vec3::Zero());
  thread.pull(phymul::ThreadTip::last, Vec3::Zero());
  if (!sim.advance(0.2).ok()) return 1;
  draw("suture_3.svg");
  const phymul::KnotState knot = sim.solver().thread_state(thread).knots.at(0);
  std::printf("%d passages; the knot holds %.1f mN\n", static_cast<int>(passages), 1e3 * knot.tension);
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}

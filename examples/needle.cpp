// SPDX-License-Identifier: MIT
//
// needle [--out DIR] [--quick]: a needle goes 40 mm into a block of liver, stops and comes out; a second one turns all
// the way. Writes what the hand feels (needle.csv) and pictures of the block cut open.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "example_run.h"
#include "scene_picture.h"

namespace {

using phymul::Vec3;

constexpr double width = 0.06, height = 0.05;  // m
constexpr double above = 0.002, deep = 0.040;  // m: where the tip starts over the surface, and goes to under it
                                               // 1/s
constexpr double tick = 1e-3;                  // s

/// 1/s; a faster needle turns faster.
double turns(const ExampleOptions& options) {
  return options.quick ? 33.0 : 10.0;
}

/// Where the tip is and how it got there.
struct Motion {
  double speed, rest;  // m/s; s at the deepest place
  double down() const { return (above + deep) / speed; }
  double all() const { return 2.0 * down() + rest + 0.05; }
  double depth(double time) const {
    const double in = std::min(time, down()), out = std::clamp(time - down() - rest, 0.0, down());
    return speed * (in - out) - above;
  }
};

/// What the curve shows, N on the hub: positive pushes the hand back.
struct Findings {
  double peak = 0.0, after_peak = 0.0, deepest = 0.0, stopped = 0.0, most_pull = 0.0, outside = 0.0;
  double peak_depth = 0.0;
};

class Insertion {
 public:
  Insertion(const ExampleOptions& options, bool turning)
      : options_(options),
        turns_(turning ? turns(options) : 0.0),
        motion_{options.quick ? 0.10 : 0.03, options.quick ? 0.05 : 0.3},
        sim_(block(options.quick ? 8 : 12), {.material = {.young = 25e3, .poisson = 0.45, .density = 1000.0},
                                             .backend = "cpu",
                                             .damping = {.rate = 60.0},
                                             .solver = {.threads = 1}}),
        needle_(sim_.scene().fix("z0").add_tool({.shape = shape_, .pose = pose_at(0.0), .friction = 0.3})) {}

  Findings run(Curve& curve, bool draw) {
    Findings found;
    double lowest = HUGE_VAL;
    std::size_t drawn = 0;
    for (double time = 0.0; time < motion_.all();) {
      needle_.move_to(pose_at(time + tick));
      time = advance(sim_, tick);
      const double force = sim_.force_on(needle_).mean_force.z(), depth = motion_.depth(time);
      curve.add(turns_ > 0.0 ? "turning" : "straight", {time, 1e3 * depth, force});
      note(found, lowest, time, depth, force);
      if (draw) picture(drawn, time, force);
    }
    found.outside = sim_.force_on(needle_).mean_force.z();
    return found;
  }

 private:
  static phymul::Model block(int n) { return phymul::make_block({width, width, height}, n, n, n - 2); }

  phymul::ToolPose pose_at(double time) const {
    const double angle = 2.0 * std::numbers::pi * turns_ * time;
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
    return {.position = {0.5 * width, 0.5 * width, height - motion_.depth(time)},
            .orientation = phymul::Quaternion(turned)};
  }

  void note(Findings& found, double& lowest, double time, double depth, double force) const {
    const bool inward = time <= motion_.down();
    if (inward && depth < 0.5 * deep && force > found.peak) {
      found.peak = force;
      found.peak_depth = depth;
      lowest = HUGE_VAL;
    }
    if (inward && depth < found.peak_depth + 0.3 * deep) found.after_peak = lowest = std::min(lowest, force);
    if (inward) found.deepest = force;
    if (!inward && time <= motion_.down() + motion_.rest) found.stopped = force;
    found.most_pull = std::min(found.most_pull, force);
  }

  /// Each moment once: under the tip before the skin gives way, all the way in, half-way out.
  void picture(std::size_t& drawn, double time, double force) {
    const double out = motion_.down() + motion_.rest;
    const phymul::State state = sim_.state();
    const bool pierced = state.tools.front().needle.punctured;
    const bool pressing = force > 0.85 * shape_.puncture && !pierced;
    const bool moments[] = {pressing, time > out - 0.5 * tick, motion_.depth(time) < 0.8 * deep && time > out};
    if (drawn >= 3 || !moments[drawn]) return;
    const std::string titles[] = {"1. It presses on the surface", "2. It is in, and stands still",
                                  "3. It is drawn out"};
    const char* words[] = {"just before the skin gives way: %.1f N on the hand",
                           "40 mm deep; it sticks: %.1f N on the hand",
                           "the tissue is drawn along: %.1f N on the hand"};
    ScenePictureOptions sheet;
    sheet.title = titles[drawn];
    sheet.subtitle = text(words[drawn], force);
    sheet.full_scale = 0.005;
    sheet.eye = Vec3(0.25, -1.0, 0.35);
    sheet.held = sim_.model().group("z0");
    sheet.frame = sim_.model().rest;
    sheet.frame.push_back({0.5 * width, 0.5 * width, height + 0.028});
    sheet.tools.push_back({shape_, sim_.pose_of(needle_), needle_colour, "needle, 1.3 mm"});
    pictures().draw(state, sheet, options_.file(text("needle_%.0f.png", static_cast<double>(drawn + 1))));
    ++drawn;
  }

  /// The half behind the needle.
  const ScenePictures& pictures() {
    if (!pictures_) pictures_.emplace(sim_.model(), cells_beyond(sim_.model(), {0.0, 0.5 * width, 0.0}, Vec3::UnitY()));
    return *pictures_;
  }

  const ExampleOptions& options_;
  const double turns_;  // 1/s
  const Motion motion_;
  const phymul::Needle shape_{.length = 0.08, .spread = 0.0125};
  phymul::Simulation sim_;
  phymul::ToolHandle needle_;
  std::optional<ScenePictures> pictures_;
};

void run(const ExampleOptions& options) {
  Curve curve(options.file("needle.csv"), "needle,time_s,depth_mm,force_N");
  const Findings straight = Insertion(options, false).run(curve, true);
  const Findings turning = Insertion(options, true).run(curve, false);
  std::printf(
      "straight: %.2f N at %.1f mm, then %.2f N; %.2f N at 40 mm, %.2f N at rest there; %.2f N on the way out\n",
      straight.peak, 1e3 * straight.peak_depth, straight.after_peak, straight.deepest, straight.stopped,
      straight.most_pull);
  std::printf("turning %.0f times a second: %.2f N at 40 mm, %.2f N on the way out\n", turns(options), turning.deepest,
              turning.most_pull);
  const phymul::Needle law;
  require(std::abs(straight.peak - law.puncture) < 0.1 * law.puncture, "the force does not rise to the puncture's");
  require(straight.after_peak < 0.8 * straight.peak, "no drop when the skin gives way");
  require(straight.deepest > straight.after_peak, "friction does not grow with depth");
  require(straight.most_pull < -0.5 * law.kinetic_friction * deep, "no pull on the way out");
  require(std::abs(straight.outside) < 0.02, "a force when it is out");
  require(turning.most_pull > 0.75 * straight.most_pull, "turning does not take friction from the way out");
}

}  // namespace

int main(int argc, char** argv) {
  return run_example(argc, argv,
                     "A needle goes into a block of liver and comes out: force curves as CSV, and pictures.", run);
}

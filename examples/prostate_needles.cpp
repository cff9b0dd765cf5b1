// SPDX-License-Identifier: MIT
//
// The second part of probe_on_prostate: needles go in one after the other and stay. Each is aimed at where its target
// lay before the first one: how far has the target moved when the tip is there?
#include <algorithm>
#include <array>
#include <cmath>

#include "prostate.h"
#include "scene_picture.h"

namespace {

using phymul::Vec3;

constexpr int count = 3;
constexpr std::array<const char*, count> names{"left", "middle", "right"};
constexpr std::array<double, count> across{-0.012, 0.0, 0.012};  // m, x of needles and targets
constexpr double target_z = -0.006, above = 0.002;               // m
constexpr double tick = 1e-3;                                    // s

// Less than half of what liver takes: tissue this soft would give way by centimetres first.
const phymul::Needle thin{.length = 0.09, .puncture = 0.8, .cutting = 0.4, .spread = 0.008};

struct Order {
  const char* name;
  std::array<int, count> needles;
};
constexpr std::array<Order, 3> orders{
    {{"middle first", {1, 0, 2}}, {"middle second", {0, 1, 2}}, {"middle last", {0, 2, 1}}}};

struct Files {
  Curve force, moved, arrivals;
};

/// What an order does to the middle target: how far it is from the tip that has come to where it was, and how far every
/// target has moved at the end, m.
struct Outcome {
  std::array<double, count> miss{};
  double first_force = 0.0;  // N, of the first needle at its place
};

class Session {
 public:
  Session(const Prostate& prostate, const ExampleOptions& options, const Order& order)
      : prostate_(prostate), options_(options), order_(order), sim_(prostate.simulation()) {
    top_ = prostate.shape.semi_axes.z() + prostate.shape.shell;
    speed_ = options.quick ? 0.25 : 0.12;
    for (int k = 0; k < count; ++k) {
      needles_.push_back(sim_.scene().add_tool({.shape = thin, .pose = {.position = outside(k)}, .friction = 0.3}));
      targets_.emplace_back(prostate.model, Vec3(across[k], 0.0, target_z));
    }
  }

  Outcome run(Files& files, const ScenePictures& pictures, int number) {
    Outcome outcome;
    for (int turn = 0; turn < count; ++turn) {
      const int k = order_.needles[turn];
      insert(k, files);
      const Vec3 miss = targets_[k].now(sim_.state()) - targets_[k].rest();
      outcome.miss[k] = miss.norm();
      if (turn == 0) outcome.first_force = sim_.force_on(needles_[k]).mean_force.z();
      files.arrivals.add(std::string(order_.name) + ',' + names[k],
                         {turn + 1.0, 1e3 * -miss.z(), 1e3 * std::hypot(miss.x(), miss.y()), 1e3 * miss.norm()});
      if (k == 1) draw(pictures, number, turn, miss.norm());
    }
    return outcome;
  }

 private:
  Vec3 outside(int k) const { return {across[k], 0.0, top_ + above}; }

  /// At a steady speed to the place planned, then a moment for the tissue to come to rest.
  void insert(int k, Files& files) {
    const double way = top_ + above - target_z, begin = sim_.time(), wait = 0.12;
    for (double time = begin; time < begin + way / speed_ + wait;) {
      const double gone = std::min(way, speed_ * (time + tick - begin));
      needles_[k].move_to({.position = outside(k) - gone * Vec3::UnitZ()});
      time = advance(sim_, tick);
      const phymul::State state = sim_.state();
      files.force.add(std::string(order_.name) + ',' + names[k],
                      {time, 1e3 * (gone - above), sim_.force_on(needles_[k]).mean_force.z()});
      const auto moved = [&](int target) {
        return 1e3 * (targets_[target].now(state) - targets_[target].rest()).norm();
      };
      files.moved.add(order_.name, {time, moved(0), moved(1), moved(2)});
    }
  }

  void draw(const ScenePictures& pictures, int number, int turn, double miss) const {
    const phymul::State state = sim_.state();
    ScenePictureOptions sheet;
    constexpr std::array<const char*, count> place{"first", "second", "last"};
    sheet.title = text("%.0f. The middle needle comes ", number);
    sheet.title += place[turn];
    sheet.subtitle = text("its tip is where the target was; the target has moved %.1f mm", 1e3 * miss);
    sheet.full_scale = 0.005;
    sheet.width = 710;
    sheet.height = 520;
    sheet.eye = Vec3(0.1, -1.0, 0.15);
    sheet.held = prostate_.held;
    sheet.frame = prostate_.model.rest;
    sheet.frame.push_back({0.0, 0.0, top_ + 0.012});
    sheet.key = {{KeyEntry::Mark::line, organ_colour, "gland"},
                 {KeyEntry::Mark::cross, planned_colour, "planned"},
                 {KeyEntry::Mark::ball, target_colour, "target now"}};
    bool named = false;
    for (int k = 0; k < count; ++k) {
      const phymul::ToolPose& pose = sim_.pose_of(needles_[k]);
      if (pose.position.z() < top_) {
        sheet.tools.push_back({thin, pose, needle_colour, named ? "" : "needle"});
        named = true;
      }
      sheet.points.push_back({targets_[k].rest(), planned_colour, true});
      sheet.points.push_back({targets_[k].now(state), target_colour});
    }
    pictures.draw(state, sheet, options_.file("prostate_needles_" + std::to_string(number) + ".png"));
  }

  const Prostate& prostate_;
  const ExampleOptions& options_;
  const Order& order_;
  phymul::Simulation sim_;
  std::vector<BodyPoint> targets_;
  std::vector<phymul::ToolHandle> needles_;
  double top_ = 0.0, speed_ = 0.0;
};

}  // namespace

void insert_in_orders(const Prostate& prostate, const ExampleOptions& options) {
  Files files{{options.file("prostate_needles_force.csv"), "order,needle,time_s,depth_mm,force_N"},
              {options.file("prostate_needles_moved.csv"), "order,time_s,left_mm,middle_mm,right_mm"},
              {options.file("prostate_needles.csv"), "order,needle,turn,short_mm,aside_mm,miss_mm"}};
  const ScenePictures pictures(prostate.model, prostate.half(Vec3::UnitY()), prostate.model.group("surface"));
  std::array<Outcome, orders.size()> outcome;
  for (std::size_t o = 0; o < orders.size(); ++o) {
    outcome[o] = Session(prostate, options, orders[o]).run(files, pictures, static_cast<int>(o) + 1);
    std::printf("%s: the tips miss their targets by %.2f, %.2f and %.2f mm (left, middle, right)\n", orders[o].name,
                1e3 * outcome[o].miss[0], 1e3 * outcome[o].miss[1], 1e3 * outcome[o].miss[2]);
    for (const double miss : outcome[o].miss) require(miss > 1e-4 && miss < 0.02, "a target has not moved, or too far");
    require(outcome[o].first_force > thin.cutting, "the needle at its place does not press on the hand");
  }
  const double first = outcome[0].miss[1], last = outcome[2].miss[1];
  require(std::abs(last - first) > 0.05 * first, "the order makes no difference");
}

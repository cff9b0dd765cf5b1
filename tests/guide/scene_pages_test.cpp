// SPDX-License-Identifier: MIT
//
// The code of docs/guide/choosing.md, contacts.md, hosting.md, joints.md, needles.md, threads.md and tools.md:
// check.pages finds each block of these pages here.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>
#include <vector>

namespace {

const phymul::Material soft{.young = 8e3, .poisson = 0.4, .density = 1060};
const phymul::Material stiff{.young = 40e3, .poisson = 0.4, .density = 1060};

TEST(GuideChoosing, Sleeps) {
  const phymul::Model organ = phymul::make_block({0.04, 0.04, 0.04}, 8, 8, 8);

  phymul::Simulation sim(
      organ, {.material = soft, .backend = "cpu", .damping = {.rate = 60}, .solver = {.sleep_tolerance = 1e-5}});

  EXPECT_TRUE(sim.advance(0.05).ok());
  EXPECT_TRUE(sim.warnings().empty() || sim.warnings()[0].find("sleep") == std::string::npos);
}

TEST(GuideChoosing, GivesAStiffPartSubsteps) {
  phymul::Model organ = phymul::make_block({0.04, 0.04, 0.04}, 8, 8, 8);
  organ.add_group("tumour", organ.particles_in([](const phymul::Vec3& place) {
    return (place - phymul::Vec3(0.02, 0.02, 0.02)).norm() < 0.009;
  }));
  const phymul::Material hard{.young = 800e3, .poisson = 0.4, .density = 1060};

  phymul::Simulation sim(
      organ, {.material = soft, .materials = {{"tumour", hard}}, .backend = "cpu", .solver = {.max_substeps = 16}});

  EXPECT_GT(sim.solver().substeps(), 4);
  EXPECT_TRUE(sim.advance(0.05).ok());
}

TEST(GuideContacts, LetBodiesTouch) {
  const phymul::Model liver = phymul::make_block({0.04, 0.04, 0.02}, 4, 4, 2);
  const phymul::Model gallbladder = phymul::moved(liver, {0, 0, 0.0225});

  phymul::Simulation sim({{"liver", liver, stiff}, {"gallbladder", gallbladder, soft}});  // several bodies, one scene
  sim.scene().fix("liver/z0").gravity({0, 0, -9.81}).contacts({.friction = 0.4});

  ASSERT_TRUE(sim.advance(0.1).ok());
  EXPECT_LT(sim.max_displacement(), 0.02);  // a free fall would be 49 mm

  sim.scene().constrain_volume("liver");  // or constrain_volume() for the whole body

  EXPECT_TRUE(sim.advance(0.01).ok());
}

TEST(GuideHosting, FindsTheRestShape) {
  phymul::Simulation sim(phymul::make_block({0.2, 0.05, 0.05}, 8, 2, 2), {.material = soft});

  sim.scene().fix("x0").gravity({0, 0, -0.3});
  const phymul::StaticResult rest = sim.solve_static();
  if (!rest.converged()) std::puts(rest.message().c_str());

  EXPECT_TRUE(rest.converged());
}

TEST(GuideJoints, HoldAndTear) {
  const phymul::Model organ = phymul::make_block({0.08, 0.06, 0.04}, 8, 6, 4);
  const phymul::Model bladder = phymul::moved(phymul::make_block({0.04, 0.02, 0.02}, 4, 2, 2), {0.02, 0.02, -0.021});
  phymul::Simulation sim({{"liver", organ}, {"gallbladder", bladder}}, {.material = soft, .backend = "cpu"});
  sim.scene().add_tool("hook", {.shape = phymul::Sphere{0.002}, .pose = {.position = {0.04, 0.03, 0.1}}});

  phymul::Scene& scene = sim.scene();
  const auto& model = sim.model();
  // To the world: parallel fibres, 10 mm long, that pull and do not push.
  const auto ligament = scene.attach(model.group("liver/z1"), phymul::World{.offset = {0, 0, 0.01}},
                                     {.stiffness = 5e5, .damping = 100, .slack = true});
  // To another body: glue, which holds in all directions and tears at 2 kPa.
  const auto glue = scene.attach(model.group("gallbladder/z1"), "liver", {.stiffness = 8e6, .breaking_stress = 2e3});

  const auto suture = scene.add_joint({phymul::at_mean(model.group("liver/x0")), phymul::at_world({-0.03, 0, 0})}, 40);
  scene.add_joint("string", {.springs = {{phymul::at_particle(17), phymul::at_tool("hook"), 0.02}},
                             .stiffness = 30,
                             .slack = true,
                             .breaking_force = 0.5});

  scene.gravity({0, 0, -9.81});
  ASSERT_TRUE(sim.advance(0.02).ok());
  EXPECT_GT(sim.report_of(ligament).force.norm(), 0.0);

  suture.set_rest_length(0.005);  // pulls tight; also set_rest_lengths, set_stiffness
  const phymul::JointReport& report = sim.report_of(glue);
  std::printf("%.2f N, %d springs broken\n", report.force.norm(), report.broken);
  scene.remove_joint("string");

  EXPECT_TRUE(sim.advance(0.02).ok());
}

TEST(GuideNeedles, Puncture) {
  phymul::Simulation sim(
      phymul::make_block({0.06, 0.06, 0.05}, 8, 8, 6),
      {.material = {.young = 25e3, .poisson = 0.45, .density = 1000}, .backend = "cpu", .damping = {.rate = 50}});
  sim.scene().fix("z0");
  std::vector<double> curve;

  const phymul::Needle shape{.length = 0.15, .radius = 0.64e-3, .spread = 0.0125};
  const auto needle = sim.scene().add_tool({.shape = shape, .pose = {.position = {0.03, 0.03, 0.06}}});
  for (double tip = 0.06; tip > 0.02; tip -= 3e-5) {  // 30 mm/s along -z
    needle.move_to({.position = {0.03, 0.03, tip}});
    if (!sim.advance(1e-3).ok()) break;
    curve.push_back(sim.force_on(needle).mean_force.z());  // N on the hub
  }

  ASSERT_EQ(curve.size(), 1334U);
  EXPECT_NEAR(*std::max_element(curve.begin(), curve.end()), 2.0, 0.3);  // the puncture
}

TEST(GuideTools, Jaws) {
  phymul::Simulation sim(phymul::make_block({0.06, 0.04, 0.02}, 8, 6, 3),
                         {.material = soft, .backend = "cpu", .damping = {.rate = 50}});
  sim.scene().fix("x0");
  int ticks = 0;
  double grip = 0.0;
  const auto running = [&] { return ++ticks < 2000; };
  const auto hinge = [] {
    return phymul::ToolPose{.position = {0.07, 0.02, 0.01},
                            .orientation = phymul::Quaternion(0.5, 0.5, 0.5, 0.5)};  // to -x, opens along z
  };
  const auto show = [&](const phymul::Vec3&, double now) { grip = now; };

  phymul::Jaws grasper(sim.scene(), "grasper",
                       {.length = 0.02, .friction = 0.8, .grip = 0.5, .opening = 2.0, .speed = 2.0}, hinge());
  grasper.close();
  while (running()) {
    grasper.follow(hinge(), sim.force_on(grasper.first()), sim.force_on(grasper.second()), 1e-3);
    if (!sim.advance(1e-3).ok()) break;
    show(grasper.force(), grasper.grip());  // N: on the handle, and at the end of a plate
  }

  EXPECT_NEAR(grip, 0.5, 0.1);
}

TEST(GuideThreads, SewAndHang) {
  const double width = 0.02, depth = 0.01, y = 0.01;
  const phymul::Model piece = phymul::make_block({width, 0.02, depth}, 4, 4, 2);
  phymul::Simulation sim({{"left", phymul::moved(piece, {-width - 0.003, 0, 0}), soft},
                          {"right", phymul::moved(piece, {0.003, 0, 0}), soft}});
  phymul::Scene& scene = sim.scene();
  scene.fix("left/x0").fix("right/x1");
  scene.add_tool("driver", {.shape = phymul::Sphere{1e-3}, .pose = {.position = {0.3, 0, 0.1}}});
  const phymul::Vec3 start(0, 0, 0.1), direction(1, 0, 0);

  const phymul::Thread suture{.length = 0.2, .friction = 0.1, .breaking_force = 10, .passage_limit = 1.5};
  const auto stitch = scene.sew(
      suture,
      phymul::VecList{{-0.007, y, depth}, {-0.004, y, 0.4 * depth}, {0.004, y, 0.4 * depth}, {0.007, y, depth}});
  stitch.pull(phymul::ThreadTip::first, {0.03, 0, 0});  // N: across the wound, from both sides
  stitch.pull(phymul::ThreadTip::last, {-0.03, 0, 0});

  ASSERT_TRUE(sim.advance(0.1).ok());

  stitch.tie(0, 3, 4);  // passages 0 and 3, with four throws

  const phymul::Anchor front_wall = phymul::at_mean(sim.model().group("left/x1")),
                       back_wall = phymul::at_mean(sim.model().group("right/x0"));
  const auto clip = scene.add_clip("clip", {.gap = 1e-3, .holding = 0.5}, front_wall, back_wall);
  ASSERT_TRUE(sim.advance(0.1).ok());
  EXPECT_GT(sim.solver().thread_state(clip).tension.at(1), 0.0);
  scene.remove_thread("clip");

  const auto thread = scene.add_thread({.length = 0.3, .segment = 3e-3}, start, direction);
  thread.hold(0, start);  // a node; call again to move it
  thread.join(phymul::ThreadTip::last, phymul::at_tool("driver"));

  ASSERT_TRUE(sim.advance(0.01).ok());

  const auto loop =
      scene.add_thread({.length = 0.2, .segment = 1e-3, .touches = true, .friction = 0.2}, start, direction);

  ASSERT_TRUE(sim.advance(0.01).ok());
  EXPECT_TRUE(sim.solver().thread_state(loop).touch.empty()) << "in the air";

  const phymul::ThreadState& state = sim.solver().thread_state(stitch);

  EXPECT_GT(state.tension[2], 0.01);
}

TEST(GuideTools, PressAndReport) {
  phymul::Simulation sim(phymul::make_block({0.04, 0.04, 0.04}, 6, 6, 6), {.material = soft, .damping = {.rate = 20}});
  sim.scene().fix("z0");
  int ticks = 0;
  double felt = 0.0;
  const auto running = [&] { return ticks < 100; };
  const auto hand = [&] { return phymul::Vec3(0.02, 0.02, 0.05 - 1e-4 * ++ticks); };
  const auto show = [&](const phymul::Vec3& force) { felt = force.z(); };

  const auto probe =
      sim.scene().add_tool({.shape = phymul::Sphere{0.005}, .pose = {.position = {0.02, 0.02, 0.05}}, .friction = 0.3});
  while (running()) {                     // once a millisecond
    probe.move_to({.position = hand()});  // where it is when the next call ends
    if (!sim.advance(1e-3).ok()) break;
    show(sim.force_on(probe).mean_force);  // N, on the tool
  }

  EXPECT_EQ(ticks, 100);
  EXPECT_GT(felt, 0.01);
}

TEST(GuideTools, DrawsTissue) {
  phymul::Simulation sim(phymul::make_block({0.04, 0.04, 0.04}, 12, 12, 12), {.material = soft});
  sim.scene().fix("z0");
  const phymul::Vec3 mouth(0.02, 0.02, 0.0445);

  const auto tube = sim.scene().add_tool(
      {.shape = phymul::Sphere{0.004}, .pose = {.position = mouth}, .suction = 0.5, .suction_reach = 0.003});

  ASSERT_TRUE(sim.step(1, 1e-5).ok());
  EXPECT_LT(sim.force_on(tube).force.z(), -0.01);
}

}  // namespace

// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/text_file.h"

namespace phymul {
namespace {

using namespace test;

/// What a host may do, in many small calls: loads put in, replaced and taken out, gravity, a reset, a rewind, steps of
/// several lengths, a run to rest. Leaves a state on disk in the middle.
Recording session(Solver& solver, Scene& scene, const std::string& middle, std::uint64_t* middle_at,
                  State* end = nullptr) {
  const Model& model = scene.model();
  const double dt = 0.4 * solver.stable_step();
  Recorder recorder(solver, scene);
  for (int k = 0; k < 20; ++k) recorder.step(1, dt);
  scene.gravity({0, 0, -9.81}).add(pull(model, "x1", {0, 0, 1}, {{0, 0}, {0.02, 0.004}}));
  recorder.step(30, 0.7 * dt);
  const Snapshot early = solver.snapshot();
  for (int k = 0; k < 10; ++k) {
    scene.replace(1, pull(model, "x1", {0, 1, 0.1 * k}, {{0, -0.0}, {0.02, 0.003}}));
    recorder.step(2, dt);
  }
  scene.set_events(1, std::vector<ValueEvent>{{0, 0.0}, {0.02, 0.005}});
  recorder.step(3, dt);
  recorder.checkpoint();
  recorder.note("tool", "pose 7");
  scene.add(pull(model, "y1", {1, 0, 0}, {{0, 0.01}}, LoadType::force)).remove(1);
  recorder.step(25, dt);
  save_state(solver, middle);
  *middle_at = 0;
  for (const Input& input : recorder.recording().inputs) *middle_at += input.times;
  recorder.step(5, dt);
  recorder.restore(early);
  recorder.step(11, dt);
  scene.clear();
  scene.fix("x0").gravity({0, 0, -1});
  recorder.run_to_rest(60, dt);
  recorder.checkpoint();
  if (end != nullptr) *end = solver.read();
  return recorder.recording();
}

class RecordingTest : public ::testing::Test {
 protected:
  RecordingTest()
      : model_(block_at(Vec3(0, 0, 3))),
        topology_(std::make_shared<const TopologyTextures>(build_topology(model_))),
        scene_(model_) {
    scene_.fix("x0");
  }

  std::unique_ptr<Solver> solver(const BackendCase& backend, const Scene& scene, double damping = 5.0) {
    return make_solver(backend.name, topology_, scene, options_for(backend, damping));
  }

  /// The end of another solver's replay.
  Snapshot end_of_replay(const Recording& recording, const BackendCase& backend, double damping = 5.0) {
    Scene again(model_);
    const auto own = solver(backend, again, damping);
    Replay(recording, *own, again).run();
    return own->snapshot();
  }

  Model model_;
  std::shared_ptr<const TopologyTextures> topology_;
  Scene scene_;
};

TEST_F(RecordingTest, AReplayIsTheRunBitForBitThroughAFileAndAcrossASavedState) {
  const std::string middle = path_for("middle.state"), file = path_for("session.rec");
  for (const BackendCase& backend : cpu_backends) {
    Scene scene = Scene(model_).fix("x0");
    const auto recorded = solver(backend, scene);
    State end;
    std::uint64_t middle_at = 0;
    const Recording recording = session(*recorded, scene, middle, &middle_at, &end);
    save_recording(recording, file);
    ASSERT_EQ(read_recording(file), recording);

    Scene again(model_);
    again.gravity({1, 2, 3});  // a replay clears what the scene holds
    const auto replayed = solver(backend, again);
    Replay replay(read_recording(file), *replayed, again);
    std::vector<std::string> notes;
    replay.on_note = [&](const Input& input) { notes.push_back(input.kind + ": " + input.bytes); };
    replay.run();
    EXPECT_TRUE(same_bits(replayed->read(), end)) << backend.name << ' ' << backend.threads;
    EXPECT_EQ(replayed->snapshot(), recorded->snapshot());
    EXPECT_EQ(notes, std::vector<std::string>{"tool: pose 7"});
    EXPECT_EQ(again.loads(), scene.loads());

    Scene second_half(model_);
    const auto resumed = solver(backend, second_half);
    Replay rest(recording, *resumed, second_half);
    rest.skip_to(middle_at);
    EXPECT_EQ(rest.position(), middle_at);
    load_state(*resumed, middle);
    rest.run();
    EXPECT_TRUE(same_bits(resumed->read(), end)) << backend.name << ' ' << backend.threads;
    EXPECT_EQ(rest.position(), replay.position());
  }
}

TEST_F(RecordingTest, ARecordingOfOneThreadReplaysOnTwo) {
  const std::string middle = path_for("threads.state");
  const auto one = solver({"cpu", 1}, scene_);
  State end;
  std::uint64_t at = 0;
  const Recording recording = session(*one, scene_, middle, &at, &end);
  EXPECT_TRUE(same_bits(end_of_replay(recording, {"cpu", 2}).state, end));
}

/// Poses at every step, placed and grasping tools, one that goes and one that comes: all again, also across a state
/// saved while a tool holds tissue.
TEST_F(RecordingTest, ToolsMoveAgainAsTheyDid) {
  const std::string middle = path_for("tools.state"), file = path_for("tools.rec");
  for (const BackendCase& backend : cpu_backends) {
    Scene scene = Scene(model_).fix("x0").contacts({}).constrain_volume();
    scene.add_tool("ball", {.shape = Sphere{0.005}, .pose = {.position = {0.06, 0.015, 3.035}}, .friction = 0.3});
    scene.add_tool("rod", {.shape = Capsule{0.003, 0.1},
                           .pose = {.position = {0.04, 0.014, 3.034}, .velocity = {0.02, 0, -0.2}},
                           .friction = 0.2,
                           .contact = ToolContact::surface});
    const auto recorded = solver(backend, scene);
    const double dt = 0.4 * recorded->stable_step();
    Recorder recorder(*recorded, scene);
    const auto lower = [&](int k) {
      return ToolPose{.position = {0.06 - 1e-4 * k, 0.015, 3.035 - 2e-4 * k}, .velocity = {0, 0, -0.01}};
    };
    for (int k = 0; k < 20; ++k) {
      scene.tool("ball").move_to(lower(k));
      recorder.step(3, dt);
    }
    scene.tool("ball").grasp(0.002);
    recorder.step(1, dt);
    EXPECT_FALSE(recorded->read().tools[0].held.empty());
    for (int k = 20; k > 10; --k) {
      scene.tool("ball").move_to(lower(k));
      recorder.step(3, dt);
    }
    save_state(*recorded, middle);
    std::uint64_t middle_at = 0;
    for (const Input& input : recorder.recording().inputs) middle_at += input.times;
    recorder.step(5, dt);
    scene.tool("ball").release();
    scene.tool("ball").grasp(0.0005);
    recorder.step(5, dt);
    scene.tool("ball").release();
    scene.tool("ball").teleport({.position = {0.03, 0.015, 3.04}});
    scene.add_tool("floor", {.shape = HalfSpace{}, .pose = {.position = {0, 0, 2.99}}});
    recorder.step(5, dt);
    scene.remove_tool("ball");
    recorder.step(5, dt);
    const State end = recorded->read();
    ASSERT_EQ(end.tools.size(), 2u);
    EXPECT_GT(recorded->tool_force("rod").particles, 0);
    save_recording(recorder.recording(), file);

    const Snapshot again = end_of_replay(read_recording(file), backend);
    EXPECT_TRUE(same_bits(again.state, end)) << backend.name << ' ' << backend.threads;
    EXPECT_EQ(again, recorded->snapshot());

    Scene half(model_);
    const auto resumed = solver(backend, half);
    Replay rest(read_recording(file), *resumed, half);
    rest.skip_to(middle_at);
    load_state(*resumed, middle);
    EXPECT_FALSE(resumed->read().tools[0].held.empty());
    rest.run();
    EXPECT_TRUE(same_bits(resumed->read(), end)) << backend.name << ' ' << backend.threads;
  }
}

TEST_F(RecordingTest, AToolThatComesLaterAndGraspsAtOnceGraspsAgain) {
  const auto recorded = solver({"cpu", 1}, scene_);
  Recorder recorder(*recorded, scene_);
  const double dt = 0.4 * recorded->stable_step();
  recorder.step(2, dt);
  const Vec3 end(0.06, 0.015, 3.015);  // of block_at(0, 0, 3)
  scene_.add_tool("jaw", {.shape = Sphere{0.006}, .pose = {.position = end}});
  scene_.tool("jaw").grasp(0.0);
  recorder.step(2, dt);
  ASSERT_FALSE(recorded->read().tools.at(0).held.empty());
  EXPECT_EQ(end_of_replay(recorder.recording(), {"cpu", 1}), recorded->snapshot());
}

/// What replays has nobody to stop it: a call counts as far as it went.
TEST_F(RecordingTest, ACallThatWasStoppedIsRecordedAsFarAsItWent) {
  SolverOptions options = options_for({"reference", 0}, 30.0);
  options.progress = [](const StepProgress& progress) { return progress.steps < 3; };
  options.progress_seconds = 0.0;
  scene_.gravity({0, 0, -9.81});
  const auto recorded = make_solver("reference", topology_, scene_, options);
  Recorder recorder(*recorded, scene_);
  const double dt = 0.4 * recorded->stable_step();
  EXPECT_EQ(recorder.step(9, dt).steps, 3);
  EXPECT_EQ(recorder.run_to_rest(9, dt).report.steps, 3);
  recorder.checkpoint();
  EXPECT_EQ(end_of_replay(recorder.recording(), {"reference", 0}, 30.0), recorded->snapshot());
}

TEST_F(RecordingTest, EqualStepsAreOneInput) {
  const auto own = solver({"reference", 0}, scene_);
  Recorder recorder(*own, scene_);
  for (int k = 0; k < 100; ++k) recorder.step(1, 1e-5);
  EXPECT_EQ(recorder.recording().inputs.size(), 1u);
  EXPECT_EQ(recorder.recording().inputs[0].times, 100u);
}

TEST_F(RecordingTest, SkippingBackMakesTheSceneAnew) {
  const std::string middle = path_for("back.state");
  const auto recorded = solver({"cpu", 1}, scene_);
  std::uint64_t at = 0;
  const Recording recording = session(*recorded, scene_, middle, &at);
  Scene again(model_);
  const auto own = solver({"cpu", 1}, again);
  Replay replay(recording, *own, again);
  replay.run();
  replay.skip_to(at);
  load_state(*own, middle);
  replay.run();  // its checkpoint holds
  EXPECT_EQ(own->snapshot(), recorded->snapshot());
  EXPECT_TRUE(refuses([&] { replay.skip_to(1000000); }, "expected a position of"));
}

/// From among steps that are one input: all of them are still to come.
TEST_F(RecordingTest, SkippingBackForgetsRepetitionsDone) {
  const auto recorded = solver({"cpu", 1}, scene_);
  Recorder recorder(*recorded, scene_);
  for (int k = 0; k < 10; ++k) recorder.step(1, 1e-5);
  Scene again(model_);
  const auto own = solver({"cpu", 1}, again);
  Replay replay(recorder.recording(), *own, again);
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(replay.next());
  replay.skip_to(0);
  own->restore(recorder.recording().start);
  replay.run();
  EXPECT_EQ(replay.position(), 10u);
  EXPECT_EQ(own->snapshot(), recorded->snapshot());
}

TEST_F(RecordingTest, AnotherBackendMissesTheCheckpointAndSaysSo) {
  const std::string middle = path_for("check.state");
  const auto recorded = solver({"reference", 0}, scene_);
  std::uint64_t at = 0;
  const Recording recording = session(*recorded, scene_, middle, &at);
  Scene again(model_);
  const auto own = solver({"cpu", 1}, again);
  Replay replay(recording, *own, again);
  EXPECT_TRUE(refuses([&] { replay.run(); }, "expected the recorded state at t = ", "recorded on reference"));
}

TEST_F(RecordingTest, OtherOptionsAndOtherBodiesAreRefused) {
  const auto recorded = solver({"reference", 0}, scene_);
  Recorder recorder(*recorded, scene_);
  recorder.step(3, 1e-5);
  Scene again(model_);
  const auto damped = solver({"reference", 0}, again, 6.0);
  EXPECT_EQ(message_of([&] { Replay(recorder.recording(), *damped, again); }),
            "Replay: expected a solver with damping.rate 5, as the recording's, got 6");
  Recording of_substeps = recorder.recording();
  of_substeps.options.max_substeps = 4;
  const std::string path = path_for("substeps.rec");
  save_recording(of_substeps, path);
  EXPECT_EQ(read_recording(path), of_substeps);
  EXPECT_EQ(message_of([&] { Replay(read_recording(path), *recorded, scene_); }),
            "Replay: expected a solver with max_substeps 4, as the recording's, got 1");
  const Model other = make_tetrahedron(0.01);
  Scene other_scene(other);
  const auto small = make_solver("reference", other, other_scene);
  EXPECT_TRUE(refuses([&] { Replay(recorder.recording(), *small, other_scene); }, "is of another body"));
  EXPECT_TRUE(refuses([&] { Replay(recorder.recording(), *small, again); }, "another model"));
  EXPECT_TRUE(refuses([&] { recorder.note("step", ""); }, "four letters"));
}

/// Cells that another body has not, and as many particles: nothing is looked up in it, and nothing is changed.
TEST(RecordingOfACut, IsRefusedByAnotherBody) {
  const auto body = [](int n, std::uint32_t seed) {
    return Simulation(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.03}, n, n, n, 0.2, seed), 300),
                      {.material = {5e3, 0.4, 1000.0}, .backend = "reference"});
  };
  Simulation sim = body(4, 7);
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0, 0}, {1, 0.2, 0.1})));
  sim.remove_cells(std::vector<Index>{200});
  sim.record();
  for (const int n : {4, 2}) {
    Simulation other = body(n, 8);
    const Snapshot before = other.snapshot();
    EXPECT_TRUE(refuses([&] { other.replay(sim.recording()); }, "Replay: the recording is of another body"));
    EXPECT_TRUE(other.cuts().empty());
    EXPECT_TRUE(other.removed_cells().empty());
    EXPECT_EQ(other.snapshot(), before);
  }
}

/// Forward and back: the body is cut as it was there.
TEST(RecordingOfACut, IsSkippedToWithItsCuts) {
  const auto body = [] {
    Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.03}, 4, 3, 3, 0.2, 7), 300),
                   {.material = {5e3, 0.4, 1000.0}, .backend = "reference"});
    sim.scene().fix("x0").gravity({0, 0, -1});
    return sim;
  };
  Simulation sim = body();
  sim.record();
  std::vector<std::uint64_t> at{0};
  const auto go_on = [&] {
    sim.step(2, 1e-4);
    at.push_back(0);
    for (const Input& input : sim.recording().inputs) at.back() += input.times;
  };
  go_on();
  const Snapshot whole = sim.snapshot();
  sim.cut(cut_plane({0.031, 0, 0}, {1, 0.2, 0.1}));
  go_on();
  sim.cut(cut_plane({0, 0.02, 0}, {0.1, 1, 0}));
  go_on();
  ASSERT_EQ(sim.cuts().size(), 2u);
  sim.restore(whole);
  go_on();
  Simulation other = body();
  Replay replay(sim.recording(), other.unrecorded_solver(), other.scene());
  std::size_t cuts = 0;
  replay.on_body = [&](const std::vector<Index>& removed, const BodyCuts& of) {
    cuts = of.size();
    Snapshot there = other.snapshot();
    there.removed_cells = removed;
    there.cuts = of;
    there.topology_hash = fingerprint(other.solver().topology(), removed, of);
    other.restore(there);
  };
  for (const auto& [place, expected] : {std::pair{2, 1u}, {3, 2u}, {1, 0u}, {2, 1u}, {4, 0u}, {2, 1u}, {0, 0u}}) {
    replay.skip_to(at[place]);
    EXPECT_EQ(cuts, expected) << place;
    EXPECT_EQ(other.cuts().size(), expected) << place;
  }
}

std::string small_recording() {
  const Model model = make_tetrahedron(0.01);
  Scene scene = Scene(model).gravity({0, 0, -1});
  const auto solver = make_solver("cpu", model, scene);
  Recorder recorder(*solver, scene);
  const Load load{.particles = {1, 2}, .events = {{0, 1e-4}}, .direction = {1, 0, 0}};
  recorder.step(2, 1e-5);
  scene.add(load);
  recorder.step(2, 1e-5);
  recorder.reset();
  recorder.note("mine", "abc");
  recorder.checkpoint();
  const std::string path = path_for("small.rec");
  save_recording(recorder.recording(), path);
  return text_of(path);
}

TEST(RecordingFile, CutAtEveryByteAndEveryBitTurnedIsRefused) {
  const std::string good = small_recording();
  expect_damage_is_refused(good, [](const std::string& bytes) { read_recording_bytes(bytes, "r"); });
  EXPECT_TRUE(refuses([&] { read_state_bytes(good, "r"); }, "expected a state file"));
}

/// Steps aside, which may be any number.
TEST(RecordingFile, MutantsWithRightChecksumsAreHarmless) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  const auto solver = make_solver("cpu", model, scene);
  expect_mutants_are_harmless({"phymulRe", 6, "a recording"}, {"head", "stat", "scne", "inpt"}, small_recording(),
                              [&](const std::string& file) {
                                Recording recording = read_recording_bytes(file, "r");
                                std::erase_if(recording.inputs, [](const Input& input) {
                                  return input.kind == "step" || input.kind == "rest";
                                });
                                for (Input& input : recording.inputs) input.times = 1;
                                Replay(std::move(recording), *solver, scene).run();
                              });
}

}  // namespace
}  // namespace phymul

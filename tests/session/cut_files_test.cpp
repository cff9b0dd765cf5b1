// SPDX-License-Identifier: MIT
//
// Cuts in states and recordings that were altered, and what a replay of cuts needs besides.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "session/scene_bytes.h"
#include "session/wire_codes.h"
#include "support/message_of.h"

namespace phymul {
namespace {

Simulation cut_file_body() {
  Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.03}, 3, 2, 2, 0.2, 7), 60),
                 {.material = {5e3, 0.4, 1000.0}, .backend = "reference"});
  sim.scene().fix("x0").gravity({0, 0, -1});
  return sim;
}

Input input_of(std::uint64_t stays, const BodyCuts& further) {
  ByteWriter bytes;
  bytes.u64(stays);
  cuts_field(bytes, further);
  return {"cuts", bytes.bytes(), 1};
}

/// Behind right checksums and fingerprints.
TEST(CutFiles, CutsThatDoNotFitTheBodyAreRefusedAndChangeNothing) {
  Simulation sim = cut_file_body();
  const Snapshot whole = sim.snapshot();
  sim.record();
  sim.step(2, 1e-4);
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0, 0}, {1, 0.2, 0.1})));
  sim.step(2, 1e-4);
  const Recording recording = sim.recording();
  const BodyCut good = *sim.cuts().front();
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const auto spare = static_cast<Index>(whole.state.position.size() - 1);
  const auto cells = static_cast<Index>(cut_file_body().model().cells.size());
  const std::function<void(BodyCut&)> alterations[] = {
      [&](BodyCut& cut) { cut.changed.front().row = -1; },
      [&](BodyCut& cut) { cut.changed.back().row = cells; },
      [&](BodyCut& cut) { cut.changed.back().row = 100000000; },
      [&](BodyCut& cut) { std::swap(cut.changed[0], cut.changed[1]); },
      [&](BodyCut& cut) { cut.changed.insert(cut.changed.begin(), cut.changed.front()); },
      [&](BodyCut& cut) { cut.changed[0].before.share = 0.5; },
      [&](BodyCut& cut) { cut.changed[0].before.particles[2] += 1; },
      [&](BodyCut& cut) {
        cut.changed[0].before.cuts.push_back({1, 1, 1, -1});
      },
      [&](BodyCut& cut) { cut.changed[0].after.particles[0] = -1; },
      [&](BodyCut& cut) { cut.changed[0].after.particles[0] = 100000000; },
      [&](BodyCut& cut) { cut.changed[0].after.particles[3] = spare; },
      [&](BodyCut& cut) { cut.changed[0].after.share = 0.0; },
      [&](BodyCut& cut) { cut.changed[0].after.share = 1.5; },
      [&](BodyCut& cut) { cut.changed[0].after.share = nan; },
      [&](BodyCut& cut) { cut.changed[0].after.cuts.at(0)[2] = infinity; },
      [&](BodyCut& cut) { cut.added[0].of = 100000000; },
      [&](BodyCut& cut) { cut.added[0].of = -1; },
      [&](BodyCut& cut) { cut.added[0].part.particles[1] = 100000000; },
      [&](BodyCut& cut) { cut.added[0].part.share = -0.1; },
      [&](BodyCut& cut) { cut.copies[0].particle = 100000000; },
      [&](BodyCut& cut) { cut.copies[0].of = 100000000; },
      [&](BodyCut& cut) { cut.copies[0].of = spare; },
      [&](BodyCut& cut) { std::swap(cut.copies[0].particle, cut.copies[1].particle); },
      [&](BodyCut& cut) { cut.copies.insert(cut.copies.end(), 100, cut.copies[0]); },
      [&](BodyCut& cut) { cut.masses[0].particle = 100000000; },
      [&](BodyCut& cut) { cut.masses[0].before *= 0.5; },
      [&](BodyCut& cut) { cut.masses[0].after = nan; },
      [&](BodyCut& cut) { cut.masses[0].after = -1.0; },
  };
  Simulation other = cut_file_body();
  const auto expect_refused = [&](const char* what, const auto& use) {
    EXPECT_TRUE(refuses(use, "expected a cut of the body as it is now")) << what;
    EXPECT_TRUE(other.cuts().empty());
    EXPECT_EQ(static_cast<Index>(other.model().cells.size()), cells);
  };
  for (std::size_t k = 0; k < std::size(alterations); ++k) {
    SCOPED_TRACE(k);
    BodyCut altered = good;
    alterations[k](altered);
    const BodyCuts cuts{std::make_shared<const BodyCut>(altered)};
    Snapshot state = sim.snapshot();
    state.cuts = cuts;
    state.topology_hash = fingerprint(sim.solver().topology(), {}, cuts);
    expect_refused("restore", [&] { other.restore(state); });
    Recording bad = recording;
    for (Input& input : bad.inputs) {
      if (input.kind == "cuts") input = input_of(0, cuts);
    }
    expect_refused("replay", [&] { other.replay(bad); });
    other.restore(whole);
  }
  Recording twice = recording;
  twice.inputs.push_back(input_of(1, sim.cuts()));
  EXPECT_TRUE(refuses([&] { other.replay(twice); }, "expected a cut of the body as it is now"));
  other.replay(recording);
  EXPECT_EQ(other.snapshot(), sim.snapshot());
}

/// That another one which replays its recording ends as it did.
void expect_same_replay(const Simulation& sim) {
  Simulation other = cut_file_body();
  other.replay(sim.recording());
  EXPECT_EQ(other.snapshot(), sim.snapshot());
}

TEST(CutFiles, AVolumeThatACutOpenedIsOpenInAReplayToo) {
  Simulation sim = cut_file_body();
  sim.scene().constrain_volume();
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0, 0}, {1, 0.2, 0.1})));
  ASSERT_TRUE(sim.scene().is_open(0));
  sim.record();
  for (int k = 0; k < 20; ++k) sim.advance(1e-3);
  Simulation other = cut_file_body();
  other.replay(sim.recording());
  EXPECT_TRUE(other.scene().is_open(0));
  EXPECT_EQ(other.snapshot(), sim.snapshot());
}

/// The pressure acts on a lip of a cut that is undone then.
TEST(CutFiles, APressureWhoseFacetsAreGoneIsReplayed) {
  Simulation sim = cut_file_body();
  const Snapshot whole = sim.snapshot();
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0, 0}, {1, 0.05, 0.02})));
  Load load{.type = LoadType::pressure, .events = {{0, 50}}};
  for (const BodyCut::Copy& copy : sim.cuts().front()->copies) load.particles.push_back(copy.of);
  const VecList rest = sim.model().rest;
  std::erase_if(load.particles, [&](Index i) { return rest[i].y() < 1e-3 || rest[i].y() > 0.039; });
  ASSERT_FALSE(load.particles.empty());
  sim.scene().add(load);
  sim.restore(whole);
  sim.record();
  sim.step(2, 1e-4);
  expect_same_replay(sim);
}

TEST(CutFiles, RemovedCellsOutOfOrderAreRefused) {
  Simulation sim = cut_file_body();
  sim.record();
  sim.step(1, 1e-4);
  Recording recording = sim.recording();
  for (const std::vector<Index>& rows : {std::vector<Index>{9, 3, 7}, {3, 3, 5}}) {
    ByteWriter bytes;
    bytes.field(rows, "");
    recording.inputs = {{"cell", bytes.bytes(), 1}};
    EXPECT_TRUE(refuses([&] { sim.replay(recording); }, "expected rows of removed cells in increasing order"));
    EXPECT_TRUE(sim.removed_cells().empty());
  }
}

/// The removed cells are those of now, and the cuts begin as those of now, but go through a removed cell.
TEST(CutFiles, ACutThroughACellThatWasRemovedIsRestored) {
  Simulation sim = cut_file_body();
  const Snapshot whole = sim.snapshot();
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0, 0}, {1, 0.2, 0.1})));
  const std::vector<Index> removed{sim.cuts().front()->changed.front().row};
  sim.remove_cells(removed);
  const Snapshot wanted = sim.snapshot();
  sim.restore(whole);
  sim.remove_cells(removed);
  sim.restore(wanted);
  Simulation other = cut_file_body();
  other.restore(wanted);
  EXPECT_EQ(sim.model().cells[removed[0]].share, 0.0);
  EXPECT_TRUE(std::ranges::equal(sim.model().cells, other.model().cells));
}

/// The cut added copies to it in the replay, too.
TEST(CutFiles, ALoadThatIsSetAgainAfterACutIsReplayed) {
  Simulation sim = cut_file_body();
  Load load{.type = LoadType::pressure, .events = {{0.0, 50.0}}};
  load.particles = sim.model().particles_in([](const Vec3& x) { return x.y() < 1e-9; });
  sim.scene().add(load);
  const std::size_t row = sim.scene().loads().size() - 1;
  sim.record();
  sim.step(2, 1e-4);
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0, 0}, {1, 0.2, 0.1})));
  ASSERT_GT(sim.scene().loads()[row].particles.size(), load.particles.size());
  sim.scene().replace(row, load);
  sim.step(5, 1e-4);
  Simulation again = cut_file_body();
  again.replay(sim.recording());
  EXPECT_EQ(again.scene().loads()[row].particles, load.particles);
  EXPECT_EQ(again.snapshot(), sim.snapshot());
}

/// Lengths have 32 bits. Nothing is read of this text.
TEST(WireCodes, ATextOfFourGigabytesIsRefused) {
  ByteWriter out;
  EXPECT_TRUE(refuses([&] { out.text({"", std::size_t{1} << 32}); }, "expected less than 4 GiB"));
  EXPECT_TRUE(out.bytes().empty());
}

/// Files made before must stay readable, whatever the order of enumerators and of the shapes of tools.
TEST(WireCodes, NeverChange) {
  const auto first_byte = [](const std::string& bytes) {
    return static_cast<int>(static_cast<unsigned char>(bytes[0]));
  };
  int code = 0;
  for (const LoadType type :
       {LoadType::translation, LoadType::rotation, LoadType::force, LoadType::pressure, LoadType::acceleration}) {
    const Load load{.type = type, .axes = {Axis::driven, Axis::free, Axis::held}};
    const std::string bytes = load_bytes(load);
    EXPECT_EQ(first_byte(bytes), code++);
    EXPECT_EQ(bytes.substr(17, 3), std::string("\2\0\1", 3));  // after the type and two empty lists
    ByteReader in("load", bytes);
    EXPECT_EQ(take_load(in), load);
  }
  code = 0;
  for (const TipHold hold : {TipHold::pulled, TipHold::fixed, TipHold::anchored, TipHold::clamped}) {
    ByteWriter out;
    put_control(out, {.ends = {ThreadEnd{.hold = hold}, ThreadEnd{}}});
    EXPECT_EQ(first_byte(out.bytes()), code++);
  }
  const auto grid =
      std::make_shared<const DistanceGrid>(Vec3::Zero(), 1.0, std::array{2, 2, 2}, std::vector<float>(8, -1.0f));
  code = 0;
  for (const ToolShape& shape :
       {ToolShape(Sphere{1}), ToolShape(Capsule{1, 2}), ToolShape(HalfSpace{}), ToolShape(Box{{1, 1, 1}}),
        ToolShape(grid), ToolShape(Needle{}), ToolShape(Blade{}), ToolShape(Needle{.arc_radius = 0.05, .leaving = 0.1}),
        ToolShape(Blade{.belly = 1, .bow = 2, .height = 3, .friction = 4})}) {
    ByteWriter out;
    tool_fields(out, {.shape = shape});
    EXPECT_EQ(first_byte(out.bytes()), code++);
    ByteReader in("tool", out.bytes());
    Tool tool;
    tool_fields(in, tool);
    EXPECT_EQ(tool.shape.index(), shape.index());
    if (!std::holds_alternative<std::shared_ptr<const DistanceGrid>>(shape)) {
      EXPECT_EQ(tool.shape, shape);
    }
  }
  code = 0;
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    ByteWriter out;
    tool_fields(out, {.shape = Sphere{1}, .contact = contact});
    EXPECT_EQ(out.bytes().back(), code++);
    ByteReader in("tool", out.bytes());
    Tool tool;
    tool_fields(in, tool);
    EXPECT_EQ(tool.contact, contact);
    ByteWriter drawing;
    tool_fields(drawing, {.shape = Sphere{1}, .contact = contact, .suction = 0.5, .suction_reach = 0.25});
    const std::string bytes = drawing.bytes();
    EXPECT_EQ(bytes[out.bytes().size() - 1], 2 + static_cast<int>(contact));
    ByteReader again("tool", bytes);
    tool_fields(again, tool);
    EXPECT_EQ(tool.contact, contact);
    EXPECT_EQ(tool.suction, 0.5);
    EXPECT_EQ(tool.suction_reach, 0.25);
  }
  std::string unknown;
  {
    ByteWriter out;
    tool_fields(out, {.shape = Sphere{1}});
    unknown = out.bytes();
  }
  unknown.back() = 4;
  ByteReader in("tool", unknown);
  Tool tool;
  EXPECT_TRUE(refuses([&] { tool_fields(in, tool); }, "expected a tool's contact, a number below 4, got 4"));
}

}  // namespace
}  // namespace phymul

// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>

#include <limits>
#include <numbers>

#include "model/file_extras.h"

namespace phymul {
namespace {

/// Twenty atoms without file indices, and a group.
Model line_model() {
  Model model = make_block({0.04, 0.01, 0.01}, 4, 1, 1);
  model.add_group("Tip", {3, 1});
  return model;
}

std::string load_text(const std::string& type, const std::string& children) {
  return "<loads xmlns:xsi=\"x\">\n<load xsi:type=\"" + type + "\">\n" + children + "\n</load>\n</loads>";
}

const std::string event = "<valueEvent date=\"0\" value=\"1\"/>";
const std::string along_z = "<direction z=\"1\"/>";

std::vector<Load> read_text(const std::string& text, std::vector<std::string>* notes = nullptr) {
  return read_lml_text(text, "t.lml", line_model(), notes);
}

Load read_one(const std::string& type, const std::string& children) {
  const std::vector<Load> loads = read_text(load_text(type, children));
  EXPECT_EQ(loads.size(), 1u);
  return loads.front();
}

std::string lml_refusal(const std::string& text) {
  return message_of([&] { read_text(text); });
}

std::vector<Index> targets(const std::string& text) {
  return read_one("Force", "<appliedTo>" + text + "</appliedTo>" + event + along_z + "<unit>N</unit>").particles;
}

std::vector<Load> rewritten(const std::vector<Load>& loads, const Model& model) {
  std::ostringstream out;
  write_lml(loads, model, out);
  return read_lml_text(out.str(), "again.lml", model);
}

TEST(LmlRead, Sample) {
  const Model model = read_pml(sample_data + "/cylinder_275.pml");
  std::vector<std::string> notes;
  const std::vector<Load> loads = read_lml(sample_data + "/cylinder_275_pull.lml", model, &notes);
  EXPECT_TRUE(notes.empty());
  ASSERT_EQ(loads.size(), 3u);
  EXPECT_EQ(loads[0].type, LoadType::translation);
  EXPECT_EQ(loads[0].axes, (std::array{Axis::held, Axis::held, Axis::held}));
  EXPECT_EQ(loads[0].particles.size(), 25u);
  EXPECT_EQ(loads[0].applied_to, "0-24");
  EXPECT_EQ(loads[1].axes, (std::array{Axis::free, Axis::free, Axis::driven}));
  EXPECT_EQ(loads[1].direction, Vec3(0, 0, 1));
  EXPECT_EQ(loads[1].events, (std::vector<ValueEvent>{{0, 0}, {1, 0.005}, {2, 0}}));
  EXPECT_EQ(loads[2].particles.size(), 275u);
  EXPECT_EQ(loads[2].events, (std::vector<ValueEvent>{{0, 9.81}}));
  EXPECT_EQ(rewritten(loads, model), loads);
  Scene scene = Scene(model).add(loads);
  EXPECT_EQ(scene.loads(), loads);
}

TEST(LmlRead, EveryDialect) {
  const std::string body = "<appliedTo>1</appliedTo>" + event + along_z + "<unit>N</unit>";
  const Load expected = read_one("Force", body);
  for (const std::string& text :
       {"<loads><load type=\"Force\">" + body + "</load></loads>",
        "<loads xmlns='http://www-timc.imag.fr/load'><load xsi:type=\"Force\">" + body + "</load></loads>",
        "<l:loads xmlns:l='http://www-timc.imag.fr/load'><l:load xsi:type='l:Force'><l:appliedTo>1</l:appliedTo>" +
            event + along_z + "<l:unit>N</l:unit></l:load></l:loads>",
        "<loads><load type='Force'><unit> N\n</unit>" + along_z + event +
            "<appliedTo> 1 </appliedTo></load></loads>"}) {
    EXPECT_EQ(read_text(text), std::vector<Load>{expected}) << text;
  }
}

TEST(LmlRead, AppliedTo) {
  EXPECT_EQ(targets("1, 2,3"), (std::vector<Index>{1, 2, 3}));
  EXPECT_EQ(targets("1,3,5-7"), (std::vector<Index>{1, 3, 5, 6, 7}));
  EXPECT_EQ(targets(" 5 - 7 ,6,5"), (std::vector<Index>{5, 6, 7}));
  EXPECT_EQ(targets("Tip"), (std::vector<Index>{1, 3}));
  EXPECT_EQ(targets("8, Tip"), (std::vector<Index>{8, 1, 3}));
  EXPECT_EQ(targets("*").size(), static_cast<std::size_t>(line_model().particle_count()));
}

TEST(LmlRead, CommentsPartNoText) {
  EXPECT_EQ(targets("0,1<!-- and --> ,2"), (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(targets("0,<![CDATA[1]]>,2<?phymul generated?>"), (std::vector<Index>{0, 1, 2}));
  const std::string head = "<appliedTo>1</appliedTo>" + event + along_z;
  EXPECT_EQ(read_one("Translation", head + "<unit>m<!-- metre -->m</unit>").events[0].value, 1e-3);
  EXPECT_EQ(lml_refusal(load_text("Force", "<appliedTo>1,<b>2</b></appliedTo>" + event + along_z + "<unit>N</unit>")),
            "t.lml:3: expected text alone in <appliedTo>, got <b>");
}

TEST(LmlRead, AppliedToMeansFileIndices) {
  Model model = line_model();
  change_extras(model, [&](FileExtras& extras) {
    for (Index i = model.particle_count() - 1; i >= 0; --i) extras.particle_index.push_back(100 + 2 * i);
  });
  const auto with = [&](const std::string& text) {
    return read_lml_text(load_text("Force", "<appliedTo>" + text + "</appliedTo>" + event + along_z + "<unit>N</unit>"),
                         "t.lml", model);
  };
  EXPECT_EQ(with("100,104").front().particles,
            (std::vector<Index>{model.particle_count() - 1, model.particle_count() - 3}));
  EXPECT_EQ(message_of([&] { with("100-104"); }),
            "t.lml:3: appliedTo: expected the index of an atom, got 101, which no atom of the model has");
  EXPECT_EQ(rewritten(with("104,100"), model), with("104,100"));
  Load built = with("104,100").front();
  built.applied_to.clear();
  EXPECT_EQ(rewritten({built}, model), std::vector<Load>{built});
}

TEST(LmlRead, Units) {
  const struct {
    const char* type;
    const char* unit;
    double si;
  } rows[] = {{"Translation", "mm", 2e-3},
              {"Translation", "micron", 2e-6},
              {"Translation", "microm", 2e-6},
              {"Translation", "nm", 2e-9},
              {"Translation", "m", 2},
              {"Rotation", "radian", 2},
              {"Rotation", "radians", 2},
              {"Rotation", "degree", 2 * std::numbers::pi / 180},
              {"Rotation", "degrees", 2 * std::numbers::pi / 180},
              {"Force", "N", 2},
              {"Force", "kN", 2e3},
              {"Force", "pN", 2e-12},
              {"Pressure", "kPa", 2e3},
              {"Pressure", "mmHg", 266.64477483},
              {"Pressure", "Pa", 2},
              {"Acceleration", "m/s^2", 2},
              {"Acceleration", "cm/s^2", 2e-2},
              {"Acceleration", "mm/s^2", 2e-3}};
  for (const auto& row : rows) {
    const Load load = read_one(row.type, "<appliedTo>1</appliedTo><valueEvent date=\"0.5\" value=\"2\"/>" + along_z +
                                             "<unit>" + row.unit + "</unit>");
    ASSERT_EQ(load.events.size(), 1u);
    EXPECT_DOUBLE_EQ(load.events[0].value, row.si) << row.unit;
    EXPECT_EQ(load.events[0].date, 0.5);
    EXPECT_EQ(rewritten({load}, line_model()), std::vector<Load>{load}) << row.unit;
  }
}

TEST(LmlRead, AMissingUnitIsAssumedAndNoted) {
  std::vector<std::string> notes;
  const std::string body = "<appliedTo>1</appliedTo>" + event + along_z;
  EXPECT_EQ(read_text(load_text("Rotation", body), &notes).front().events[0].value, 1.0);
  EXPECT_EQ(read_text(load_text("Translation", body), &notes).front().events[0].value, 1e-3);
  EXPECT_EQ(notes, (std::vector<std::string>{"t.lml:2: no <unit> in a load of type Rotation: radian is assumed",
                                             "t.lml:2: no <unit> in a load of type Translation: mm is assumed"}));
}

TEST(LmlRead, Directions) {
  const auto load = [](const std::string& direction) {
    return read_one("Translation", "<appliedTo>1</appliedTo>" + event + direction + "<unit>mm</unit>");
  };
  EXPECT_EQ(load("<direction x=\"NULL\" z=\"-2.5\"/>").axes, (std::array{Axis::held, Axis::free, Axis::driven}));
  EXPECT_EQ(load("<direction x=\"NULL\" z=\"-2.5\"/>").direction, Vec3(0, 0, -2.5));
  EXPECT_EQ(load("<direction toward=\"4\"/>").toward, 4);
  EXPECT_EQ(load("<direction toward=\"4\"/>").axes, (std::array{Axis::driven, Axis::driven, Axis::driven}));
  EXPECT_EQ(load("<direction toward=\"4\" y=\"NULL\"/>").axes[1], Axis::held);
  for (const char* const direction :
       {"<direction x=\"NULL\" y=\"NULL\" z=\"NULL\"/>", "<direction x=\"NULL\" z=\"-2.5\"/>",
        "<direction toward=\"4\"/>", "<direction toward=\"4\" y=\"NULL\"/>", "<direction/>"}) {
    EXPECT_EQ(rewritten({load(direction)}, line_model()), std::vector<Load>{load(direction)}) << direction;
  }
}

/// What would do something at any of its dates needs to be told where to.
TEST(LmlRead, ADirectionOfNoLengthIsForLoadsThatAreNeverMeant) {
  const auto load = [](const std::string& events) {
    return read_one("Force",
                    "<appliedTo>1</appliedTo>" + events + "<direction x=\"0\" y=\"0\" z=\"0\"/><unit>N</unit>");
  };
  EXPECT_EQ(load("<valueEvent date=\"0\" value=\"0\"/><valueEvent date=\"1\" value=\"0\"/>").events.size(), 2u);
  for (const char* const values : {"<valueEvent date=\"0\" value=\"0\"/><valueEvent date=\"1\" value=\"2\"/>",
                                   "<valueEvent date=\"0\" value=\"2\"/><valueEvent date=\"1\" value=\"0\"/>"}) {
    EXPECT_TRUE(refuses([&] { load(values); }, "expected a direction of a length above 0")) << values;
  }
}

TEST(LmlRead, FixityNeedsNoValue) {
  const Load load =
      read_one("Translation", "<appliedTo>1</appliedTo><direction x=\"NULL\" y=\"NULL\" z=\"NULL\"/><unit>mm</unit>");
  EXPECT_TRUE(load.events.empty());
  EXPECT_EQ(rewritten({load}, line_model()), std::vector<Load>{load});
}

TEST(LmlRead, PressureWithoutDirectionPressesInward) {
  const Load load = read_one("Pressure", "<appliedTo>*</appliedTo>" + event + "<unit>kPa</unit>");
  EXPECT_EQ(load.direction, Vec3(0, 0, 0));
  EXPECT_EQ(load.axes, (std::array{Axis::driven, Axis::driven, Axis::driven}));
  EXPECT_EQ(rewritten({load}, line_model()), std::vector<Load>{load});
}

TEST(LmlRead, EventsAreSortedAndStepsKeepTheirOrder) {
  const Load load = read_one("Force",
                             "<appliedTo>1</appliedTo><valueEvent date=\"2\" value=\"3\"/>"
                             "<valueEvent date=\"1\" value=\"5\"/><valueEvent date=\"1\" value=\"0\"/>" +
                                 along_z + "<unit>N</unit>");
  EXPECT_EQ(load.events, (std::vector<ValueEvent>{{1, 5}, {1, 0}, {2, 3}}));
  EXPECT_EQ(value_at(load.events, 1.0), 0.0);
}

TEST(LmlRead, UnknownElementsAreNoted) {
  std::vector<std::string> notes;
  read_text(load_text("Force", "<appliedTo>1</appliedTo>" + event + along_z + "<unit>N</unit>\n<colour/>"), &notes);
  EXPECT_EQ(notes, std::vector<std::string>{"t.lml:4: unknown element <colour> in <load> was skipped"});
}

TEST(LmlWrite, BuiltLoadsComeBackEqual) {
  const Model model = line_model();
  const Load load{.type = LoadType::force,
                  .particles = {5, 6, 7, 2, 9, 8},
                  .events = {{0, 1.0 / 3}, {0.1, -2e-7}},
                  .direction = {0.1, 0.2, 1.0 / 7}};
  Load turn = load;
  turn.type = LoadType::rotation;
  Load named = load;
  named.particles = {1, 3};
  named.applied_to = "Tip";
  Load press = load;
  press.type = LoadType::pressure;
  EXPECT_EQ(rewritten({load, turn, named, press}, model), (std::vector<Load>{load, turn, named, press}));
  EXPECT_TRUE(rewritten({}, model).empty());
  std::ostringstream out;
  write_lml({load}, model, out);
  EXPECT_TRUE(says(out.str(), "<appliedTo>5-7,2,9,8</appliedTo>"));
}

TEST(LmlRead, ATargetWithoutParticlesIsNoted) {
  Model model = line_model();
  model.add_group("Nobody", {});
  std::vector<std::string> notes;
  const std::vector<Load> loads = read_lml_text(
      load_text("Force", "<appliedTo>Nobody</appliedTo>" + event + along_z + "<unit>N</unit>"), "t.lml", model, &notes);
  EXPECT_TRUE(loads.front().particles.empty());
  EXPECT_EQ(notes, std::vector<std::string>{"t.lml:3: appliedTo: \"Nobody\" has no particles; the load does nothing"});
}

TEST(LmlWrite, WordsThatNoLongerMeanTheParticlesGiveWay) {
  const Load load{
      .type = LoadType::force, .particles = {5, 6}, .events = {{0, 1}}, .direction = {0, 0, 1}, .applied_to = "Tip"};
  const std::vector<Load> again = rewritten({load}, line_model());
  EXPECT_EQ(again.front().particles, load.particles);
  EXPECT_EQ(again.front().applied_to, "");
}

TEST(LmlWrite, RefusesWhatLmlCannotSay) {
  const Model model = line_model();
  Load load{.events = {{0, 1}}};
  EXPECT_EQ(message_of([&] { rewritten({load}, model); }), "Force: expected at least one particle, got none");
  load.particles = {100};
  EXPECT_EQ(message_of([&] { rewritten({load}, model); }), "Force: expected particles of the model, got 100");
  load.particles = {1};
  load.toward = 2;
  load.axes[0] = Axis::free;
  EXPECT_TRUE(refuses([&] { rewritten({load}, model); }, "no free axis beside toward"));
  load = {};
  load.particles = {1};
  load.events = {{0, std::numeric_limits<double>::infinity()}};
  EXPECT_EQ(message_of([&] { rewritten({load}, model); }), "Force: expected finite dates and values");
  load.events = {{0, 1}};
  load.direction.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of([&] { rewritten({load}, model); }), "Force: expected a finite direction");
}

TEST(LmlErrors, AppliedTo) {
  const auto message = [](const std::string& text) {
    return lml_refusal(load_text("Force", "<appliedTo>" + text + "</appliedTo>" + event + along_z + "<unit>N</unit>"));
  };
  const std::string at = "t.lml:3: appliedTo: ";
  EXPECT_EQ(message("999"), at + "expected the index of an atom, got 999, which no atom of the model has");
  EXPECT_EQ(message("-1"), at + "expected the index of an atom, got -1, which no atom of the model has");
  EXPECT_EQ(message("-9223372036854775808-9223372036854775807"),
            at + "expected the index of an atom, got -9223372036854775808, which no atom of the model has");
  EXPECT_EQ(message("3-2000000000"), at + "expected the index of an atom, got 20, which no atom of the model has");
  EXPECT_EQ(message("7-5"), at + "expected a range from its smaller to its larger index, got \"7-5\"");
  EXPECT_EQ(message("1,,2"), at + "expected indices, ranges, names or * between commas, got nothing in \"1,,2\"");
  EXPECT_EQ(message(""), at + "expected indices, ranges, names or * between commas, got nothing in \"\"");
  EXPECT_EQ(message("1.5"), at + "expected an index, a range like 5-7, a name or *, got \"1.5\"");
  EXPECT_EQ(message("1 2"), at + "expected an index, a range like 5-7, a name or *, got \"1 2\"");
  EXPECT_EQ(message("Top").rfind(at + "expected the name of a group, got \"Top\": known groups are", 0), 0u)
      << message("Top");
  EXPECT_TRUE(says(message("Top"), "\"Tip\""));
}

TEST(LmlErrors, Units) {
  const auto message = [](const std::string& type, const std::string& unit) {
    return lml_refusal(load_text(type, "<appliedTo>1</appliedTo>" + event + along_z + "\n<unit>" + unit + "</unit>"));
  };
  EXPECT_EQ(message("Force", "lbf"), "t.lml:4: expected a unit of a load of type Force (N, kN, pN), got \"lbf\"");
  EXPECT_EQ(message("Force", "mm"), "t.lml:4: expected a unit of a load of type Force (N, kN, pN), got \"mm\"");
  EXPECT_EQ(message("Translation", "radian"),
            "t.lml:4: expected a unit of a load of type Translation (mm, micron, microm, nm, m), got \"radian\"");
}

TEST(LmlErrors, Loads) {
  const std::string target = "<appliedTo>1</appliedTo>";
  EXPECT_EQ(lml_refusal("<physicalModel/>"),
            "t.lml:1: expected <loads>, got <physicalModel>; read bodies with read_pml");
  EXPECT_EQ(lml_refusal(load_text("Heat", target)),
            "t.lml:2: expected attribute xsi:type (or type) of <load> to be one of Translation, Rotation, Force, "
            "Pressure, Acceleration, got \"Heat\"");
  EXPECT_EQ(lml_refusal("<loads><load/></loads>"),
            "t.lml:1: expected attribute xsi:type (or type) of <load> to be one of Translation, Rotation, Force, "
            "Pressure, Acceleration, got none");
  EXPECT_EQ(lml_refusal(load_text("Force", event + along_z)), "t.lml:2: expected <appliedTo> in <load>, got none");
  EXPECT_EQ(lml_refusal(load_text("Force", target + "\n" + target)),
            "t.lml:4: expected one <appliedTo> in <load>, got a second one; the first is on line 3");
  EXPECT_EQ(lml_refusal(load_text("Force", target + event)),
            "t.lml:2: expected <direction> in a load of type Force, got none");
  EXPECT_EQ(lml_refusal(load_text("Force", target + along_z)),
            "t.lml:2: expected at least one <valueEvent> in <load>, got none");
  EXPECT_EQ(lml_refusal(load_text("Force", target + along_z + "\n<valueEvent date=\"0\" value=\"1,5\"/>")),
            "t.lml:4: expected a finite number with a decimal point in value, got \"1,5\"");
  EXPECT_EQ(lml_refusal(load_text("Force", target + along_z + "\n<valueEvent value=\"1\"/>")),
            "t.lml:4: expected attribute \"date\" in <valueEvent>, got none");
  EXPECT_EQ(lml_refusal(load_text("Force", target + event + "\n<direction x=\"up\"/>")),
            "t.lml:4: expected a finite number with a decimal point in x, got \"up\"");
  EXPECT_EQ(lml_refusal(load_text("Force", target + event + "\n<direction x=\"0\" y=\"0\" z=\"0\"/>")),
            "t.lml:4: expected a direction of a length above 0, got (0, 0, 0); write NULL to hold an axis");
  EXPECT_EQ(lml_refusal(load_text("Rotation", target + event + "\n<direction x=\"NULL\"/>")),
            "t.lml:4: expected the axis of a rotation, of a length above 0, in <direction>");
  EXPECT_EQ(lml_refusal(load_text("Force", target + event + "\n<direction toward=\"99\"/>")),
            "t.lml:4: toward: expected the index of an atom, got 99, which no atom of the model has");
  EXPECT_EQ(lml_refusal(load_text("Force", target + event + "\n<direction toward=\"-1\"/>")),
            "t.lml:4: expected a whole number from 0 to 2147483647 in toward of <direction>, got \"-1\"");
  EXPECT_EQ(lml_refusal(load_text("Force", target + event + "\n<direction toward=\"1\" x=\"1\"/>")),
            "t.lml:4: expected toward or coordinates in <direction>, got toward and x=\"1\"");
  EXPECT_EQ(lml_refusal("<loads>\n<load>").rfind("t.lml:2: expected well-formed XML", 0), 0u);
}

}  // namespace
}  // namespace phymul

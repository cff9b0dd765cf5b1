// SPDX-License-Identifier: MIT
#include "session/wire_codes.h"

#include <gtest/gtest.h>
#include <phymul/distance_grid.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "session/scene_bytes.h"
#include "support/message_of.h"

namespace phymul {
namespace {

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

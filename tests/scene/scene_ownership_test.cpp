// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/scene.h>
#include <phymul/shapes.h>

#include <memory>

#include "support/message_of.h"

namespace phymul {
namespace {

TEST(SceneOwnership, SharesOwnershipOfItsModel) {
  auto model = std::make_shared<const Model>(make_block({1, 1, 1}, 1, 1, 1));
  const std::weak_ptr<const Model> watched = model;
  auto scene = std::make_unique<Scene>(std::move(model));
  const Scene copy = scene->copy();
  scene.reset();
  ASSERT_FALSE(watched.expired());
  EXPECT_EQ(copy.model().particle_count(), 8);
  EXPECT_TRUE(refuses([] { Scene(std::shared_ptr<const Model>()); }, "got null"));
}

TEST(SceneOwnership, GivesToolsNamesAndHandles) {
  const Model model = make_block({1, 1, 1}, 1, 1, 1);
  Scene scene(model);
  const ToolHandle ball = scene.add_tool(Sphere{0.1});
  const ToolHandle rod = scene.add_tool({.shape = Capsule{0.1, 0.2}, .friction = 0.5});
  rod.move_to({.position = {1, 2, 3}});
  EXPECT_EQ(scene.tools().at(0).name, "tool 1");
  EXPECT_EQ(scene.tools().at(1).name, "tool 2");
  EXPECT_EQ(scene.tool("tool 2").target_pose().position, Vec3(1, 2, 3));
  EXPECT_NE(ball.id(), rod.id());
  EXPECT_TRUE(ball.is_of(scene));
  const auto probe = scene.add_tool("probe", {.shape = Sphere{0.1}});
  const auto rope = scene.add_joint("rope", {.springs = {{at_particle(0), at_world({0, 0, 1})}}});
  EXPECT_EQ(probe.id(), scene.tool("probe").id());
  EXPECT_EQ(rope.id(), scene.joint("rope").id());
}

}  // namespace
}  // namespace phymul

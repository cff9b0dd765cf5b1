// SPDX-License-Identifier: MIT
//
// Sewn threads keep their length where knots are tied and loosened, and where no passage is left.
#include "support/joined_particles.h"

namespace phymul::test {
namespace {

/// m, of all its segments and knots.
double whole_length(const Zigzag& body) {
  double sum = body.length();
  for (const KnotState& knot : body.state().knots) sum += knot.rest_length;
  return sum;
}

double way_through(int passages) {
  const VecList places = Zigzag::places(passages);
  double way = 0.0;
  for (std::size_t k = 1; k < places.size(); ++k) way += (places[k] - places[k - 1]).norm();
  return way;
}

TEST(StitchLength, AKnotThatIsLoosenedMakesNoThread) {
  const double way = way_through(5);
  for (const double tails : {0.0, 0.01, 0.1}) {
    SCOPED_TRACE(tails);
    Zigzag body({.length = way + tails});
    body.run(1);
    body.thread->tie(0, 3, 2);
    body.run(1);
    body.thread->loosen(0, 3);
    body.run(1);
    EXPECT_NEAR(whole_length(body), way + tails, 1e-12);
  }
}

/// One tail is drawn short before: the other has what the knot takes.
TEST(StitchLength, AKnotTakesFromTheTailThatHasMore) {
  const double way = way_through(5);
  Zigzag body({.length = way + 0.1, .friction = 0.0});
  body.thread->fix(ThreadTip::first);
  body.run(1);
  body.thread->join(ThreadTip::first, at_world(Zigzag::places(1)[0] + Vec3(-0.05, 0, 0)));
  body.run(1);
  const double before = whole_length(body);
  body.thread->tie(0, 3, 2);
  body.run(1);
  ASSERT_EQ(body.state().knots.size(), 1u);
  EXPECT_GT(body.state().knots[0].rest_length, 0.01);
  EXPECT_NEAR(whole_length(body), before, 1e-12);
  body.thread->loosen(0, 3);
  body.run(1);
  EXPECT_NEAR(whole_length(body), before, 1e-12);
}

/// Both ends of a knot bear the same force: both passages let go at once.
TEST(StitchLength, AKnotBreaksWithThePassagesThatItTies) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
  Scene scene(model);
  scene.fix(std::vector<Index>{0});
  scene.add(Load{.type = LoadType::force, .particles = {1}, .events = {{0.0, 1.5}}, .direction = {1, 0, 0}});
  const ThreadHandle thread = scene.sew("s", {.length = 0.05, .passage_limit = 1.0, .throw_holding = 100},
                                        std::vector<Anchor>{at_particle(0), at_particle(1)});
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) thread.pull(tip, Vec3::Zero());
  thread.tie(0, 1, 4);
  const auto solver = loose_solver("reference", model, scene, {.damping = {.rate = 50.0}});
  ASSERT_TRUE(solver->step(400, 0.5e-3).ok());
  const ThreadState& end = solver->thread_state(thread);
  ASSERT_EQ(end.torn, 2);
  ASSERT_EQ(end.knots.size(), 1u);
  EXPECT_TRUE(end.knots[0].broken);
  EXPECT_EQ(end.knots[0].tension, 0.0);
}

TEST(StitchLength, AThreadWithoutPassagesKeepsItsLengthWhenATipIsJoined) {
  Zigzag body({.length = 0.1, .friction = 0.05}, 4);
  body.scene.add_tool("hand", {.shape = Sphere{1e-3}, .pose = {.position = {0.04, 0.02, 0}}});
  body.thread->pull(ThreadTip::first, {0, 0, 0});
  body.thread->join(ThreadTip::last, at_tool("hand"));
  body.run(1);
  body.scene.tool("hand").move_to({.position = {0.2, 0.02, 0}});
  body.run(400);
  ASSERT_TRUE(body.state().passages.empty());
  body.thread->pull(ThreadTip::last, {0, 0, 0});
  body.run(1);
  const double before = body.length();
  body.thread->join(ThreadTip::last, at_world({0.5, 0, 0}));
  body.run(1);
  EXPECT_NEAR(body.length(), before, 1e-12);
}

}  // namespace
}  // namespace phymul::test

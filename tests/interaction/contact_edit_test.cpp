// SPDX-License-Identifier: MIT
//
// Candidates of contacts of a body that is cut while it moves: lists of what a cut does not touch stay, and none lacks
// what counts.
#include <gtest/gtest.h>

#include <phymul/body_cut.h>
#include <phymul/shapes.h>

#include <algorithm>
#include <random>
#include <vector>

#include "support/run_scenes.h"
#include "support/touching_bodies.h"

namespace phymul {
namespace {

using namespace test;

/// A plane across the lower block, under the upper one, as far as y.
CutSurface slit_to(double y, double x) {
  CutSurface cut = cut_plane({x, 0.0, 0.0}, {1.0, 0.1, 0.03});
  cut.front = [y](const Vec3& at) { return at.y() - y; };
  return cut;
}

Model block_of_two() {
  Model low = make_tetrahedral_block({0.045, 0.03, 0.02}, 9, 6, 4, 0.2, 4);
  set_material(low, {1e4, 0.3, 1000.0});
  Model high = make_tetrahedral_block({0.02, 0.02, 0.01}, 4, 4, 2, 0.2, 9);
  set_material(high, {1e4, 0.3, 1000.0});
  return joined_bodies(low, moved(std::move(high), {0.0113, 0.0037, 0.0203}));
}

/// A slit that grows, another, cells that go and come, and steps back, while all is shaken; now and then two edits
/// between steps.
TEST(ContactEdits, ListAllThatCounts) {
  const Model whole = block_of_two();
  std::vector<ContactSurface> surfaces;
  Model body = with_spare_particles(whole, 400);
  for (const double y : {0.006, 0.011, 0.017}) {
    surfaces.push_back(make_contact_surface(cut_body(body, slit_to(y, 0.0212))));
  }
  Model crossed = cut_body(cut_body(body, slit_to(0.017, 0.0212)), slit_to(0.012, 0.0391));
  surfaces.push_back(make_contact_surface(crossed));
  std::vector<char> is_there(crossed.rest.size(), 0);
  for (Cell& cell : crossed.cells) {  // a pit, whose bottom is out of reach of the upper block
    Vec3 centre = Vec3::Zero();
    for (const Index i : cell.particles) centre += 0.25 * crossed.rest[i];
    const Vec3 off = (centre - Vec3(0.021, 0.015, 0.02)).cwiseQuotient(Vec3(0.014, 0.02, 0.016));
    if (off.cwiseAbs().maxCoeff() < 1.0 && centre.z() < 0.02) cell.share = 0.0;
    for (const Index i : cell.particles) is_there[i] = is_there[i] != 0 || cell.share > 0.0;
  }
  for (std::size_t i = 0; i < is_there.size(); ++i) crossed.mass[i] *= is_there[i];
  surfaces.push_back(make_contact_surface(crossed));
  std::mt19937 bits(3);
  ContactCandidates candidates;
  const ContactSurface* before = nullptr;
  std::size_t counting = 0, steps = 0, searches = 0, edits = 0;
  const auto shaken = [&](const ContactSurface& surface, const Vec3& by) {
    VecList place = surface.rest;
    for (std::size_t k = 0; k < place.size(); ++k) {
      place[k] += 1e-4 * random_vector(bits, 3) + (surface.particles[k].body == 1 ? by : Vec3(0, 0, 0));
    }
    return place;
  };
  for (const std::size_t row : {0u, 1u, 2u, 3u, 4u, 3u, 4u, 3u, 2u, 1u}) {
    const ContactSurface& surface = surfaces[row];
    candidates.follow(surface, {}, before);
    before = &surface;
    if (++edits % 4 == 3) continue;  // the next edit comes before a step
    for (int step = 0; step < 2; ++step, ++steps) {
      candidates.jump();
      const VecList place = shaken(surface, {0, 0, -3e-5 * static_cast<double>(steps)});
      const Pairs wanted = pairs_that_count(surface, place, {}, 1e-4);
      const std::size_t searched = candidates.searches();
      const Pairs listed = pairs_listed(candidates, place, 1e-4);
      searches += candidates.searches() - searched;
      counting += wanted.size();
      ASSERT_TRUE(std::ranges::includes(listed, wanted)) << row << ", step " << step;
    }
  }
  EXPECT_GT(counting, 1000u);
  EXPECT_LT(searches, steps / 4) << steps;
}

/// A beam comes back that stands out from a wall, over a floor and toward a block which had the floor alone in its
/// lists: no triangle that these have goes.
TEST(ContactEdits, NewTrianglesJoinListsThatStay) {
  constexpr double cell = 0.005;  // m
  Model low = make_tetrahedral_block({6 * cell, 2 * cell, 3 * cell}, 6, 2, 3, 0.0, 1);
  Model high = make_tetrahedral_block({cell, cell, cell}, 1, 1, 1, 0.0, 1);
  for (Model* const model : {&low, &high}) set_material(*model, {1e4, 0.3, 1000.0});
  const Model whole = joined_bodies(low, moved(std::move(high), {0.003, 0.0024, 0.0105}));
  const auto without = [&](auto is_gone) {
    Model model = whole;
    std::vector<char> is_there(model.rest.size(), 0);
    for (Cell& own : model.cells) {
      Vec3 centre = Vec3::Zero();
      for (const Index i : own.particles) centre += 0.25 * model.rest[i];
      const bool of_low = own.particles[0] < low.particle_count();
      if (of_low && centre.x() < 4 * cell && centre.z() > cell && is_gone(centre)) own.share = 0.0;
      for (const Index i : own.particles) is_there[i] = is_there[i] != 0 || own.share > 0.0;
    }
    for (std::size_t i = 0; i < is_there.size(); ++i) model.mass[i] *= is_there[i];
    return make_contact_surface(model);
  };
  const ContactSurface bare = without([](const Vec3&) { return true; });
  const ContactSurface beam = without([](const Vec3& at) { return at.x() < 2 * cell || at.z() < 2 * cell; });
  ContactCandidates candidates;
  candidates.follow(bare, {});
  EXPECT_FALSE(pairs_listed(candidates, bare.rest, 1e-4).empty());
  candidates.follow(beam, {}, &bare);
  const Pairs listed = pairs_listed(candidates, beam.rest, 1e-4), wanted = pairs_that_count(beam, beam.rest, {}, 1e-4);
  EXPECT_TRUE(std::ranges::includes(listed, wanted));
  EXPECT_FALSE(wanted.empty());
  EXPECT_EQ(candidates.searches(), 1u);
}

}  // namespace
}  // namespace phymul

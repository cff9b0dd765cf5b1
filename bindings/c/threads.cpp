// SPDX-License-Identifier: MIT
//
// Threads, clips, fluids and tearing.
#include "named.h"

using namespace phymul;
using namespace phymul::c;

static_assert(static_cast<int>(ThreadTip::last) == PHYMUL_LAST);
static_assert(static_cast<int>(FluidLaw::gas) == PHYMUL_GAS && static_cast<int>(FluidLaw::curve) == PHYMUL_CURVE);

namespace {

constexpr Constant<phymul_thread, Thread> thread_constants[] = {
    {&phymul_thread::length, &Thread::length},
    {&phymul_thread::radius, &Thread::radius},
    {&phymul_thread::young, &Thread::young},
    {&phymul_thread::bending_stiffness, &Thread::bending_stiffness},
    {&phymul_thread::density, &Thread::density},
    {&phymul_thread::segment, &Thread::segment},
    {&phymul_thread::damping, &Thread::damping},
    {&phymul_thread::friction, &Thread::friction},
    {&phymul_thread::channel_friction, &Thread::channel_friction},
    {&phymul_thread::breaking_force, &Thread::breaking_force},
    {&phymul_thread::passage_limit, &Thread::passage_limit},
    {&phymul_thread::throw_holding, &Thread::throw_holding}};

constexpr Constant<phymul_clip, Clip> clip_constants[] = {
    {&phymul_clip::gap, &Clip::gap}, {&phymul_clip::holding, &Clip::holding}, {&phymul_clip::opening, &Clip::opening}};

constexpr Constant<phymul_fluid, Fluid> fluid_constants[] = {{&phymul_fluid::outer_pressure, &Fluid::outer_pressure},
                                                             {&phymul_fluid::exponent, &Fluid::exponent},
                                                             {&phymul_fluid::conductance, &Fluid::conductance}};

ThreadHandle thread_of(phymul_simulation* sim, uint64_t thread) {
  Scene& scene = scene_of(sim);
  return scene.thread(name_of(scene.threads(), thread, "thread"));
}

/// Changes a thread, at a tip.
template <class Change>
phymul_status at_tip(phymul_simulation* sim, uint64_t thread, int32_t tip, Change&& change) {
  return guarded([&] {
    require_kind(tip, PHYMUL_FIRST, 2, "a tip");
    change(thread_of(sim, thread), static_cast<ThreadTip>(tip));
  });
}

/// Adds a thread to a scene.
template <class Add>
phymul_status add_thread(phymul_simulation* sim, const phymul_thread* constants, uint64_t* thread, Add&& add) {
  return guarded([&] {
    need(thread, "a place for the thread");
    Thread own = constants_of(constants, thread_constants, "constants of a thread");
    own.touches = constants != nullptr && options_of(constants, "constants of a thread").touches != 0;
    *thread = add(scene_of(sim), own).id();
  });
}

Fluid fluid_of(const phymul_fluid* given) {
  Fluid fluid = constants_of(given, fluid_constants, "a fluid");
  if (!given) return fluid;
  const phymul_fluid from = options_of(given, "a fluid");
  require_kind(from.law, PHYMUL_INCOMPRESSIBLE, 3, "a law of a fluid");
  fluid.law = static_cast<FluidLaw>(from.law);
  fluid.outlet_pressure = from.outlet_pressure;
  if (from.opens_into) fluid.opens_into = from.opens_into;
  list(from.curve, from.curve_points, "points of the curve");
  for (int32_t k = 0; k < from.curve_points; ++k) fluid.curve.push_back({from.curve[2 * k], from.curve[2 * k + 1]});
  return fluid;
}

}  // namespace

phymul_status phymul_thread_add(phymul_simulation* sim, const phymul_thread* constants, const double start[3],
                                const double direction[3], uint64_t* thread) {
  return add_thread(sim, constants, thread, [&](Scene& scene, const Thread& own) {
    return scene.add_thread(own, vector(start, "a start"), vector(direction, "a direction"));
  });
}

phymul_status phymul_thread_sew(phymul_simulation* sim, const phymul_thread* constants, const double* places,
                                int32_t count, uint64_t* thread) {
  return add_thread(sim, constants, thread,
                    [&](Scene& scene, const Thread& own) { return scene.sew(own, vectors(places, count, "places")); });
}

phymul_status phymul_thread_swage(phymul_simulation* sim, const phymul_thread* constants, uint64_t needle,
                                  uint64_t* thread) {
  return add_thread(sim, constants, thread, [&](Scene& scene, const Thread& own) {
    return scene.swage(own, name_of(scene.tools(), needle, "tool"));
  });
}

phymul_status phymul_clip_add(phymul_simulation* sim, const phymul_clip* clip, const phymul_anchor* one,
                              const phymul_anchor* other, uint64_t* thread) {
  return add_thread(sim, nullptr, thread, [&](Scene& scene, const Thread&) {
    return scene.add_clip(constants_of(clip, clip_constants, "constants of a clip"), anchor_of(sim, one),
                          anchor_of(sim, other));
  });
}

phymul_status phymul_thread_remove(phymul_simulation* sim, uint64_t thread) {
  return guarded([&] {
    Scene& scene = scene_of(sim);
    scene.remove_thread(std::string(name_of(scene.threads(), thread, "thread")));
  });
}

phymul_status phymul_thread_hold(phymul_simulation* sim, uint64_t thread, int32_t node, const double position[3]) {
  return guarded([&] { thread_of(sim, thread).hold(node, vector(position, "a position")); });
}

phymul_status phymul_thread_release(phymul_simulation* sim, uint64_t thread, int32_t node) {
  return guarded([&] { thread_of(sim, thread).release(node); });
}

phymul_status phymul_thread_join(phymul_simulation* sim, uint64_t thread, int32_t tip, const phymul_anchor* anchor) {
  return at_tip(sim, thread, tip, [&](const ThreadHandle& own, ThreadTip at) { own.join(at, anchor_of(sim, anchor)); });
}

phymul_status phymul_thread_pull(phymul_simulation* sim, uint64_t thread, int32_t tip, const double force[3]) {
  return at_tip(sim, thread, tip,
                [&](const ThreadHandle& own, ThreadTip at) { own.pull(at, vector(force, "a force")); });
}

phymul_status phymul_thread_fix(phymul_simulation* sim, uint64_t thread, int32_t tip) {
  return at_tip(sim, thread, tip, [](const ThreadHandle& own, ThreadTip at) { own.fix(at); });
}

phymul_status phymul_thread_clamp(phymul_simulation* sim, uint64_t thread, int32_t tip, double holding, double gap) {
  return at_tip(sim, thread, tip, [&](const ThreadHandle& own, ThreadTip at) { own.clamp(at, holding, gap); });
}

phymul_status phymul_thread_tie(phymul_simulation* sim, uint64_t thread, int32_t passage, int32_t other,
                                int32_t throws) {
  return guarded([&] { thread_of(sim, thread).tie(passage, other, throws); });
}

phymul_status phymul_thread_loosen(phymul_simulation* sim, uint64_t thread, int32_t passage, int32_t other) {
  return guarded([&] { thread_of(sim, thread).loosen(passage, other); });
}

phymul_status phymul_thread_read(phymul_simulation* sim, uint64_t thread, phymul_thread_state* state) {
  return guarded([&] {
    const Place place(state, "a place for the state of the thread");
    const ThreadHandle handle = thread_of(sim, thread);
    const ThreadState& now = sim->thread = sim->simulation.solver().thread_state(handle);
    sim->broken.assign(now.broken.begin(), now.broken.end());
    sim->slides.assign(now.slides.begin(), now.slides.end());
    sim->knots.clear();
    for (const KnotState& knot : now.knots)
      sim->knots.push_back({.a = knot.a,
                            .b = knot.b,
                            .broken = knot.broken,
                            .unused = 0,
                            .rest_length = knot.rest_length,
                            .tension = knot.tension,
                            .slip = knot.slip});
    const auto number = [](const auto& rows) { return static_cast<int32_t>(rows.size()); };
    phymul_thread_state result{};
    result.points = number(now.position);
    result.segments = number(now.rest_length);
    result.passages = number(now.passages);
    result.knot_count = number(now.knots);
    result.torn = now.torn;
    result.pulled_out = now.pulled_out;
    result.sewn = number(now.sewn);
    store(now.force[0], result.force_first);
    store(now.force[1], result.force_last);
    result.positions = doubles(now.position);
    result.velocities = doubles(now.velocity);
    result.rest_lengths = now.rest_length.data();
    result.tensions = now.tension.data();
    result.broken = sim->broken.data();
    result.rows = now.passages.data();
    result.slides = sim->slides.data();
    result.knots = sim->knots.data();
    result.touch = now.touch.empty() ? nullptr : doubles(now.touch);
    place.fill(result);
  });
}

phymul_status phymul_volume_add(phymul_simulation* sim, const char* name, const int32_t* triangles,
                                int32_t triangle_count, double volume, const phymul_fluid* fluid) {
  return guarded([&] {
    scene_of(sim).constrain_volume(VolumeConstraint{.triangles = triples(triangles, triangle_count, "triangles"),
                                                    .volume = volume,
                                                    .applied_to = {},
                                                    .name = &need(name, "a name of the volume"),
                                                    .fluid = fluid_of(fluid)});
  });
}

phymul_status phymul_volume_remove(phymul_simulation* sim, const char* name) {
  return guarded([&] { scene_of(sim).remove_volume(&need(name, "a name of the volume")); });
}

phymul_status phymul_volume_set(phymul_simulation* sim, const char* name, double volume) {
  return guarded([&] { scene_of(sim).set_volume(&need(name, "a name of the volume"), volume); });
}

phymul_status phymul_volume_set_fluid(phymul_simulation* sim, const char* name, const phymul_fluid* fluid) {
  return guarded([&] { scene_of(sim).set_fluid(&need(name, "a name of the volume"), fluid_of(fluid)); });
}

phymul_status phymul_volume_read(phymul_simulation* sim, const char* name, double* volume, double* pressure) {
  return guarded([&] {
    need(pressure, "a place for the pressure");
    need(volume, "a place for the volume");
    const FluidState& now = need(sim, "a simulation").simulation.solver().fluid(&need(name, "a name of the volume"));
    *volume = now.volume;
    *pressure = now.pressure;
  });
}

phymul_status phymul_tear(phymul_simulation* sim, const phymul_material* material, double toughness, double radius) {
  return guarded([&] {
    const Tearing law{.toughness = toughness, .radius = radius};
    material ? scene_of(sim).tear(material_of(material), law) : scene_of(sim).tear(law);
  });
}

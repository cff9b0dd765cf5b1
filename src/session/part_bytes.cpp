// SPDX-License-Identifier: MIT
#include "scene_bytes.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "wire_codes.h"

namespace phymul {
namespace {

// What a thing is made of, for a ByteWriter and a thing that is const, or a ByteReader and one that is not.

template <class Bytes, class Kept>
void volume_fields(Bytes& bytes, Kept& all) {
  bytes.list(all, 20, "a number of kept volumes", [&](auto& surface) {
    bytes.field(surface.volume, "a volume");
    bytes.field(surface.applied_to, "a group's name");
    bytes.list(surface.triangles, 12, "a number of triangles", [&](auto& triangle) {
      for (auto& i : triangle) bytes.field(i, "a particle");
    });
  });
}

void fluid_law_fields(ByteWriter& out, const Fluid& fluid) {
  const bool opens = !fluid.opens_into.empty();
  code(out, static_cast<FluidLaw>(static_cast<int>(fluid.law) + (opens ? into_another : 0)), "");
  if (opens) out.text(fluid.opens_into);
}

void fluid_law_fields(ByteReader& in, Fluid& fluid) {
  code(in, fluid.law, "a law of a fluid");
  if (static_cast<int>(fluid.law) < into_another) return;
  fluid.law = static_cast<FluidLaw>(static_cast<int>(fluid.law) - into_another);
  fluid.opens_into = in.text("a volume's name");
}

/// What volume_fields() has not, of which files were written before constraints had it.
template <class Bytes, class Constraint>
void fluid_fields_of(Bytes& bytes, Constraint& kept) {
  bytes.field(kept.name, "a name");
  fluid_law_fields(bytes, kept.fluid);
  for (auto* value :
       {&kept.fluid.outer_pressure, &kept.fluid.exponent, &kept.fluid.conductance, &kept.fluid.outlet_pressure}) {
    bytes.field(*value, "a constant of a fluid");
  }
  bytes.list(kept.fluid.curve, 16, "a number of points", [&](auto& point) {
    for (auto& value : point) bytes.field(value, "a point of a curve");
  });
}

/// A volume in a change: of one that stays no triangles.
struct VolumeChange {
  std::vector<VolumeConstraint> kept{1};
  bool is_new = true, is_set = false;
};

template <class Bytes, class Change>
void change_fields(Bytes& bytes, Change& change) {
  bytes.field(change.is_new, "whether a volume is new");
  bytes.field(change.is_set, "whether a volume is set");
  volume_fields(bytes, change.kept);
  for (auto& kept : change.kept) fluid_fields_of(bytes, kept);
}

}  // namespace

void put_volumes(ByteWriter& out, const Scene& scene, std::span<const VolumeConstraint> before) {
  std::vector<VolumeChange> all;
  // A replay keeps the order of the volumes that it has, and appends new ones: so does this list. A volume that was
  // removed and constrained again counts as new.
  auto first = before.begin();
  for (const VolumeConstraint& kept : scene.volume_constraints()) {
    const auto known = std::find_if(first, before.end(), [&](const auto& other) { return other.name == kept.name; });
    VolumeChange& change = all.emplace_back();
    change.kept = {kept};
    change.is_new = known == before.end() || known->triangles != kept.triangles;
    change.is_set = !change.is_new && known->changes != kept.changes;
    first = change.is_new ? before.end() : known + 1;
    if (!change.is_new) change.kept.front().triangles.clear();
  }
  out.list(std::as_const(all), 0, "", [&](const VolumeChange& change) { change_fields(out, change); });
}

void take_volumes(ByteReader& in, Scene& scene) {
  std::vector<VolumeChange> all;
  in.list(all, 30, "a number of volumes", [&](VolumeChange& change) { change_fields(in, change); });
  std::vector<std::string> gone;
  // None opens into another until all are there.
  for (const VolumeConstraint& known : scene.volume_constraints()) {
    if (known.fluid.opens_into.empty()) continue;
    Fluid closed = known.fluid;
    closed.opens_into.clear();
    scene.set_fluid(known.name, std::move(closed));
  }
  for (const VolumeConstraint& known : scene.volume_constraints()) {
    const bool stays = std::ranges::any_of(all, [&](const VolumeChange& change) {
      return !change.is_new && change.kept.size() == 1 && change.kept.front().name == known.name;
    });
    if (!stays) gone.push_back(known.name);
  }
  for (const std::string& name : gone) scene.remove_volume(name);
  std::vector<std::pair<std::string, Fluid>> fluids;
  for (VolumeChange& change : all) {
    if (change.kept.size() != 1) in.fail("expected one volume at a time; the file is damaged");
    VolumeConstraint& kept = change.kept.front();
    fluids.emplace_back(kept.name, std::exchange(kept.fluid, {}));
    if (change.is_new) {
      scene.constrain_volume(std::move(kept));
    } else if (change.is_set) {
      scene.set_volume(kept.name, kept.volume);
    }
  }
  for (auto& [name, fluid] : fluids) scene.set_fluid(name, std::move(fluid));
}

void take_old_volumes(ByteReader& in, Scene& scene) {
  std::vector<VolumeConstraint> kept;
  volume_fields(in, kept);
  for (VolumeConstraint& surface : kept) scene.constrain_volume(std::move(surface));
}

namespace {

/// One byte, of a sign or none.
template <class Value>
void small_field(ByteWriter& out, Value value, const char*) {
  out.u8(static_cast<std::uint8_t>(value));
}
template <class Value>
void small_field(ByteReader& in, Value& value, const char* what) {
  value = static_cast<Value>(in.u8(what));
}

template <class Bytes, class Any>
void constant_fields(Bytes& bytes, Any& thread) {
  auto& [length, radius, young, bending, density, segment, damping, touches, friction, channel, breaking, limit,
         throws] = thread;
  for (auto* value : {&length, &radius, &young, &bending, &density, &segment, &damping, &friction, &channel, &breaking,
                      &limit, &throws}) {
    bytes.field(*value, "a constant of a thread");
  }
  bytes.field(touches, "whether a thread touches");
}

template <class Bytes, class Any>
void control_fields(Bytes& bytes, Any& control) {
  for (auto& end : control.ends) {
    code(bytes, end.hold, "what holds a thread's tip");
    bytes.field(end.force, "a force");
    anchor_fields(bytes, end.anchor);
    if (end.hold != TipHold::clamped) continue;
    bytes.field(end.holding, "a clamp's force");
    bytes.field(end.gap, "a clamp's gap");
    bytes.field(end.call, "a call");
  }
  bytes.list(control.held, 28, "a number of held nodes", [&](auto& held) {
    bytes.field(held.node, "a node");
    bytes.field(held.position, "a position");
  });
  bytes.list(control.knots, 20, "a number of knots", [&](auto& knot) {
    bytes.field(knot.a, "a passage");
    bytes.field(knot.b, "a passage");
    bytes.field(knot.throws, "a number of throws");
    bytes.field(knot.call, "a call");
  });
}

template <class Bytes, class Any>
void thread_fields(Bytes& bytes, Any& thread) {
  bytes.field(thread.name, "a thread's name");
  constant_fields(bytes, thread.thread);
  bytes.field(thread.start, "a start");
  bytes.field(thread.direction, "a direction");
  bytes.list(thread.passages, 44, "a number of passages", [&](auto& anchor) { anchor_fields(bytes, anchor); });
  control_fields(bytes, thread.control);
}

template <class Bytes, class Any>
void state_fields_of_thread(Bytes& bytes, Any& state) {
  bytes.field(state.name, "a thread's name");
  const auto reals = [&](auto& list, const char* what) {
    bytes.list(list, 8, what, [&](auto& value) { bytes.field(value, what); });
  };
  const auto vectors = [&](auto& list, const char* what) {
    bytes.list(list, 24, what, [&](auto& value) { bytes.field(value, what); });
  };
  vectors(state.position, "a thread's positions");
  vectors(state.velocity, "a thread's velocities");
  reals(state.rest_length, "a thread's rest lengths");
  reals(state.tension, "a thread's tensions");
  bytes.list(state.broken, 1, "broken segments", [&](auto& value) { small_field(bytes, value, "a broken segment"); });
  bytes.field(state.passages, "passages");
  bytes.list(state.slides, 1, "sliding passages", [&](auto& value) { small_field(bytes, value, "a way of sliding"); });
  bytes.list(state.knots, 33, "a number of knots", [&](auto& knot) {
    bytes.field(knot.a, "a passage");
    bytes.field(knot.b, "a passage");
    for (auto* value : {&knot.rest_length, &knot.tension, &knot.slip}) bytes.field(*value, "a size of a knot");
    bytes.field(knot.broken, "whether a knot is broken");
  });
  for (auto& anchored : state.anchored) bytes.field(anchored, "whether a tail is anchored");
  for (auto& force : state.force) bytes.field(force, "a force");
  vectors(state.touch, "forces on a thread");
  bytes.field(state.torn, "a number of passages");
  bytes.field(state.pulled_out, "a number of passages");
}

}  // namespace

void put_threads(ByteWriter& out, const std::vector<SceneThread>& threads) {
  out.list(threads, 0, "", [&](const SceneThread& thread) { thread_fields(out, thread); });
}

std::vector<SceneThread> take_threads(ByteReader& in) {
  std::vector<SceneThread> threads;
  in.list(threads, 245, "a number of threads", [&](SceneThread& thread) { thread_fields(in, thread); });
  return threads;
}

void add_threads(ByteReader& in, Scene& scene) {
  for (SceneThread& thread : take_threads(in)) {
    scene.add_thread(thread).set(thread.control);
  }
}

void put_control(ByteWriter& out, const ThreadControl& control) {
  control_fields(out, control);
}

void change_control(ByteReader& in, const ThreadHandle& thread) {
  ThreadControl wanted;
  control_fields(in, wanted);
  thread.set(wanted);
}

void put_sewn(ByteWriter& out, const std::vector<ThreadState>& threads) {
  for (const ThreadState& state : threads) {
    out.list(state.sewn, 0, "", [&](const Anchor& anchor) { anchor_fields(out, anchor); });
  }
}

void take_sewn(ByteReader& in, std::vector<ThreadState>& threads) {
  for (ThreadState& state : threads) {
    in.list(state.sewn, 48, "a number of passages", [&](Anchor& anchor) { anchor_fields(in, anchor); });
  }
}

void put_thread_states(ByteWriter& out, const std::vector<ThreadState>& threads) {
  out.list(threads, 0, "", [&](const ThreadState& state) { state_fields_of_thread(out, state); });
}

std::vector<ThreadState> take_thread_states(ByteReader& in) {
  std::vector<ThreadState> threads;
  in.list(threads, 134, "a number of threads", [&](ThreadState& state) { state_fields_of_thread(in, state); });
  return threads;
}

}  // namespace phymul

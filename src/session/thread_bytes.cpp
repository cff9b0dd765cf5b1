// SPDX-License-Identifier: MIT
#include "scene_bytes.h"

#include <bit>

#include "wire_codes.h"

namespace phymul {
namespace {

// For a ByteWriter and a thing that is const, or a ByteReader and one that is not.

void small_field(ByteWriter& out, std::uint8_t value, const char*) {
  out.u8(value);
}
void small_field(ByteReader& in, std::uint8_t& value, const char* what) {
  value = in.u8(what);
}
void small_field(ByteWriter& out, std::int8_t value, const char*) {
  out.u8(std::bit_cast<std::uint8_t>(value));
}
void small_field(ByteReader& in, std::int8_t& value, const char* what) {
  value = std::bit_cast<std::int8_t>(in.u8(what));
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

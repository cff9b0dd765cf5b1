// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/mirror_scene.h: a particle and the tools of a scene in one step. Needs tool_tables.glsl,
// contact_tool.glsl, and net_force.glsl for free_part().

struct ToolFrame {  // axes in the world, place as a sum
  vec3 x, y, z;
  vec3 high, low;
};

struct ToolTurn {  // from the step's start to its end: what the axes and the place gain
  vec3 x, y, z;
  vec3 gone;
};

struct TouchedParticle {
  vec3 high, low;
  vec3 u, v;
  float mass, inverse_mass;
  int fixed_at;
  vec3 impulse, shift;
  vec3 withheld;
};

struct Passage {  // of a particle in a step, in the tool's frame, m
  vec3 start, end, way;
};

struct Reaction {
  bool touches;
  vec3 force, torque;
};

const Reaction no_reaction = Reaction(false, vec3(0.0), vec3(0.0));

vec3 place_from(ToolFrame frame, TouchedParticle p, vec3 u) {
  return ((p.high - frame.high) + (p.low - frame.low)) + u;
}

vec3 inside(ToolFrame frame, vec3 r) {
  return vec3(inner_product(frame.x, r), inner_product(frame.y, r), inner_product(frame.z, r));
}

vec3 turned(ToolFrame frame, vec3 q) {
  return q.x * frame.x + q.y * frame.y + q.z * frame.z;
}

vec3 push(inout TouchedParticle p, vec3 impulse) {
  vec3 taken = free_part(impulse, p.fixed_at);
  p.impulse = p.impulse + taken;
  p.v = p.v + p.inverse_mass * taken;
  return taken;
}

// N: what of the withheld force is against an impulse, and the tool bears too.
vec3 borne(inout TouchedParticle p, vec3 impulse) {
  float squared = inner_product(impulse, impulse);
  if (!(squared > 0.0)) return vec3(0.0);
  vec3 force = (max(0.0, -inner_product(p.withheld, impulse)) / squared) * impulse;
  p.withheld = p.withheld + force;
  return force;
}

Reaction react(ToolFrame end, TouchedParticle p, vec3 force) {
  return Reaction(true, -force, -cross_product(place_from(end, p, p.u), force));
}

Reaction hold(ToolFrame end, vec3 held_at, inout TouchedParticle p, float inverse_dt) {
  vec3 target = ((end.high - p.high) + (end.low - p.low)) + turned(end, held_at);
  vec3 velocity = inverse_dt * (target - p.u);
  vec3 force = inverse_dt * push(p, p.mass * (velocity - p.v)) - free_part(p.withheld, p.fixed_at);
  p.withheld = vec3(0.0);
  return react(end, p, force);
}

Passage passage(ToolFrame start, ToolFrame end, ToolTurn turn, TouchedParticle p, float dt) {
  vec3 r0 = place_from(start, p, p.u);
  vec3 passed = dt * p.v - turn.gone;
  vec3 way = vec3(inner_product(end.x, passed) + inner_product(turn.x, r0),
                  inner_product(end.y, passed) + inner_product(turn.y, r0),
                  inner_product(end.z, passed) + inner_product(turn.z, r0));
  vec3 q1 = inside(end, place_from(end, p, p.u + dt * p.v));
  return Passage(inside(start, r0), q1, way);
}

Reaction press(ShapeIn shape, ContactLaw law, ToolFrame start, ToolFrame end, ToolTurn turn, inout TouchedParticle p,
               float dt, float inverse_dt) {
  Passage own = passage(start, end, turn, p, dt);
  Touch touch = touch_in_step(shape, law, own.start, own.end, own.way, p.inverse_mass, dt);
  if (!touch.touches) return no_reaction;
  p.shift = p.shift + free_part(turned(end, touch.shift), p.fixed_at);
  vec3 given = push(p, turned(end, touch.impulse));
  return react(end, p, inverse_dt * given + borne(p, given));
}

// What the tables say.

vec4 tool_law(int tool, int row) {
  return fetch_load_vec4(tool_laws, tool_laws_place, TOOL_LAW_ROWS * tool + row);
}

vec4 tool_frame_row(int tool, int at, int row) {
  return fetch_load_vec4(tool_frames, tool_frames_place, TOOL_FRAME_ROWS * (at * tool_count + tool) + row);
}

ToolFrame tool_frame(int tool, int at) {
  vec4 x = tool_frame_row(tool, at, 0);
  vec4 y = tool_frame_row(tool, at, 1);
  vec4 z = tool_frame_row(tool, at, 2);
  return ToolFrame(x.xyz, y.xyz, z.xyz, vec3(x.w, y.w, z.w), tool_frame_row(tool, at, 3).xyz);
}

ToolTurn tool_turn(int tool, int at) {
  vec4 x = tool_frame_row(tool, at, 4);
  vec4 y = tool_frame_row(tool, at, 5);
  vec4 z = tool_frame_row(tool, at, 6);
  return ToolTurn(x.xyz, y.xyz, z.xyz, vec3(x.w, y.w, z.w));
}

ShapeIn tool_shape(int tool) {
  vec4 size = tool_law(tool, 0);
  vec4 law = tool_law(tool, 1);
#ifdef TOOL_GRIDS
  vec4 grid = tool_law(tool, 2);
  vec4 count = tool_law(tool, 3);
  return ShapeIn(int(size.w), size.xyz, law.x, law.y, ivec3(count.xyz), TOOL_GRID_UNIT * int(count.w), grid.xyz, grid.w);
#else
  return ShapeIn(int(size.w), size.xyz, law.x, law.y);
#endif
}

// In the step from the instant `at` on.
ContactLaw tool_contact(int tool, int at) {
  vec4 law = tool_law(tool, 1);
  return ContactLaw(law.z, law.w, tool_frame_row(tool, at, 3).w > 0.0);
}

// Axes on which nothing pushes particle i.
int unmoved_axes(int fixed_at) {
#if DIMENSION == 2
  return fixed_at | 4;
#else
  return fixed_at;
#endif
}

// u: at the step's start; v: the velocity with which it would go on. After `withheld` is known where a reaction is told.
TouchedParticle untouched(int i, vec3 u, vec3 v, int fixed_at) {
  vec4 inertia = fetch_vec4(particle, particle_place, i);
  return TouchedParticle(fetch_load_vec4(tool_rest, tool_rest_place, 2 * i).xyz,
                         fetch_load_vec4(tool_rest, tool_rest_place, 2 * i + 1).xyz, u, v, inertia.z, inertia.x,
                         unmoved_axes(fixed_at), vec3(0.0), vec3(0.0), withheld);
}

// In the scene's order; `at`: the instant of the step's start. What a tool holds no other pushes.
Reaction touch_tool(int tool, vec4 held, int at, inout TouchedParticle p, float dt, float inverse_dt) {
  int holder = int(held.w);
  if (holder >= 0 && holder != tool) return no_reaction;
  ToolFrame end = tool_frame(tool, at + 1);
  if (holder == tool) return hold(end, held.xyz, p, inverse_dt);
  if (p.fixed_at == 7) return no_reaction;
  return press(tool_shape(tool), tool_contact(tool, at), tool_frame(tool, at), end, tool_turn(tool, at), p, dt,
               inverse_dt);
}

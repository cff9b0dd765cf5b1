// SPDX-License-Identifier: MIT
#include "c_program.h"

#include <math.h>
#include <phymul_c.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static char failure[2000];

#define DO(call)                                                                                \
  if ((call) != PHYMUL_OK) {                                                                    \
    snprintf(failure, sizeof failure, "line %d: " #call ": %s", __LINE__, phymul_last_error()); \
    return failure;                                                                             \
  }

#define REFUSED(call, status, words)                                                                                   \
  if ((call) != (status) || !strstr(phymul_last_error(), words)) {                                                     \
    snprintf(failure, sizeof failure, "line %d: expected the status %d and \"%s\" of " #call "; got \"%s\"", __LINE__, \
             (int)(status), words, phymul_last_error());                                                               \
    return failure;                                                                                                    \
  }

#define HOLDS(condition)                                                          \
  if (!(condition)) {                                                             \
    snprintf(failure, sizeof failure, "line %d: expected " #condition, __LINE__); \
    return failure;                                                               \
  }

static const double block_size[3] = {0.03, 0.03, 0.03};
static const phymul_material soft = {.size = sizeof soft, .young = 8e3, .poisson = 0.4, .density = 1000};
static const phymul_material stiff = {.size = sizeof stiff, .young = 3e4, .poisson = 0.4, .density = 1000};

static const char* misuse_of_bodies(void) {
  phymul_body* body = NULL;
  REFUSED(phymul_body_block(NULL, 3, 3, 3, &body), PHYMUL_INVALID_ARGUMENT, "NULL")
  REFUSED(phymul_body_block(block_size, 0, 3, 3, &body), PHYMUL_INVALID_ARGUMENT, "")
  REFUSED(phymul_body_read("absent.msh", 0, &body), PHYMUL_FILE_ACCESS, "absent.msh")
  const int32_t types[1] = {PHYMUL_TETRAHEDRON}, first[2] = {0, 3}, particles[4] = {0, 1, 2, 9};
  const int32_t four[2] = {0, 4};
  const double rest[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  REFUSED(phymul_body_from_arrays(rest, 4, types, first, particles, 1, &body), PHYMUL_INVALID_ARGUMENT, "cell 0")
  REFUSED(phymul_body_from_arrays(rest, 4, types, four, particles, 1, &body), PHYMUL_INVALID_ARGUMENT, "9")
  HOLDS(body == NULL)
  phymul_body_free(NULL);
  return NULL;
}

static phymul_status ends(void* user, const phymul_candidate* candidate, phymul_simulation** made) {
  (void)user, (void)candidate, (void)made;
  phymul_body* body = NULL;
  phymul_body_read("absent.msh", 0, &body);
  return PHYMUL_INTERNAL;
}

static const char* misuse_of_simulations(const phymul_body* body, phymul_simulation* sim) {
  phymul_simulation* none = NULL;
  const phymul_body* two[2] = {body, body};
  phymul_options options = {.size = sizeof options, .backend = "abacus"};
  REFUSED(phymul_simulation_create(two, NULL, 2, &options, &none), PHYMUL_INVALID_ARGUMENT, "name")
  const char* names[2] = {"a\nb", "c"};
  REFUSED(phymul_simulation_create(two, names, 2, &options, &none), PHYMUL_INVALID_ARGUMENT, "of one line")
  const phymul_plan_options wishes = {.size = sizeof wishes, .max_error = 0.1, .rate = 50};
  phymul_plan* plan = NULL;
  REFUSED(phymul_plan_create(ends, NULL, &wishes, &plan), PHYMUL_INTERNAL, "absent.msh")
  const phymul_material zeros = {.size = sizeof zeros};
  options.backend = NULL;
  options.material = &zeros;
  REFUSED(phymul_simulation_create(two, NULL, 1, &options, &none), PHYMUL_INVALID_ARGUMENT, "one of zeros")
  options.size = sizeof options + 8;
  REFUSED(phymul_simulation_create(two, NULL, 1, &options, &none), PHYMUL_INVALID_ARGUMENT, "size")
  HOLDS(none == NULL)
  REFUSED(phymul_fix(sim, "x9"), PHYMUL_UNKNOWN_NAME, "x1")
  REFUSED(phymul_fix(NULL, "x0"), PHYMUL_INVALID_ARGUMENT, "NULL")
  const int32_t row[1] = {1000}, last = 63;
  REFUSED(phymul_fix_particles(sim, row, 1), PHYMUL_INVALID_ARGUMENT, "1000")
  REFUSED(phymul_fix_particles(sim, row, -1), PHYMUL_INVALID_ARGUMENT, "-1")
  phymul_tool_force force = {.size = sizeof force};
  REFUSED(phymul_tool_read_force(sim, 77, &force), PHYMUL_UNKNOWN_NAME, "77")
  const phymul_anchor lost = {.size = sizeof lost, .count = 3},
                      held = {.size = sizeof held, .particles = &last, .count = 1};
  const phymul_joint_options spring = {.size = sizeof spring, .stiffness = 1};
  uint64_t joint = 0;
  REFUSED(phymul_joint_add(sim, &lost, &held, &spring, &joint), PHYMUL_INVALID_ARGUMENT, "NULL")
  phymul_body* cut = NULL;
  REFUSED(phymul_body_cut(body, block_size, block_size, NULL, block_size, &cut), PHYMUL_INVALID_ARGUMENT,
          "of the front")
  REFUSED(phymul_cut(sim, block_size, block_size, block_size, NULL, NULL), PHYMUL_INVALID_ARGUMENT, "of the front")
  phymul_step_report report = {.size = sizeof report, .steps = -1};
  REFUSED(phymul_step(sim, 1, 10.0, &report), PHYMUL_STEP_FAILED, "")
  HOLDS(report.steps == 0 && report.stable_step > 0)
  REFUSED(phymul_load(sim, "absent.state"), PHYMUL_FILE_ACCESS, "absent.state")
  return NULL;
}

/* An output is missing: the others stay as they were. */
static const char* outputs_stay(phymul_body* body, phymul_simulation* sim) {
  const double* doubles = NULL;
  const int32_t *integers = NULL, *others = NULL;
  int32_t count = -7;
  double time = -7;
  REFUSED(phymul_body_rest(body, NULL, &count), PHYMUL_INVALID_ARGUMENT, "positions")
  REFUSED(phymul_body_rest(body, &doubles, NULL), PHYMUL_INVALID_ARGUMENT, "number")
  REFUSED(phymul_body_triangles(body, NULL, &count), PHYMUL_INVALID_ARGUMENT, "triangles")
  REFUSED(phymul_body_triangles(body, &integers, NULL), PHYMUL_INVALID_ARGUMENT, "number")
  REFUSED(phymul_body_group(body, "z1", NULL, &count), PHYMUL_INVALID_ARGUMENT, "particles")
  REFUSED(phymul_body_cells(body, &integers, &others, NULL, &count), PHYMUL_INVALID_ARGUMENT, "particles")
  REFUSED(phymul_body_cells(body, NULL, &others, &integers, &count), PHYMUL_INVALID_ARGUMENT, "types")
  REFUSED(phymul_positions(sim, NULL, &count), PHYMUL_INVALID_ARGUMENT, "list")
  REFUSED(phymul_positions(sim, &doubles, NULL), PHYMUL_INVALID_ARGUMENT, "number")
  REFUSED(phymul_step_limits(sim, NULL, &time), PHYMUL_INVALID_ARGUMENT, "stable")
  REFUSED(phymul_step_limits(sim, &time, NULL), PHYMUL_INVALID_ARGUMENT, "step")
  HOLDS(!doubles && !integers && !others && count == -7 && time == -7)
  phymul_step_report report = {.size = 3};
  DO(phymul_time(sim, &time))
  REFUSED(phymul_advance(sim, 1e-3, &report), PHYMUL_INVALID_ARGUMENT, "size")
  double after = 0;
  DO(phymul_time(sim, &after))
  HOLDS(after == time)
  return NULL;
}

/* Programs whose structs end earlier: the rest has its default, and what lies behind is not written. */
static const char* older_programs(const phymul_body* body, phymul_simulation* sim) {
  phymul_step_report report;
  memset(&report, 0x55, sizeof report);
  report.size = (uint32_t)offsetof(phymul_step_report, dt);
  const double unwritten = report.dt;
  DO(phymul_step(sim, 0, 1e-5, &report))
  HOLDS(report.size == offsetof(phymul_step_report, dt) && report.steps == 0 && report.time == 0)
  HOLDS(memcmp(&report.dt, &unwritten, sizeof unwritten) == 0)

  phymul_material elastic;
  memset(&elastic, 0x55, sizeof elastic);
  elastic.size = (uint32_t)offsetof(phymul_material, retardation_time);
  elastic.young = 1e4;
  elastic.poisson = 0.3;
  elastic.density = 1000;
  phymul_body* moved = NULL;
  const double nowhere[3] = {0, 0, 0};
  DO(phymul_body_moved(body, nowhere, &moved))
  DO(phymul_body_set_material(moved, &elastic, NULL))
  phymul_body_free(moved);
  return NULL;
}

static int runs = 0;
static void in_turn(void* user, int32_t count, phymul_part part, void* task) {
  runs += *(int*)user;
  for (int32_t k = count - 1; k >= 0; --k) part(task, k);
}

/* The program's threads, of which it has one: a body whose particles are where the library's own threads bring them. */
static const char* own_threads(void) {
  const double size[3] = {0.2, 0.1, 0.1}, down[3] = {0, 0, -9.81};
  phymul_body* large = NULL;
  DO(phymul_body_block(size, 20, 10, 10, &large))
  DO(phymul_body_set_material(large, &soft, NULL))
  int one = 1;
  phymul_options options = {.size = sizeof options,
                            .backend = "cpu",
                            .threads = 2,
                            .run_parts = in_turn,
                            .run_parts_user = &one,
                            .run_parts_width = 0};
  const phymul_body* bodies[1] = {large};
  phymul_simulation* sims[2] = {NULL, NULL};
  REFUSED(phymul_simulation_create(bodies, NULL, 1, &options, &sims[0]), PHYMUL_INVALID_ARGUMENT, "run_parts_width")
  options.run_parts_width = 2;
  const double* positions[2];
  int32_t count = 0;
  for (int k = 0; k < 2; ++k) {
    DO(phymul_simulation_create(bodies, NULL, 1, &options, &sims[k]))
    DO(phymul_fix(sims[k], "x0"))
    DO(phymul_gravity(sims[k], down))
    DO(phymul_advance(sims[k], 0.02, NULL))
    DO(phymul_positions(sims[k], &positions[k], &count))
    HOLDS(runs > 10)
    options.run_parts = NULL;
  }
  HOLDS(memcmp(positions[0], positions[1], 3 * (size_t)count * sizeof(double)) == 0)
  phymul_simulation_free(sims[0]);
  phymul_simulation_free(sims[1]);
  phymul_body_free(large);
  return NULL;
}

static const char* interact(phymul_simulation* sim, const int32_t* top, int32_t top_count, struct c_results* out) {
  phymul_pose pose = {.size = sizeof pose, .position = {0.015, 0.015, 0.042}};
  const phymul_tool_options ball = {
      .size = sizeof ball, .shape = PHYMUL_SPHERE, .radius = 0.012, .pose = &pose, .friction = 0.2};
  uint64_t tool = 0, joint = 0;
  DO(phymul_tool_add(sim, &ball, &tool))
  const phymul_joint_options ligament = {.size = sizeof ligament, .stiffness = 1e5, .damping = 50, .slack = 1};
  const double offset[3] = {0, 0, 0.01};
  DO(phymul_attach(sim, top, top_count, NULL, 0, offset, &ligament, &joint))
  const char* said = NULL;
  DO(phymul_add_body_types(sim, &said))
  if (!said || *said) return "a body without components has body types";

  const double points[9] = {0.004, 0.004, 0.03, 0.022, 0.004, 0.03, 0.004, 0.022, 0.03};
  const int32_t triangle[3] = {0, 1, 2};
  phymul_skin* skin = NULL;
  REFUSED(phymul_skin_create(sim, points, 2, triangle, 1, &skin), PHYMUL_INVALID_ARGUMENT, "")
  DO(phymul_skin_create(sim, points, 3, triangle, 1, &skin))
  for (int tick = 0; tick < 20; ++tick) {
    pose.position[2] -= 3e-4;
    DO(phymul_tool_move_to(sim, tool, &pose))
    DO(phymul_advance(sim, 2e-3, NULL))
  }
  const double *now = NULL, *normals = NULL;
  DO(phymul_skin_deform(skin, sim, &now, &normals))
  memcpy(out->skin, now, sizeof out->skin);
  memcpy(out->normal, normals, sizeof out->normal);
  phymul_skin_free(skin);
  phymul_tool_force force = {.size = sizeof force};
  phymul_joint_report ties = {.size = sizeof ties};
  DO(phymul_tool_read_force(sim, tool, &force))
  DO(phymul_joint_read(sim, joint, &ties))
  memcpy(out->tool_force, force.force, sizeof out->tool_force);
  memcpy(out->joint_force, ties.force, sizeof out->joint_force);
  DO(phymul_tool_grasp(sim, tool, 2e-3))
  DO(phymul_advance(sim, 2e-3, NULL))
  DO(phymul_tool_read_force(sim, tool, &force))
  out->held = force.held;
  REFUSED(phymul_tool_remove(sim, tool + 1), PHYMUL_UNKNOWN_NAME, "")
  return NULL;
}

static const char* read_state(phymul_simulation* sim, struct c_results* out) {
  const double *position = NULL, *velocity = NULL, *force = NULL, *again = NULL;
  int32_t count = 0;
  DO(phymul_positions(sim, &position, &count))
  DO(phymul_velocities(sim, &velocity, &count))
  DO(phymul_forces(sim, &force, &count))
  HOLDS(count == most_particles)
  out->particles = count;
  memcpy(out->position, position, sizeof out->position);
  memcpy(out->velocity, velocity, sizeof out->velocity);
  memcpy(out->force, force, sizeof out->force);
  DO(phymul_energy(sim, out->energy))
  DO(phymul_time(sim, &out->time))

  phymul_snapshot* before = NULL;
  DO(phymul_snapshot_take(sim, &before))
  DO(phymul_advance(sim, 0.01, NULL))
  DO(phymul_positions(sim, &again, &count))
  HOLDS(again == position && memcmp(position, out->position, sizeof out->position) != 0)
  DO(phymul_snapshot_restore(before, sim))
  phymul_snapshot_free(before);
  DO(phymul_positions(sim, &again, &count))
  HOLDS(again == position && memcmp(position, out->position, sizeof out->position) == 0)
  const double middle[3] = {0, 0, 0}, across[3] = {1, 0, 0};
  phymul_body* cut = NULL;
  HOLDS(phymul_body_cut(NULL, middle, across, NULL, NULL, &cut) == PHYMUL_INVALID_ARGUMENT && cut == NULL)
  int32_t whether = 1;
  HOLDS(phymul_body_with_spare_particles(NULL, 1, &cut) == PHYMUL_INVALID_ARGUMENT && cut == NULL)
  HOLDS(phymul_cut(NULL, middle, across, NULL, NULL, &whether) == PHYMUL_INVALID_ARGUMENT)
  const int32_t cells[] = {0, 1};
  DO(phymul_remove_cells(sim, cells, 2))
  HOLDS(phymul_remove_cells(sim, (const int32_t[]){-1}, 1) == PHYMUL_INVALID_ARGUMENT)
  return NULL;
}

static const char* rest_of(const phymul_body* body, struct c_results* out) {
  const phymul_options options = {.size = sizeof options, .backend = "reference"};
  const double down[3] = {0, 0, -1};
  phymul_simulation* sim = NULL;
  DO(phymul_simulation_create(&body, NULL, 1, &options, &sim))
  DO(phymul_fix(sim, "z0"))
  DO(phymul_gravity(sim, down))
  phymul_rest_report report = {.size = sizeof report};
  DO(phymul_solve_static(sim, 0, 0, &report))
  DO(phymul_follow_static(sim, 0, 0, &report))
  HOLDS(report.converged == 1 && report.folded == -1)
  out->rest_residual = report.residual;
  REFUSED(phymul_solve_static(sim, -1, 0, &report), PHYMUL_INVALID_ARGUMENT, "")
  phymul_simulation_free(sim);
  return NULL;
}

/* A needle, a thread, a clip and a fluid, with constants that are not the defaults. */
static const char* sutured(phymul_body* body, struct c_results* out) {
  const phymul_options options = {.size = sizeof options, .backend = "cpu", .damping_rate = 20, .threads = 1};
  const phymul_body* bodies[1] = {body};
  phymul_simulation* sim = NULL;
  DO(phymul_simulation_create(bodies, NULL, 1, &options, &sim))
  DO(phymul_fix(sim, "z0"))
  const double places[12] = {0.005, 0.015, 0.028, 0.012, 0.015, 0.02, 0.018, 0.015, 0.02, 0.025, 0.015, 0.028};
  const double right[3] = {0.3, 0, 0}, left[3] = {-0.2, 0, 0};
  const phymul_thread silk = {.size = sizeof silk, .length = 0.1, .friction = -1, .channel_friction = 0.01};
  uint64_t stitch = 0, clip = 0, shaft = 0;
  REFUSED(phymul_thread_sew(sim, &silk, places, 1, &stitch), PHYMUL_INVALID_ARGUMENT, "places")
  const phymul_thread wrong = {.size = sizeof wrong, .length = 0.1, .damping = -5};
  REFUSED(phymul_thread_sew(sim, &wrong, places, 4, &stitch), PHYMUL_INVALID_ARGUMENT, "damping")
  DO(phymul_thread_sew(sim, &silk, places, 4, &stitch))
  REFUSED(phymul_thread_pull(sim, stitch, 2, right), PHYMUL_INVALID_ARGUMENT, "a tip")
  REFUSED(phymul_thread_pull(sim, stitch + 1, PHYMUL_LAST, right), PHYMUL_UNKNOWN_NAME, "thread")
  DO(phymul_thread_pull(sim, stitch, PHYMUL_FIRST, right))
  DO(phymul_thread_pull(sim, stitch, PHYMUL_LAST, left))
  const int32_t *group = NULL, *triangles = NULL;
  int32_t sides[2][16];
  phymul_anchor walls[2] = {{.size = sizeof walls[0]}, {.size = sizeof walls[0]}};
  for (int k = 0; k < 2; ++k) {
    DO(phymul_body_group(body, k == 0 ? "y0" : "y1", &group, &walls[k].count))
    HOLDS(walls[k].count == 16)
    memcpy(sides[k], group, sizeof sides[k]);
    walls[k].particles = sides[k];
  }
  const phymul_clip titanium = {.size = sizeof titanium, .gap = 0.028, .holding = 0.4};
  DO(phymul_clip_add(sim, &titanium, &walls[0], &walls[1], &clip))
  int32_t triangle_count = 0;
  DO(phymul_body_triangles(body, &triangles, &triangle_count))
  const phymul_fluid air = {.size = sizeof air, .law = PHYMUL_GAS, .exponent = 1.4, .conductance = 1e-9};
  DO(phymul_volume_add(sim, "air", triangles, triangle_count, 2.8e-5, &air))
  DO(phymul_volume_set(sim, "air", 2.75e-5))
  const phymul_fluid leads = {.size = sizeof leads, .conductance = 1e-9, .opens_into = "nothing"};
  REFUSED(phymul_volume_set_fluid(sim, "air", &leads), PHYMUL_UNKNOWN_NAME, "is \"nothing\"")
  const phymul_needle fine = {
      .size = sizeof fine, .length = 0.05, .radius = 0.4e-3, .spread = 0.012, .static_friction = 20};
  phymul_pose pose = {.size = sizeof pose, .position = {0.015, 0.015, 0.031}};
  const phymul_tool_options tool = {.size = sizeof tool, .shape = PHYMUL_NEEDLE, .pose = &pose, .needle = &fine};
  DO(phymul_tool_add(sim, &tool, &shaft))
  for (int tick = 0; tick < 20; ++tick) {
    if (tick == 10) DO(phymul_thread_tie(sim, stitch, 3, 0, 4))
    pose.position[2] -= 5e-4;
    DO(phymul_tool_move_to(sim, shaft, &pose))
    DO(phymul_advance(sim, 2e-3, NULL))
  }
  phymul_thread_state state = {.size = sizeof state};
  DO(phymul_thread_read(sim, clip, &state))
  out->clip_tension = state.tensions[1];
  DO(phymul_thread_read(sim, stitch, &state))
  HOLDS(state.points == thread_points && state.passages == 4 && state.rows[3] == 3 && state.knot_count == 1)
  HOLDS(state.knots[0].a == 0 && state.knots[0].b == 3 && !state.knots[0].broken && state.torn == 0)
  memcpy(out->thread, state.positions, sizeof out->thread);
  memcpy(out->tension, state.tensions, sizeof out->tension);
  out->knot = state.knots[0].tension;
  double volume = 0;
  DO(phymul_volume_read(sim, "air", &volume, &out->pressure))
  HOLDS(volume > 0)
  REFUSED(phymul_volume_read(sim, "water", &volume, &out->pressure), PHYMUL_UNKNOWN_NAME, "water")
  phymul_tool_force force = {.size = sizeof force};
  DO(phymul_tool_read_force(sim, shaft, &force))
  memcpy(out->needle, force.force, sizeof out->needle);
  DO(phymul_needle_points(sim, shaft, shaft_points, out->shaft))
  phymul_needle_state needle = {.size = sizeof needle};
  DO(phymul_needle_read(sim, shaft, &needle))
  HOLDS(needle.punctured && !needle.through && !needle.is_free)
  out->needle_nodes = needle.nodes;
  DO(phymul_thread_remove(sim, clip))
  REFUSED(phymul_thread_read(sim, clip, &state), PHYMUL_UNKNOWN_NAME, "thread")
  phymul_simulation_free(sim);
  return NULL;
}

const char* c_program(struct c_results* out) {
  const char* wrong = misuse_of_bodies();
  if (wrong) return wrong;
  phymul_body* body = NULL;
  const int32_t* top = NULL;
  const int32_t cells[2] = {13, 22};
  int32_t top_count = 0;
  DO(phymul_body_block(block_size, 3, 3, 3, &body))
  DO(phymul_body_add_cell_group(body, "nodule", cells, 2))
  DO(phymul_body_set_material(body, &soft, NULL))
  DO(phymul_body_set_material(body, &stiff, "nodule"))
  DO(phymul_body_group(body, "z1", &top, &top_count))

  const phymul_options options = {.size = sizeof options, .backend = "cpu", .damping_rate = 20, .threads = 1};
  const phymul_body* bodies[1] = {body};
  phymul_simulation* sim = NULL;
  DO(phymul_simulation_create(bodies, NULL, 1, &options, &sim))
  DO(phymul_fix(sim, "z0"))
  const double direction[3] = {1, 0, 0}, times[2] = {0, 0.02}, values[2] = {0, 1e-3};
  int32_t row = -1;
  DO(phymul_add_load(sim, PHYMUL_FORCE, top, top_count, direction, times, values, 2, &row))
  HOLDS(row == 1)
  wrong = misuse_of_simulations(body, sim);
  if (!wrong) wrong = outputs_stay(body, sim);
  if (!wrong) wrong = older_programs(body, sim);
  if (!wrong) wrong = own_threads();
  if (!wrong) wrong = interact(sim, top, top_count, out);
  if (!wrong) wrong = read_state(sim, out);
  if (!wrong) wrong = rest_of(body, out);
  if (!wrong) wrong = sutured(body, out);
  phymul_body_free(body);
  phymul_simulation_free(sim);
  return wrong;
}

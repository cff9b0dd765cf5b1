// SPDX-License-Identifier: MIT
//
// The part of the C interface for what acts on bodies: tools, needles, jaws, joints, threads, clips, fluids and
// tearing. The rules at the beginning of phymul_c.h hold. In phymul_needle, phymul_thread, phymul_clip,
// phymul_jaws_options and phymul_fluid a field that is 0 has the default of its comment, and where that is not 0, a
// number below 0 stands for 0.
#ifndef PHYMUL_C_INTERACTION_H
#define PHYMUL_C_INTERACTION_H

#include "phymul_c.h"

#ifdef __cplusplus
extern "C" {
#endif

// --- Tools ----------------------------------------------------------------------------------------------------------

typedef struct phymul_pose {
  uint32_t size;
  double position[3];     // m
  double orientation[4];  // w, x, y, z; all 0: none
  double velocity[3];     // m/s, of the tool after the call, until it gets a new pose
  double spin[3];         // rad/s
} phymul_pose;

enum {
  PHYMUL_SPHERE = 0,
  PHYMUL_CAPSULE = 1,
  PHYMUL_HALF_SPACE = 2,
  PHYMUL_BOX = 3,
  PHYMUL_BLADE = 4,
  PHYMUL_NEEDLE = 5
};
enum { PHYMUL_TOUCHES_PARTICLES = 0, PHYMUL_TOUCHES_SURFACE = 1 };  // ToolContact

typedef struct phymul_needle {  // Needle: include/phymul/needle.h
  uint32_t size;
  double length;             // m; 0: 0.15
  double radius;             // m; 0: 0.64e-3
  double puncture;           // N; 0: 2
  double cutting;            // N; 0: 0.9
  double static_friction;    // N/m; 0: 15
  double kinetic_friction;   // N/m; 0: 10
  double spread;             // m; 0: from radius and spacing
  double bending_stiffness;  // N m^2; 0: stiff
  double arc_radius;         // m; 0: straight
  double leaving;            // N
} phymul_needle;

typedef struct phymul_tool_options {
  uint32_t size;
  int32_t shape;            // PHYMUL_SPHERE and so on: include/phymul/tool.h
  double radius;            // m, of a sphere or a capsule
  double length;            // m, of a capsule, or of a blade's edge
  double half_size[3];      // m, of a box
  const phymul_pose* pose;  // NULL: at the origin
  double friction;
  double compliance;  // m/N
  double margin;      // m
  int32_t contact;    // PHYMUL_TOUCHES_PARTICLES or PHYMUL_TOUCHES_SURFACE
  int32_t unused;
  double toughness;             // J/m^2, of a blade
  const phymul_needle* needle;  // of a needle; NULL: the defaults
  double belly;                 // m, of a blade: include/phymul/blade.h
  double bow;                   // m
  double height;                // m, of its sides
  double side_friction;         // N/m^2
  double suction;               // N
  double suction_reach;         // m
} phymul_tool_options;

typedef struct phymul_tool_force {  // of the particles on the tool
  uint32_t size;
  double force[3];        // N, of the last step
  double torque[3];       // N m, about the tool's position
  double mean_force[3];   // N, over the steps of the last call
  double mean_torque[3];  // N m
  int32_t particles;      // that it pushed or held
  int32_t held;           // that it holds
} phymul_tool_force;
PHYMUL_API phymul_status phymul_tool_add(phymul_simulation* sim, const phymul_tool_options* options, uint64_t* tool);
PHYMUL_API phymul_status phymul_tool_remove(phymul_simulation* sim, uint64_t tool);
PHYMUL_API phymul_status phymul_tool_move_to(phymul_simulation* sim, uint64_t tool, const phymul_pose* pose);
PHYMUL_API phymul_status phymul_tool_teleport(phymul_simulation* sim, uint64_t tool, const phymul_pose* pose);
PHYMUL_API phymul_status phymul_tool_grasp(phymul_simulation* sim, uint64_t tool, double distance);  // m
PHYMUL_API phymul_status phymul_tool_release(phymul_simulation* sim, uint64_t tool);
PHYMUL_API phymul_status phymul_tool_read_pose(phymul_simulation* sim, uint64_t tool, phymul_pose* pose);
PHYMUL_API phymul_status phymul_tool_read_force(phymul_simulation* sim, uint64_t tool, phymul_tool_force* force);

typedef struct phymul_needle_state {  // NeedleState
  uint32_t size;
  int32_t nodes;  // of the holes; 0: no contact
  int32_t punctured;
  int32_t through;  // the tip came out again
  int32_t is_free;  // let go
  double slip;      // m by which the tip has gone beyond the last node
} phymul_needle_state;
PHYMUL_API phymul_status phymul_needle_read(phymul_simulation* sim, uint64_t tool, phymul_needle_state* state);
// Fills [count][3] points from tip to hub, m, 2 or more.
PHYMUL_API phymul_status phymul_needle_points(phymul_simulation* sim, uint64_t tool, int32_t count, double* points);

// --- Jaws -----------------------------------------------------------------------------------------------------------

typedef struct phymul_jaws_options {
  uint32_t size;
  int32_t touches_particles;  // 0: the surface
  double length;              // m; 0: 0.02
  double width;               // m; 0: 0.006
  double thickness;           // m; 0: 0.006
  double friction;            // 0: 0.5
  double grip;                // N; 0: 1
  double opening;             // rad; 0: 0.6
  double speed;               // rad/s; 0: 0.5
  int32_t cuts;               // 1: scissors, edges in place of the plates
  int32_t unused;
  double toughness;  // J/m^2, of scissors
} phymul_jaws_options;

typedef struct phymul_jaws_report {  // N and N m: on the handle, in the tick before
  uint32_t size;
  double angle;  // rad
  double grip;   // N at the end of a plate
  double force[3];
  double torque[3];    // about the hinge
  uint64_t plates[2];  // tools
} phymul_jaws_report;
// Open, with the hinge at a pose. The tools "<name> 1" and "<name> 2" are of the simulation that it is used with.
PHYMUL_API phymul_status phymul_jaws_create(phymul_simulation* sim, const char* name,
                                            const phymul_jaws_options* options, const phymul_pose* hinge,
                                            phymul_jaws** made);
PHYMUL_API void phymul_jaws_free(phymul_jaws* jaws);
PHYMUL_API phymul_status phymul_jaws_close(phymul_jaws* jaws, int32_t closes);  // 0: opens
// Once in each tick of dt s, before phymul_advance.
PHYMUL_API phymul_status phymul_jaws_follow(phymul_jaws* jaws, phymul_simulation* sim, const phymul_pose* hinge,
                                            double dt);
PHYMUL_API phymul_status phymul_jaws_read(const phymul_jaws* jaws, phymul_simulation* sim, phymul_jaws_report* report);

// --- Joints ---------------------------------------------------------------------------------------------------------

typedef struct phymul_anchor {  // an end of a spring: a mean of particles, or a point of the world or of a tool
  uint32_t size;
  int32_t count;             // of particles
  const int32_t* particles;  // NULL: a point
  const double* weights;     // of sum 1; NULL: equal
  uint64_t tool;             // of the point; 0: the world
  double point[3];           // m, in the world or in the tool's frame
} phymul_anchor;

typedef struct phymul_joint_options {
  uint32_t size;
  int32_t slack;       // 1: pulls only
  double stiffness;    // N/m; phymul_attach: N/m^3
  double damping;      // N s/m; phymul_attach: N s/m^3
  double breaking;     // N; phymul_attach: Pa; 0: never
  double rest_length;  // m; below 0: the distance of the anchors when added; phymul_attach does not use it
} phymul_joint_options;

typedef struct phymul_joint_report {
  uint32_t size;
  double force[3];  // N, sum of the forces on the anchors `a`
  double largest;   // N, of a spring
  int32_t broken;   // number of broken springs
  int32_t springs;
} phymul_joint_report;

PHYMUL_API phymul_status phymul_joint_add(phymul_simulation* sim, const phymul_anchor* a, const phymul_anchor* b,
                                          const phymul_joint_options* options, uint64_t* joint);
// Scene::attach: a spring for each particle of a patch of the surface, to a body (`group`, if not NULL), else to a tool
// (if not 0), else to points of the world at `offset`, m, from where the particles are.
PHYMUL_API phymul_status phymul_attach(phymul_simulation* sim, const int32_t* particles, int32_t count,
                                       const char* group, uint64_t tool, const double offset[3],
                                       const phymul_joint_options* options, uint64_t* joint);
// Scene::hold, of the part in a ball of the surface that the body was made from. `spacing`, m: a third of the body's.
PHYMUL_API phymul_status phymul_hold_near(phymul_simulation* sim, const double* vertices, int32_t vertex_count,
                                          const int32_t* triangles, int32_t triangle_count, const double centre[3],
                                          double radius, double spacing, uint64_t* joint);
// add_body_types, for a body from a .pml file. `sentences`: a line each, valid until the next call of the same.
PHYMUL_API phymul_status phymul_add_body_types(phymul_simulation* sim, const char** sentences);
PHYMUL_API phymul_status phymul_joint_remove(phymul_simulation* sim, uint64_t joint);
PHYMUL_API phymul_status phymul_joint_set(phymul_simulation* sim, uint64_t joint, double stiffness, double damping);
PHYMUL_API phymul_status phymul_joint_read(phymul_simulation* sim, uint64_t joint, phymul_joint_report* report);

// --- Threads --------------------------------------------------------------------------------------------------------

typedef struct phymul_thread {  // Thread: include/phymul/thread.h
  uint32_t size;
  double length;             // m; 0: 0.3
  double radius;             // m; 0: 0.15e-3
  double young;              // Pa; 0: 2e9
  double bending_stiffness;  // N m^2; 0: of a solid round section
  double density;            // kg/m^3; 0: 920
  double segment;            // m; 0: 3e-3
  double damping;            // 1/s
  double friction;           // 0: 0.1
  double channel_friction;   // N
  double breaking_force;     // N; 0: never
  double passage_limit;      // N; 0: never
  double throw_holding;      // N; 0: 1
  int32_t touches;           // 1: a free thread lies on tools, tissue, itself and such threads
  int32_t unused;
} phymul_thread;

typedef struct phymul_clip {  // Clip: include/phymul/thread.h
  uint32_t size;
  double gap;      // m; 0: 0.5e-3
  double holding;  // N; 0: 1
  double opening;  // m; 0: 0.01
} phymul_clip;

typedef struct phymul_knot {  // KnotState; rows as phymul_thread_tie has them
  int32_t a;
  int32_t b;
  int32_t broken;
  int32_t unused;
  double rest_length;  // m
  double tension;      // N
  double slip;         // m
} phymul_knot;

typedef struct phymul_thread_state {  // ThreadState; the arrays are valid until the next call of phymul_thread_read
  uint32_t size;
  int32_t points;  // nodes; of a sewn thread: tips and passages; 0 before the first step of one
  int32_t segments;
  int32_t passages;  // that the thread still goes through
  int32_t knot_count;
  int32_t torn;                // passages
  int32_t pulled_out;          // passages
  int32_t sewn;                // passages that a needle has made
  double force_first[3];       // N, of the thread on what its first tip is anchored to
  double force_last[3];        // N
  const double* positions;     // [points][3] m
  const double* velocities;    // [points][3] m/s; NULL for a sewn thread
  const double* rest_lengths;  // [segments] m
  const double* tensions;      // [segments] N
  const int32_t* broken;       // [segments] 1: has no force
  const int32_t* rows;         // [passages], as phymul_thread_tie has them
  const int32_t* slides;       // [passages] 0: sticks; 1 or -1: slides toward the last or first tip
  const phymul_knot* knots;    // [knot_count]
  const double* touch;         // [points][3] N, that what it lies on pushes it with; NULL: it lies on nothing
} phymul_thread_state;

enum { PHYMUL_FIRST = 0, PHYMUL_LAST = 1 };  // ThreadTip

// NULL for a phymul_thread or phymul_clip: the defaults. Free, from a place along a direction; sewn through places, m
// at rest; sewn by a needle, a tool, whose tail is the last tip; and a clip, which is a thread too, between two walls.
PHYMUL_API phymul_status phymul_thread_add(phymul_simulation* sim, const phymul_thread* constants,
                                           const double start[3], const double direction[3], uint64_t* thread);
PHYMUL_API phymul_status phymul_thread_sew(phymul_simulation* sim, const phymul_thread* constants, const double* places,
                                           int32_t count, uint64_t* thread);
PHYMUL_API phymul_status phymul_thread_swage(phymul_simulation* sim, const phymul_thread* constants, uint64_t needle,
                                             uint64_t* thread);
PHYMUL_API phymul_status phymul_clip_add(phymul_simulation* sim, const phymul_clip* clip, const phymul_anchor* one,
                                         const phymul_anchor* other, uint64_t* thread);
PHYMUL_API phymul_status phymul_thread_remove(phymul_simulation* sim, uint64_t thread);
// As ThreadHandle: nodes of a free thread are held, `tip` is PHYMUL_FIRST or PHYMUL_LAST, and rows of passages are
// those of phymul_thread_sew, or in the order in which a needle makes them.
PHYMUL_API phymul_status phymul_thread_hold(phymul_simulation* sim, uint64_t thread, int32_t node,
                                            const double position[3]);
PHYMUL_API phymul_status phymul_thread_release(phymul_simulation* sim, uint64_t thread, int32_t node);
PHYMUL_API phymul_status phymul_thread_join(phymul_simulation* sim, uint64_t thread, int32_t tip,
                                            const phymul_anchor* anchor);
PHYMUL_API phymul_status phymul_thread_pull(phymul_simulation* sim, uint64_t thread, int32_t tip,
                                            const double force[3]);
PHYMUL_API phymul_status phymul_thread_fix(phymul_simulation* sim, uint64_t thread, int32_t tip);
PHYMUL_API phymul_status phymul_thread_clamp(phymul_simulation* sim, uint64_t thread, int32_t tip, double holding,
                                             double gap);  // gap below 0: the segment stays as long as it is
PHYMUL_API phymul_status phymul_thread_tie(phymul_simulation* sim, uint64_t thread, int32_t passage, int32_t other,
                                           int32_t throws);
PHYMUL_API phymul_status phymul_thread_loosen(phymul_simulation* sim, uint64_t thread, int32_t passage, int32_t other);
PHYMUL_API phymul_status phymul_thread_read(phymul_simulation* sim, uint64_t thread, phymul_thread_state* state);

// --- Fluids and tearing ---------------------------------------------------------------------------------------------

enum { PHYMUL_INCOMPRESSIBLE = 0, PHYMUL_GAS = 1, PHYMUL_CURVE = 2 };  // FluidLaw

typedef struct phymul_fluid {  // Fluid: include/phymul/fluid.h
  uint32_t size;
  int32_t law;
  double outer_pressure;  // Pa, of a gas; 0: 101325
  double exponent;        // of a gas; 0: 1
  const double* curve;    // [curve_points][2]: ratio of volumes, Pa
  int32_t curve_points;
  int32_t unused;
  double conductance;      // m^3/(Pa s); 0: closed
  double outlet_pressure;  // Pa
  const char* opens_into;  // name of another volume, behind the opening; NULL: the opening leads outside
} phymul_fluid;

// Scene::constrain_volume, of a closed surface of triangles with a name; those of phymul_constrain_volume are "volume
// 1" and so on, by how many volumes were added. volume: m^3. fluid NULL: incompressible.
PHYMUL_API phymul_status phymul_volume_add(phymul_simulation* sim, const char* name, const int32_t* triangles,
                                           int32_t triangle_count, double volume, const phymul_fluid* fluid);
PHYMUL_API phymul_status phymul_volume_remove(phymul_simulation* sim, const char* name);
PHYMUL_API phymul_status phymul_volume_set(phymul_simulation* sim, const char* name, double volume);  // m^3
PHYMUL_API phymul_status phymul_volume_set_fluid(phymul_simulation* sim, const char* name, const phymul_fluid* fluid);
// FluidState: m^3 without pressure, and Pa, after the last step.
PHYMUL_API phymul_status phymul_volume_read(phymul_simulation* sim, const char* name, double* volume, double* pressure);
// Scene::tear: all of the body, or one of its materials. J/m^2; radius, m; 0: two spacings.
PHYMUL_API phymul_status phymul_tear(phymul_simulation* sim, const phymul_material* material, double toughness,
                                     double radius);

#ifdef __cplusplus
}
#endif

#endif

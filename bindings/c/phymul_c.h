// SPDX-License-Identifier: MIT
//
// The C interface of phymul (C99): bodies, simulations, skins, states and the planner; phymul_c_interaction.h, which it
// includes, has tools, joints, threads and fluids. What the calls compute is described in the C++ headers, which have
// the same names. Guide: docs/guide/c.md.
//
// Values     SI units. A vector is three doubles, a list of N vectors 3 N doubles, row by row. Particles, cells and
//            vertices are counted from 0. Strings are UTF-8. A list of names or sentences is one string, a line each.
// Errors     Every function returns a status, PHYMUL_OK or the kind of error. phymul_last_error() then has a message
//            for people. After an error the outputs are as they were. NULL is an error where no comment allows it.
// Ownership  Functions copy what they are given. A handle made by a function (its last parameter) belongs to the
//            caller, who frees it; the order does not matter. Arrays and strings handed out belong to the handle: they
//            stay where they are until it is freed, unless a comment says less.
// Structs    A struct that begins with `size` wants sizeof of itself there, also where the function fills it. Fields of
//            options may be 0, which means the default in the comment. Newer versions add fields at the end, and still
//            take and fill the shorter struct. The other structs never change.
// Threads    One thread at a time may use a handle. Different handles are independent.
#ifndef PHYMUL_C_H
#define PHYMUL_C_H

#include <stdint.h>
#define PHYMUL_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t phymul_status;
enum {
  PHYMUL_OK = 0,
  PHYMUL_INVALID_ARGUMENT = 1,  // a value that is not allowed
  PHYMUL_UNKNOWN_NAME = 2,      // no group, tool, joint or backend has this name; the message lists the known ones
  PHYMUL_FILE_ACCESS = 3,       // a file cannot be opened, read or written
  PHYMUL_FILE_FORMAT = 4,       // a file is not what its format requires
  PHYMUL_INVALID_MODEL = 5,     // a body is inconsistent or degenerate
  PHYMUL_NOT_SUPPORTED = 6,     // this build or backend does not support what was asked for
  PHYMUL_DEVICE = 7,            // a driver, a GPU or the GL module failed
  PHYMUL_OUT_OF_MEMORY = 8,
  PHYMUL_STEP_FAILED = 9,  // a step or solve_static failed; the last good state is kept
  PHYMUL_INTERNAL = 10     // anything else
};

typedef struct phymul_surface phymul_surface;        // triangles
typedef struct phymul_body phymul_body;              // Model
typedef struct phymul_simulation phymul_simulation;  // Simulation
typedef struct phymul_skin phymul_skin;              // Skin with its triangles
typedef struct phymul_snapshot phymul_snapshot;      // Snapshot
typedef struct phymul_plan phymul_plan;              // Plan
typedef struct phymul_jaws phymul_jaws;              // Jaws

// Of the last error in this thread; "" before the first. Valid until the next error in this thread.
PHYMUL_API const char* phymul_last_error(void);
PHYMUL_API const char* phymul_version(void);  // "0.2.0"
// Names that phymul_options.backend accepts in this build, without "auto". Valid until the program ends.
PHYMUL_API phymul_status phymul_backends(const char** names);

// --- Surfaces -------------------------------------------------------------------------------------------------------

// STL, OBJ, PLY or glTF, mended; metres_per_unit of the file, 0: 1.
PHYMUL_API phymul_status phymul_surface_read(const char* path, double metres_per_unit, phymul_surface** made);
PHYMUL_API void phymul_surface_free(phymul_surface* surface);  // NULL is allowed, as in every function that frees
PHYMUL_API phymul_status phymul_surface_vertices(const phymul_surface* from, const double** vertices, int32_t* count);
PHYMUL_API phymul_status phymul_surface_triangles(const phymul_surface* surface, const int32_t** triangles,
                                                  int32_t* count);  // [count][3] vertices

// --- Bodies ---------------------------------------------------------------------------------------------------------

typedef struct phymul_material {
  uint32_t size;
  double young;                // Pa, > 0
  double poisson;              // in (-1, 1/2)
  double density;              // kg/m^3, > 0
  double retardation_time;     // s; it and the next two: dissipation (docs/guide/bodies.md), 0: none
  double relaxation_strength;  // 1
  double relaxation_time;      // s, > 0 with a relaxation_strength
  double stiffening[4];        // exponential, exponent, second, second_fades (include/phymul/model.h); 0: none
  double thickness;            // m, of walls of triangles; 0: not a wall
} phymul_material;
// fit_material to count points. goal 0: least squares, 1: least largest error; error and fitted_stresses may be NULL.
enum { PHYMUL_UNIAXIAL = 0, PHYMUL_SHEAR = 1, PHYMUL_FIT_EXPONENTIAL = 1, PHYMUL_FIT_SECOND = 2, PHYMUL_FIT_FADES = 4 };
PHYMUL_API phymul_status phymul_fit_material(const phymul_material* start, const int32_t* tests, const double* strains,
                                             const double* stresses, int32_t count, int32_t terms, int32_t goal,
                                             phymul_material* fitted, double* error, double* fitted_stresses);
// A place around which a body is finer (fine_near): `spacing` within `radius`, plus half the distance outside.
typedef struct phymul_fine_place {
  double place[3];  // m
  double radius;    // m, > 0
  double spacing;   // m, > 0
} phymul_fine_place;
// Types of cells; the order of vertices is in include/phymul/model.h.
enum { PHYMUL_TRIANGLE = 2, PHYMUL_TETRAHEDRON = 4, PHYMUL_WEDGE = 5, PHYMUL_PYRAMID = 6, PHYMUL_HEXAHEDRON = 7 };
// make_block (hexahedra, 6 neighbours), make_tetrahedral_block, make_cylinder: include/phymul/shapes.h has the groups.
PHYMUL_API phymul_status phymul_body_block(const double size[3], int32_t nx, int32_t ny, int32_t nz,
                                           phymul_body** made);
PHYMUL_API phymul_status phymul_body_tetrahedral_block(const double size[3], int32_t nx, int32_t ny, int32_t nz,
                                                       double jitter, uint32_t seed, phymul_body** made);
PHYMUL_API phymul_status phymul_body_cylinder(double radius, double length, int32_t rings, int32_t sectors,
                                              int32_t discs, phymul_body** made);
// .pml, or a mesh: .msh, .vtk, .vtu. metres_per_unit of the file, 0: 1e-3 for .pml and 1 for meshes.
PHYMUL_API phymul_status phymul_body_read(const char* path, double metres_per_unit, phymul_body** made);
// make_body: fills a closed surface, about `spacing` m apart, finer around places (NULL: nowhere). Group: "surface".
PHYMUL_API phymul_status phymul_body_fill(const double* vertices, int32_t vertex_count, const int32_t* triangles,
                                          int32_t triangle_count, double spacing, const phymul_fine_place* places,
                                          int32_t place_count, phymul_body** made);
// make_wall: the surface as the middle of a wall; no side longer than 1.4 `spacing`, m, or as it is (0).
PHYMUL_API phymul_status phymul_body_wall(const double* vertices, int32_t vertex_count, const int32_t* triangles,
                                          int32_t triangle_count, double spacing, const phymul_material* material,
                                          phymul_body** made);
// From particles at `rest` and cells: types [cell_count], first [cell_count + 1] and particles [first[cell_count]], of
// which cell i has those from first[i] to first[i + 1]. Without cells (cell_count 0, all three NULL) it is a body of
// points with 20 neighbours each. The mesh is checked, and cells that are turned inside out are turned round. Triangles
// are for phymul_body_wall.
PHYMUL_API phymul_status phymul_body_from_arrays(const double* rest, int32_t particle_count, const int32_t* types,
                                                 const int32_t* first, const int32_t* particles, int32_t cell_count,
                                                 phymul_body** made);
PHYMUL_API phymul_status phymul_body_moved(const phymul_body* body, const double by[3], phymul_body** made);
PHYMUL_API void phymul_body_free(phymul_body* body);
PHYMUL_API phymul_status phymul_body_rest(phymul_body* body, const double** rest, int32_t* particle_count);  // m
PHYMUL_API phymul_status phymul_body_masses(const phymul_body* body, double* masses);  // fills [particle_count], kg
PHYMUL_API phymul_status phymul_body_cells(phymul_body* body, const int32_t** types, const int32_t** first,  // as above
                                           const int32_t** particles, int32_t* cell_count);
PHYMUL_API phymul_status phymul_body_triangles(phymul_body* body, const int32_t** triangles, int32_t* count);
// Arrays of cells are valid until phymul_body_add_capsule, which adds triangles to the cells.
// Triangles are counter-clockwise seen from outside. Notes say what was found or corrected; they and the next two are
// valid until the next call of the same function with this body.
PHYMUL_API phymul_status phymul_body_notes(phymul_body* body, const char** notes);
PHYMUL_API phymul_status phymul_body_groups(phymul_body* body, const char** names);
PHYMUL_API phymul_status phymul_body_group(phymul_body* body, const char* name, const int32_t** particles, int32_t* n);
PHYMUL_API phymul_status phymul_body_add_group(phymul_body* body, const char* name, const int32_t* particles,
                                               int32_t count);
// A group of cells: phymul_body_set_material gives a material to exactly these.
PHYMUL_API phymul_status phymul_body_add_cell_group(phymul_body* body, const char* name, const int32_t* cells,
                                                    int32_t count);
PHYMUL_API phymul_status phymul_body_set_material(phymul_body* body, const phymul_material* material,
                                                  const char* group);  // NULL: the whole body
PHYMUL_API phymul_status phymul_body_add_capsule(phymul_body* body, const phymul_material* material);  // on all faces
PHYMUL_API phymul_status phymul_body_with_spare_particles(const phymul_body* body, int32_t count, phymul_body** made);
// cut_body along a plane, where (x - front_point) . front_normal is negative (NULL: everywhere). A new body.
PHYMUL_API phymul_status phymul_body_cut(const phymul_body* body, const double point[3], const double normal[3],
                                         const double* front_point, const double* front_normal, phymul_body** made);
// connected_bodies: the part that each particle is in, -1 for none, and the volume of each part, m^3. Valid until the
// next call with this body.
PHYMUL_API phymul_status phymul_body_parts(phymul_body* body, const int32_t** parts, int32_t* particle_count,
                                           const double** volumes, int32_t* count);

// --- Simulations ----------------------------------------------------------------------------------------------------

// TaskRunner: calls part(task, 0) ... part(task, count - 1), by any threads, and returns when all have returned.
typedef void (*phymul_part)(void* task, int32_t part);
typedef void (*phymul_run_parts)(void* user, int32_t count, phymul_part part, void* task);

typedef struct phymul_options {
  uint32_t size;
  int32_t threads;                  // of the backend "cpu"; 0: as many as the body has work for
  const char* backend;              // NULL: "auto"
  const phymul_material* material;  // NULL: bodies keep their materials
  double damping_rate;              // 1/s
  double step;                      // largest step, as a multiple of the stable one; 0: it follows the deformation
  double rest_tolerance;            // SolverOptions::rest_tolerance; 0: 1e-8
  int32_t sleeps;                   // 1: parts of the body that rest cost nothing (SolverOptions::sleep_tolerance)
  int32_t run_parts_width;          // with run_parts: how many parts can run side by side, 1 or more
  double sleep_tolerance;           // with `sleeps`; 0: results as without sleep
  phymul_run_parts run_parts;       // threads of the host; NULL: the library starts threads
  void* run_parts_user;
  int32_t tick_budget;  // SimulationOptions::tick_budget: cells that blades cut at most in a call; 0: all
  int32_t unused;
} phymul_options;
// Of one body (count 1, names NULL), or of several, each with a name; their groups are then "name/group".
PHYMUL_API phymul_status phymul_simulation_create(const phymul_body* const* bodies, const char* const* names,
                                                  int32_t count, const phymul_options* options,
                                                  phymul_simulation** made);
PHYMUL_API void phymul_simulation_free(phymul_simulation* sim);
PHYMUL_API phymul_status phymul_simulation_body(const phymul_simulation* sim, phymul_body** made);  // a copy
PHYMUL_API phymul_status phymul_fix(phymul_simulation* sim, const char* group);
PHYMUL_API phymul_status phymul_fix_particles(phymul_simulation* sim, const int32_t* particles, int32_t count);
// Scene::scale_stiffness: of one of the bodies' materials, or of all (NULL); always of the material's own stiffness.
PHYMUL_API phymul_status phymul_scale_stiffness(phymul_simulation* sim, const phymul_material* material, double factor);
PHYMUL_API phymul_status phymul_gravity(phymul_simulation* sim, const double acceleration[3]);  // m/s^2

// Types of loads: include/phymul/load.h. PHYMUL_FORCE is on each particle.
enum { PHYMUL_TRANSLATION = 0, PHYMUL_ROTATION = 1, PHYMUL_FORCE = 2, PHYMUL_PRESSURE = 3, PHYMUL_ACCELERATION = 4 };
// Its value is linear between values[i] (m, rad, N, Pa or m/s^2) at times[i], s, 0 before and constant after them.
// `direction`: zero for a pressure that acts inward. A translation imposes all three coordinates. `row` names the load.
PHYMUL_API phymul_status phymul_add_load(phymul_simulation* sim, int32_t type, const int32_t* particles, int32_t count,
                                         const double direction[3], const double* times, const double* values,
                                         int32_t value_count, int32_t* row);
PHYMUL_API phymul_status phymul_set_load(phymul_simulation* sim, int32_t row, const double* times, const double* values,
                                         int32_t value_count);
// Bodies touch each other, and themselves if `self`. margin, m; 0: a tenth of the mean edge.
PHYMUL_API phymul_status phymul_contacts(phymul_simulation* sim, double friction, double margin, int32_t self);
PHYMUL_API phymul_status phymul_constrain_volume(phymul_simulation* sim, const char* group);  // NULL: the whole body

// Simulation::remove_cells: rows of cells in the order of phymul_body_cells. Particles and cells keep their numbers.
PHYMUL_API phymul_status phymul_remove_cells(phymul_simulation* sim, const int32_t* cells, int32_t count);
PHYMUL_API phymul_status phymul_cut(phymul_simulation* sim, const double point[3], const double normal[3],
                                    const double* front_point, const double* front_normal, int32_t* whether);
PHYMUL_API phymul_status phymul_cuts(const phymul_simulation* sim, int32_t* count);  // that the body has, tears too

typedef struct phymul_step_report {
  uint32_t size;
  int32_t steps;            // done
  int32_t at_rest;          // the rest test holds at the end
  int32_t force_clamped;    // an elastic force was limited
  int32_t particle;         // where a failure happened; -1: unknown
  double time;              // s
  double dt;                // s
  double stable_step;       // s
  double residual;          // N, largest net force on a free particle
  double max_speed;         // m/s
  int32_t springs_broken;   // in this call, as the next three
  int32_t tissue_gave_way;  // punctures below the needle's own force
  int32_t uncut;            // cells that a blade has passed, or that should have torn, and that could not part
  int32_t torn;             // cells
  int32_t cut_later;        // cells that blades have passed and that wait for their cuts (tick_budget)
  int32_t unused;
} phymul_step_report;

typedef struct phymul_rest_report {
  uint32_t size;
  int32_t converged;
  int32_t folded;     // a cell that is flat or turned inside out; -1: none
  int32_t steps;      // done; solve_static: evaluations of forces
  int32_t collapsed;  // RestResult::collapsed; -1: none
  double time;        // s
  double residual;    // N; solve_static: net forces over loads
} phymul_rest_report;
// Simulation::advance and Simulation::step. PHYMUL_STEP_FAILED fills the report too. It may be NULL.
PHYMUL_API phymul_status phymul_advance(phymul_simulation* sim, double seconds, phymul_step_report* report);
PHYMUL_API phymul_status phymul_step(phymul_simulation* sim, int32_t steps, double dt, phymul_step_report* report);
// Not to converge is no error: phymul_rest_report.converged is 0, and phymul_message says why.
PHYMUL_API phymul_status phymul_run_to_rest(phymul_simulation* sim, int32_t most_steps, phymul_rest_report* report);
PHYMUL_API phymul_status phymul_solve_static(phymul_simulation* sim, double tolerance, int32_t most_evaluations,
                                             phymul_rest_report* report);  // 0: the defaults, 1e-6 and 3000
PHYMUL_API phymul_status phymul_follow_static(phymul_simulation* sim, double tolerance, int32_t most_evaluations,
                                              phymul_rest_report* report);  // with StaticOptions::predict
// A sentence about the last of these five calls, and Simulation::warnings(). Valid until the next call of the same.
PHYMUL_API phymul_status phymul_message(phymul_simulation* sim, const char** sentence);
PHYMUL_API phymul_status phymul_warnings(phymul_simulation* sim, const char** sentences);
PHYMUL_API phymul_status phymul_time(const phymul_simulation* sim, double* time);          // s
PHYMUL_API phymul_status phymul_step_limits(const phymul_simulation* sim, double* stable,  // s, the largest stable step
                                            double* taken);                                // s, that of phymul_advance
PHYMUL_API phymul_status phymul_backend(phymul_simulation* sim, const char** name);
PHYMUL_API phymul_status phymul_energy(const phymul_simulation* sim, double energy[3]);  // J: elastic, kinetic, gravity
// [N][3] m, m/s (at the state's time) and N (elastic, of the materials as phymul_scale_stiffness left them), in memory
// of the handle that the next call of the same function with it overwrites.
PHYMUL_API phymul_status phymul_positions(phymul_simulation* sim, const double** positions, int32_t* particle_count);
PHYMUL_API phymul_status phymul_velocities(phymul_simulation* sim, const double** velocities, int32_t* particle_count);
PHYMUL_API phymul_status phymul_forces(phymul_simulation* sim, const double** forces, int32_t* particle_count);
// Starts from [N][3] positions, m (NULL: at rest), and velocities, m/s (NULL: 0). Tools hold nothing.
PHYMUL_API phymul_status phymul_set_state(phymul_simulation* sim, double time, const double* positions,
                                          const double* velocities);
PHYMUL_API phymul_status phymul_snapshot_take(const phymul_simulation* sim, phymul_snapshot** made);
// Brings tools, joints and threads back. Those that were removed since then have new numbers.
PHYMUL_API phymul_status phymul_snapshot_restore(const phymul_snapshot* snapshot, phymul_simulation* sim);
PHYMUL_API void phymul_snapshot_free(phymul_snapshot* snapshot);
PHYMUL_API phymul_status phymul_save(const phymul_simulation* sim, const char* path);  // the state
PHYMUL_API phymul_status phymul_load(phymul_simulation* sim, const char* path);
PHYMUL_API phymul_status phymul_record(phymul_simulation* sim);  // from now on: repeat new poses
PHYMUL_API phymul_status phymul_save_recording(const phymul_simulation* sim, const char* path);
PHYMUL_API phymul_status phymul_replay(phymul_simulation* sim, const char* path);
PHYMUL_API phymul_status phymul_write_vtu(const phymul_simulation* sim, const char* path);

// --- Skins ----------------------------------------------------------------------------------------------------------

// Binds points [point_count][3], m, to the body at rest. The triangles are for normals; 0 and NULL are allowed.
PHYMUL_API phymul_status phymul_skin_create(const phymul_simulation* sim, const double* points, int32_t point_count,
                                            const int32_t* triangles, int32_t triangle_count, phymul_skin** made);
PHYMUL_API void phymul_skin_free(phymul_skin* skin);
// [point_count][3] places, m, and unit normals (zero without triangles) where the simulation is now, in memory of the
// skin that the next call overwrites. `normals` may be NULL.
PHYMUL_API phymul_status phymul_skin_deform(phymul_skin* skin, phymul_simulation* sim, const double** points,
                                            const double** normals);

// --- Planning -------------------------------------------------------------------------------------------------------

typedef struct phymul_candidate {
  double spacing;       // m, to build with
  const char* backend;  // the next three: for phymul_options
  double step;
  int32_t threads;
  int32_t unused;
} phymul_candidate;
// Makes a simulation of a candidate, with its scene, and hands it over to the library. Called by phymul_plan_create and
// phymul_plan_make, in their thread. PHYMUL_INTERNAL ends the planning; any other error leaves the candidate out.
typedef phymul_status (*phymul_builder)(void* user, const phymul_candidate* candidate, phymul_simulation** made);

typedef struct phymul_plan_options {  // PlanOptions: include/phymul/plan.h
  uint32_t size;
  int32_t most_threads;  // 0: the number of processors
  double max_error;      // in (0, 1); no default
  double rate;           // Hz; 0: not asked for
  double rest_in;        // s; 0: not asked for
  double head_room;      // 0: 0.8
  double probe_time;     // s; 0: compared at rest
  double coarsest;       // m; 0: no limit
  double finest;         // m; 0: no limit
  double budget;         // s; 0: 20
  const char* backends;  // a line each; NULL: "cpu"
} phymul_plan_options;

typedef struct phymul_trial {  // PlanTrial; figures that are not known are NaN
  phymul_candidate candidate;
  double mean_spacing;  // m
  double error;
  double tick;  // s of wall time
  double rest;  // s of wall time
  int32_t particles;
  int32_t keeps_error;
  int32_t keeps_time;
  int32_t unused;
} phymul_trial;

enum { PHYMUL_CHOSEN = 0, PHYMUL_MOST_ACCURATE = 1, PHYMUL_CHEAPEST = 2 };

PHYMUL_API phymul_status phymul_plan_create(phymul_builder builder, void* user, const phymul_plan_options* options,
                                            phymul_plan** made);
PHYMUL_API void phymul_plan_free(phymul_plan* plan);
PHYMUL_API phymul_status phymul_plan_report(const phymul_plan* plan, const char** report);  // for people
PHYMUL_API phymul_status phymul_plan_trials(const phymul_plan* plan, const phymul_trial** trials, int32_t* count);
// PHYMUL_CHOSEN, or one of the offers where the wishes are not kept; *exists is 0 if there is none.
PHYMUL_API phymul_status phymul_plan_choice(const phymul_plan* plan, int32_t which, phymul_trial* trial,
                                            int32_t* exists);
PHYMUL_API phymul_status phymul_plan_make(const phymul_plan* plan, int32_t which, phymul_simulation** made);

#ifdef __cplusplus
}
#endif

#include "phymul_c_interaction.h"

#endif

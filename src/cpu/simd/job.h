// SPDX-License-Identifier: MIT
//
// The input of the SIMD kernels: plain arrays, packed for one instruction set. A cluster is a run of particles near
// each other, with the terms that belong to them; its slots are its own particles in order, then those of other
// clusters that its terms touch, then one slot that stands for nothing, where idle lanes point.
//
// Vectors per slot or particle are four floats ("quads"), the fourth 0, aligned to 16 bytes. Within a slice they do not
// stand in the order of its lanes but in that of quad_of(). An "offset" is 16 * quad. A row is `lanes` of each of its
// columns, offsets first (as the bits of a float):
//   base     a, b, c; E1, E2 (3 each), lambda_b, lambda_c, beta / |w0|, 1 / |w0|^2, share    13 + 1 columns
//   volume   a, b, c, d; E1, E2, E3, 1 / (6 V) (2-D: 1 / (2 A)), stiffness                    15
//   enumerated, per neighbour i: E, alpha, A = sum over the others l of +- H_il E_l (+ where i < l); then per pair of
//            them 2 H, H = 2 sum of +- w beta / |w0|;
//            then per triple w beta / |w0|, 2 / |w0|^2; offsets apart                         7, 1 and 2
//   wall     vertices (6); tangents (3 each), second derivatives (3 each); per vertex but the first gradient (2), then
//            hessian (3); bending (6), shear, compliance                                       54
//   spring   other end; R, 1 / |R|^2 (0 for a spring without length), stiffness                6
// Bases and springs stand in slices: lane k of slice s belongs to particle s * lanes + k of the cluster.
#pragma once

#include <cstdint>

namespace phymul::cpu::simd {

inline constexpr int base_columns = 14;
inline constexpr int volume_columns = 15;
inline constexpr int spring_columns = 6;
inline constexpr int wall_columns = 54;
/// Where the vector of slot or particle `place` stands: in its slice lane 4 g + k is number k * lanes / 4 + g, so that
/// whole packs from memory are what a transposition of 4 x 4 blocks takes and gives. `lanes`: 4, 8 or 16.
constexpr std::int32_t quad_of(std::int32_t place, int lanes) {
  const std::int32_t lane = place & (lanes - 1);
  return place - lane + (lane & 3) * (lanes / 4) + (lane >> 2);
}

inline constexpr int neighbour_columns = 7;  ///< of `enumerated`

struct Slices {
  const std::int32_t* first = nullptr;  ///< [slices + 1] row of each slice in `rows`
  const float* rows = nullptr;
  int count = 0;
};

struct Rows {
  const float* rows = nullptr;
  int count = 0;
};

/// Slices whose lanes have their triples of neighbours in one order. Constants may serve several of them.
struct Enumerated {
  const std::int32_t* neighbours = nullptr;  ///< [slices] how many, plus the flags below
  const std::int32_t* offsets = nullptr;     ///< [neighbours][lanes] of each slice, one after another
  const std::int32_t* first = nullptr;       ///< [slices] first column of each in `rows`
  const float* rows = nullptr;
  int count = 0;
};
inline constexpr int most_enumerated = 20;  ///< neighbours
/// Pair j < k of so many neighbours is at this plus k.
constexpr int pairs_of(int count, int j) {
  return j * (2 * count - j - 3) / 2 - 1;
}
/// Beside their number: an earlier slice has the same constants; edges meet at angles too small to go by lengths.
inline constexpr std::int32_t known_constants = 1 << 30, thin_triples = 1 << 29;
inline constexpr std::int32_t neighbour_count = thin_triples - 1;  ///< mask
inline constexpr int most_enumerated_triples = most_enumerated * (most_enumerated - 1) * (most_enumerated - 2) / 6;

struct Job {
  const char* u = nullptr;           ///< [slots] m, displacements
  char* force = nullptr;             ///< [slots] N, added to
  char* pull = nullptr;              ///< [own] N, written: F of the own particles, where other particles gather it
  const float* stiffness = nullptr;  ///< [own] k_i, N/m
  bool rows_far = false;             ///< rows are in no cache near a core: asked for ahead
  bool far = false;                  ///< constants are in no cache
  Slices bases, springs;
  Enumerated enumerated;
  Rows volumes, walls;
  float* wall_stiffening = nullptr;  ///< [lanes] the largest of the rows (glsl/kernels/wall.glsl); null: not wanted
};

/// A link of a run: 32 bytes without a gap, by which equal ones are found.
struct RunLink {
  float there[3] = {0, 0, 0};  ///< C_de, m^2
  float stiffness = 0;         ///< N/m
  float back[3] = {0, 0, 0};   ///< -C_ed, m^2
  std::int32_t shift = 0;      ///< from a slot to the other
};

/// Links by the axes that their areas have: those of the axes in mask m are first[m] ... first[m + 1] - 1.
struct Stencil {
  std::int32_t first[9];
};

/// Slots side by side with the same stencil, up to the next run.
struct Run {
  std::int32_t first = 0, stencil = 0;
};

/// Slots of a lattice in the order of its lines, so that a lane is a slot and what a run gathers stands side by side.
/// Vectors and matrices stand apart by their components, `stride` floats each; at least `lanes` of each stand for
/// nothing, because lanes beyond a short run read what comes after.
struct Runs {
  const Run* runs = nullptr;                ///< [count + 1]; null: links go slot by slot
  const std::int32_t* first_run = nullptr;  ///< [slices + 1] the run of each slice's first slot
  const Stencil* stencils = nullptr;
  const RunLink* links = nullptr;
  float* components = nullptr;  ///< [run_components][stride]
  std::int64_t stride = 0;
};
/// Where among them: columns of Q, springs' forces, forces of stresses, displacements.
inline constexpr int run_stress = 0, run_spring = 9, run_force = 12, run_u = 15, run_components = 18;

/// Materials that dissipate (elastic/dissipation.h). Rows as Averaged::constants. A strain is xx, yy, zz, yz, zx, xy.
struct Dissipation {
  const float* constants = nullptr;  ///< [slices][dissipation_columns][lanes]
  const float* strains = nullptr;    ///< [slices][6 of E-, if rate, then 6 of Ev, if branch][lanes]
  float* next_strains = nullptr;     ///< the same after the step
  int elastic_columns = 0;           ///< of Averaged::constants
  float inverse_dt = 0;              ///< 1/s, of the step before
  bool rate = false, branch = false;
  bool fresh = false;  ///< in place of `strains`, those of this step
};
/// Two for the rate (2 mu T, lambda T, Pa s), two for the branch (2 mu, lambda times its factor, Pa), and
/// 1 - exp(-dt / tau).
inline constexpr int dissipation_columns = 5;

/// Links that a pass over Averaged::link reads ahead.
inline constexpr int links_ahead = 128;

/// Law::particle_averaged. A slot is a domain: the first of a particle is at the particle's quad, further ones follow
/// those of all particles. Slots of one slice stand in the order of quad_of(), and so do their constants' rows.
struct Averaged {
  const char* u = nullptr;                   ///< [slots] m, displacements; of further slots, copies
  char* stress = nullptr;                    ///< [slots][4] quads: columns of Q, Pa, and zeros
  char* force = nullptr;                     ///< [slots] N
  const float* constants = nullptr;          ///< [slices][2 + constants][lanes] 1/V, s mu, those of the energy
  const std::int32_t* link_range = nullptr;  ///< [slots][2] first and end in `link`; even numbers of each slot
  const std::int32_t* link = nullptr;        ///< byte offset of the other slot in `u`; `links_ahead` more at the end
  /// [slots] row of the first link in `links`, for either pass: C_de, m^2, and k, N/m; -C_ed and k. Inside a body these
  /// are the same, and equal ones are there once.
  const std::int32_t *stress_row = nullptr, *force_row = nullptr;
  const float* links = nullptr;              ///< [rows][4]
  Runs runs;                                 ///< in place of stress, links and their rows
  const Dissipation* dissipation = nullptr;  ///< null: no material dissipates
  float* sums = nullptr;          ///< [slices][9][lanes] V H by columns, for the dissipation; null: not wanted
  const float* factor = nullptr;  ///< [slots] of the stiffness (Scene::scale_stiffness), place by place; null: 1
  float* condition = nullptr;     ///< [slots] squared_condition (glsl/kernels), place by place; null: not wanted
  bool plane = false;
  bool far = false;  ///< the arrays are in no cache near a core: asked for ahead, where links go slot by slot
};

/// Particles [first, first + lanes * slices) of the body.
struct Move {
  const char* force = nullptr;               ///< rows of all clusters; null: no term has any
  const std::int32_t* own = nullptr;         ///< [slices] byte offset in `force` of each slice's own row
  const std::int32_t* halo_first = nullptr;  ///< [slices + 1] row of `halo`; null: no cluster but one
  const std::int32_t* halo = nullptr;        ///< [rows][lanes] byte offsets in `force`, of zeros where there is no more
  const char* pull = nullptr;                ///< by particle; null: nothing to gather
  const std::int32_t* give_first = nullptr;  ///< [slices + 1] row of `give`
  const float* give = nullptr;               ///< [rows][2][lanes] byte offset in `pull`, share
  const char* load = nullptr;                ///< [particles] N; null: none
  const char* target = nullptr;              ///< [particles] m; null: nothing imposed
  const std::int32_t* fixed = nullptr;       ///< [particles] bit a: coordinate a is imposed
  const float* inverse_mass = nullptr;       ///< [particles] 1/kg
  const float* mass = nullptr;               ///< [particles] kg, 0 where there is no particle
  const char* u = nullptr;                   ///< m
  const float* v = nullptr;                  ///< m/s, [slices][3][lanes]
  char* next_u = nullptr;
  float* next_v = nullptr;
  char* withheld = nullptr;  ///< [particles] N: what cut forces lack, PredictedStep::withheld(); null: not asked for
  std::uint8_t* was_cut = nullptr;  ///< [slices] whether a row of `withheld` is not 0
  int slices = 0;                   ///< of the body
  bool far = false;                 ///< the arrays are in no cache
  float gravity[3] = {0, 0, 0};     ///< m/s^2
  float dt = 0, inverse_dt = 0, damping = 1;
  float runaway_squared = 0;                                         ///< m^2/s^2
  float largest_acceleration = 0, largest_acceleration_squared = 0;  ///< m/s^2: elastic force over mass is cut to it
};

/// Largest squares, but for the displacement's over free coordinates, and whether a particle ran away.
struct MoveSummary {
  float acceleration = 0, force = 0, speed = 0, displacement = 0;
  float motion = 0;  ///< (m/s)^2: as speed, with imposed coordinates
  bool runaway = false;
  bool cut = false;  ///< some elastic force was
};

enum class BaseUse { conservative, averaged, attractor };

inline constexpr int most_energies = 8;
inline constexpr int constants_near_rest = 6;  ///< of Kernels::averaged_near_rest

/// The kernels of one instruction set.
struct Kernels {
  const char* name;
  int lanes;
  void (*bases[3][2])(const Job&);    ///< [BaseUse][plane]
  void (*enumerated[2])(const Job&);  ///< [averaged]
  void (*volumes[2][2])(const Job&);  ///< [plane][bounded]
  void (*walls)(const Job&);
  void (*springs)(const Job&);
  void (*spread_displacements)(const Averaged&, int slice, int end);  ///< to components, for runs
  /// [of runs][StrainEnergy][bounded]
  void (*averaged_stresses[2][most_energies][2])(const Averaged&, int slice, int end);
  /// The same for small changes of displacements `u`; Averaged::constants as TangentOf (kernel_text.h) says.
  void (*averaged_tangents[2][most_energies][2])(const Averaged&, int slice, int end);
  /// The same at rest; constants as StressNearRest says.
  void (*averaged_near_rest[2])(const Averaged&, int slice, int end);  ///< [of runs]
  /// Adds to the stresses what Averaged::dissipation gives; after averaged_stresses, which fills Averaged::sums.
  void (*add_dissipation[2])(const Averaged&, int slice, int end);  ///< [of runs]
  void (*scale_stresses[2])(const Averaged&, int slice, int end);   ///< [of runs]
  void (*averaged_forces[2])(const Averaged&, int slice, int end);  ///< [of runs]
  void (*move)(const Move&, int slice, int end, MoveSummary&);
};

extern const Kernels portable_kernels, neon_kernels, avx2_kernels, avx512_kernels;

}  // namespace phymul::cpu::simd

// SPDX-License-Identifier: MIT
//
// What phymul-run is asked to do.
#pragma once

#include <phymul/simulation.h>
#include <phymul/solver.h>
#include <phymul/topology.h>
#include <phymul/types.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

/// The particles in a ball.
struct GroupBall {
  std::string name;
  std::array<double, 4> ball{};  ///< m: x y z radius
};

struct GroupVector {
  std::string group;
  phymul::Vec3 value = phymul::Vec3::Zero();
};

struct RunOptions {
  std::string body;   ///< .pml, .msh, .vtk or .vtu, a surface, or a labelled image
  std::string loads;  ///< .lml; empty: none
  std::string out = "out";

  double length_unit = 0.0;        ///< m per unit of the body's file; 0: mm for .pml, m for meshes
  double spacing = 0.0;            ///< m, of the particles that fill a surface or image; 0: none was given
  std::vector<double> fine_balls;  ///< m, each x y z radius spacing: where a surface is filled more finely
  bool from_file = false;          ///< masses and stiffnesses of the file instead of the material
  phymul::Material material{.young = 10e3, .poisson = 0.3, .density = 1000.0};
  std::vector<phymul::GroupMaterial> materials;  ///< without density, which is that of `material`
  phymul::TopologyOptions topology;

  std::vector<GroupBall> groups;    ///< added to those of the file
  std::vector<GroupVector> forces;  ///< N in all, shared evenly by the particles of the group
  std::vector<GroupVector> moves;   ///< m, imposed displacement of the group
  std::vector<std::string> fixed_groups;
  std::vector<double> fixed_balls;  ///< m, each x y z radius
  std::vector<double> held_balls;   ///< the same, of the surface
  std::vector<double> cuts;         ///< each a point, m, and a normal of a plane: x y z x y z
  std::vector<double> cut_front;    ///< the same of the plane behind which they are cut; or none
  std::optional<phymul::Tearing> tearing;
  std::vector<double> gravity;  ///< m/s^2, three or none

  std::string backend = "auto";
  double damping_rate = 20.0;      ///< 1/s
  std::optional<double> dt;        ///< s; none: half of the stable step, or a little less
  std::optional<double> let_go;    ///< s; none: last date of the driven translations
  bool keep = false;               ///< never let go
  std::optional<double> max_time;  ///< s; none: 20 s after the last date
  double frame_interval = 0.05;    ///< s; 0: no frames
  bool pictures = true;
  int threads = 0;       ///< SolverOptions::threads
  bool profile = false;  ///< a table of what the passes of the steps cost
  bool quiet = false;    ///< nothing on the way

  bool plan = false;        ///< find spacing and threads for the next three, print them, and run nothing
  double max_error = 0.0;   ///< share of the displacement
  double rate = 1000.0;     ///< Hz
  double probe_time = 0.0;  ///< s of motion to compare; 0: at rest
};

/// None where the program should end now, with `exit_code` (help was asked for, or the words made no sense).
std::optional<RunOptions> read_run_options(int argc, char** argv, int& exit_code);

/// The same from the words of a file, without the program's name. Throws phymul::Error.
RunOptions run_options_of(const std::vector<std::string>& words);

/// A word as a shell reads it back.
std::string quoted_word(const std::string& word);

/// In as few digits as give the same number again.
std::string shortest_decimal(double value);

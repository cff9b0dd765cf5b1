// SPDX-License-Identifier: MIT
//
// What a scene does to a body, in textures: a class for each kind of what acts.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "device/float_scene.h"
#include "device/float_tools.h"
#include "fragment_state.h"
#include "gl/objects/pass.h"
#include "gl/solver/body_kind.h"
#include "gl/solver/device.h"

namespace phymul::gl {

/// Reduction: rows brought down to one, `branch` to one a draw; or so for each of several lists.
class Reduction {
 public:
  struct Result {
    const char* input;  ///< as later draws read it
    TexelFormat format = TexelFormat::rgba32f;
  };
  /// `rows` of a list; `what`: the name of the textures.
  Reduction(int rows, int branch, std::vector<Result> results, const char* what, int lists = 1);

  /// `first` has what it reads in place; `further` reads results.
  void draw(Pass& first, Pass& further);
  void draw(Pass& pass) { draw(pass, pass); }

  const Texture& result(std::size_t k = 0) const { return levels_.back().results[k]; }
  /// A row for each list.
  const Framebuffer& target() const { return levels_.back().target; }

 private:
  struct Level {
    std::vector<Texture> results;
    Framebuffer target;
    int rows = 0;
  };
  int rows_, lists_;
  std::vector<Result> results_;
  std::vector<Level> levels_;
};

/// A scene's loads in textures.
class FragmentLoads {
 public:
  /// Room for the values of as many instants. `tables` must outlive it.
  FragmentLoads(const Scene& scene, int instants, const FragmentTables& tables);

  const LoadKind& kind() const { return table_.kind(); }

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  /// Of an instant given to evaluate(), m/s^2: gravity and uniform accelerations.
  const Float4& gravity(std::size_t instant) const { return table_.gravity()[instant]; }

  void bind(Pass& pass) const;
  /// The pass that is multiplied by stiffness_factor.
  void bind_factors(Pass& pass) const { pass.input("stiffness_factor", factors_); }

 private:
  LoadTable table_;
  NamedTables tables_;
  Texture values_;   // null where nothing but gravity acts
  Texture factors_;  // null where no stiffness is scaled
};

/// The tools of a scene in textures, and, where they act on the device, what the particles do to each: added up per
/// particle step by step, and over the particles once a report.
class FragmentTools {
 public:
  static constexpr int rows_to_one = 16;  ///< of sum()

  /// `acts`: on the device; else joints alone look where they are.
  FragmentTools(const FloatTools& tools, bool acts);

  int count() const { return count_; }
  bool any_grid() const { return any_grid_; }
  void set_held(const FloatTools& tools);
  void set_frames(const FloatTools& tools);
  void bind(Pass& pass) const;

  /// A row for each tool and particle, drawn with tools_pass.glsl over the sums so far.
  void tell(Pass& pass);

  /// Brings the sums of the last tell() down to one row a tool.
  void sum(Pass& added);
  /// After sum(): the texels of a row of them, of which there are four; where they go from `offset` on in the buffer
  /// bound to GL_PIXEL_PACK_BUFFER.
  std::size_t texels() const { return static_cast<std::size_t>(added_->target().shape().texels()); }
  void copy(std::size_t offset) const;

 private:
  bool any_grid_;
  int count_, particles_;
  NamedTables tables_;
  Texture frames_, held_;
  std::array<std::array<Texture, 2>, 2> sums_;  // [turn]: forces, torques; a pass reads one and writes the other
  std::array<Texture, 2> last_;
  std::array<Framebuffer, 2> targets_;
  int turn_ = 0;                    // of the newest
  std::optional<Reduction> added_;  // forces, torques, and both of the last step
};

/// The volumes that a scene keeps in textures, and what passes write of them: where particles would go by themselves
/// and which way back, sums over facets level by level, and how far.
class FragmentVolumes {
 public:
  explicit FragmentVolumes(const FloatVolumes& volumes);

  int count() const { return count_; }
  /// Tables and what never changes of the others, for any of the passes.
  void bind(Pass& pass) const;

  /// Where step_pass.glsl leaves a step: displacement, velocity, acceleration.
  const Framebuffer& free_target() const { return free_target_; }

  /// The passes after it, which know the state the step began with.
  void follow_gradient(Pass& along);
  void sum(Pass& facets, Pass& sums);
  void find_roots(Pass& roots, int batch_step);
  /// For what ends the step.
  void bind_roots(Pass& step) const;

  /// The texels of the newest roots, and where they go from `offset` on in the buffer bound to GL_PIXEL_PACK_BUFFER.
  std::size_t texels() const { return static_cast<std::size_t>(root_targets_[0].shape().texels()); }
  void copy(std::size_t offset) const;

 private:
  struct Level {
    Texture sums;
    Framebuffer target;
    int first_node = 0, rows = 0;
  };

  int count_, particles_;
  NamedTables tables_;
  std::array<Texture, 3> free_;
  Texture along_;
  Framebuffer free_target_, along_target_;
  std::vector<Level> levels_;
  std::array<Texture, 2> roots_;  // [turn]: a pass reads one and writes the other
  std::array<Framebuffer, 2> root_targets_;
  std::size_t turn_ = 0;  // of the newest
};

/// The springs of a scene's joints in textures.
class FragmentJoints {
 public:
  static_assert(FragmentLayers::host_texels == FloatJoints::state_rows);

  /// The scene must outlive it.
  explicit FragmentJoints(FloatJoints joints);

  int count() const { return joints_.count(); }
  bool any_tool() const { return joints_.any_tool(); }
  /// Takes over changed constants of the scene.
  void follow();
  /// A pass that finds the forces of springs.
  void bind(Pass& pass) const;
  /// A pass that gathers them.
  void bind_gathering(Pass& pass) const;

  FragmentLayers state;

 private:
  FloatJoints joints_;
  Texture laws_;
  NamedTables springs_, ends_;
};

/// A step that the host acts in, between its forces and its motion: where particles would go, the list of those that
/// the host asks for, and what it adds. Room for all particles, so that no step allocates.
class FragmentOpenStep {
 public:
  /// `measured`: where free_pass.glsl leaves speeds.
  FragmentOpenStep(Index particles, const Texture& measured);

  const Framebuffer& target() const { return target_; }  ///< of free_pass.glsl
  /// A pass that reads what free_pass.glsl left.
  void bind(Pass& pass) const;
  void bind_pushes(Pass& pass) const;

  void set_gathered(std::span<const Index> rows);
  void gather(Pass& pass) const;
  void read(std::span<OpenRow> rows);
  void set_pushes(std::span<const Push> pushes);
  int push_count() const { return push_count_; }

 private:
  Texture force_, velocity_, withheld_;
  Framebuffer target_;
  Texture asked_, gathered_[3];
  Framebuffer gathered_target_;
  Texture push_rows_, push_forces_, push_shifts_;
  int asked_count_ = 0, push_count_ = 0;
  std::vector<Int4> rows_;
  std::vector<Float4> texels_, more_texels_;
};

/// What a scene does to a body, in textures. What it has nothing of is empty.
struct FragmentScene {
  /// Room for the values of as many instants. The scene and `tables` must outlive it. `on_host`: tools, contacts and
  /// kept volumes act there.
  FragmentScene(const Scene& scene, int instants, const FragmentTables& tables, const FloatTools& float_tools,
                bool on_host, const Texture& measured)
      : loads(scene, instants, tables) {
    if (FloatJoints own(scene, float_tools.middle()); !own.empty()) joints.emplace(std::move(own));
    if (on_host) {
      open.emplace(static_cast<Index>(scene.model().rest.size()), measured);
      if (joints && joints->any_tool()) tools.emplace(float_tools, false);
      return;
    }
    if (!float_tools.empty()) tools.emplace(float_tools, true);
    if (const FloatVolumes own = pack_volumes(scene); !own.empty()) volumes.emplace(own);
  }

  /// On the device.
  bool tools_act() const { return tools && !open; }

  FragmentLoads loads;
  std::optional<FragmentTools> tools;
  std::optional<FragmentVolumes> volumes;
  std::optional<FragmentJoints> joints;
  std::optional<FragmentOpenStep> open;
};

}  // namespace phymul::gl

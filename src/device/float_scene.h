// SPDX-License-Identifier: MIT
//
// FloatVolumes: the volumes that a scene keeps (Scene::constrain_volume), for backends that compute in float. Packed
// once from the scene; what a GPU is given, bit for bit, and what its mirror on the CPU reads.
//
// What a surface encloses is a difference from rest: the sum over facets a, b, c of what the tetrahedron o, a, b, c has
// gained, o a particle of the surface, with edges at rest that were differenced in double precision. So it is 0 to the
// last bit at rest and wherever the body went as it is. Lengths are over a unit, a power of 2 near the edge of a cube
// of the volume: the terms are of no unit, and floats of a body of any size hold them.
//
// Sums are trees, sixteen terms to one: their rounding grows with the logarithm of the facets, and every device adds in
// the same order.
//
// FloatJoints: the springs of a scene's joints in single precision, joint by joint, and which particles they pull.
//
// FloatContacts: what of a scene can touch (Scene::contacts), packed for backends that compute in float. Places at rest
// stand as FloatTools has them: from the middle of the rest shape, as two floats whose sum they are.
#pragma once

#include <phymul/scene.h>

#include <vector>

#include "interaction/contact_surface.h"
#include "interaction/joint_set.h"
#include "table_rows.h"

namespace phymul {

struct FloatVolumes {
  static constexpr Index terms_a_sum = 16;
  static constexpr std::size_t law_rows = 2, edge_rows = 3;

  /// [volumes][law_rows] unit (m), 1 / unit, mean mass of its particles / 6 (kg), 0; over unit^3: wanted volume less
  /// that at rest, how much may be missing where nothing can be done, 0, 0.
  std::vector<Float4> laws;
  std::vector<Int4> facets;   ///< a, b, c, o
  std::vector<Float4> edges;  ///< [facets][edge_rows] over the unit: X_a - X_o, X_b - X_a, X_c - X_a
  std::vector<Int4> ranges;   ///< [particles] first and end row of `around`, volume (-1: of none), 0
  std::vector<Int4> around;   ///< per particle and facet at it: a, b, c, row of the facet
  /// Sums: first and end of what they add, volume, 0. Those of the first level add facets, those of others nodes of the
  /// level before; the last level has one for each volume.
  std::vector<Int4> nodes;
  std::vector<Int4> levels;  ///< first and end node, 0, 0

  bool empty() const { return laws.empty(); }
  int count() const { return static_cast<int>(laws.size() / law_rows); }
};

/// Empty where the scene keeps none.
FloatVolumes pack_volumes(const Scene& scene);

class FloatJoints {
 public:
  static constexpr std::size_t place_rows = 3, law_rows = 2;
  /// Rows of a spring's state, as joint_law.glsl gives it: force on anchor a (N), 1 if broken; torque on its tool (N
  /// m), length (m); force and torque summed over the steps of a batch.
  static constexpr std::size_t state_rows = 4;

  /// `middle`: FloatTools::middle(). The scene must stay where it is.
  FloatJoints(const Scene& scene, const Vec3& middle);

  bool empty() const { return springs_.empty(); }
  Index count() const { return static_cast<Index>(springs_.size()); }
  bool any_tool() const { return any_tool_; }

  /// Per spring: first row of anchor a in anchors(), of anchor b, their end; row + 1 of the tool that anchor b is on,
  /// below 0 if anchor a is, 0: neither.
  const std::vector<Int4>& springs() const { return springs_; }
  const std::vector<Int4>& anchors() const { return anchors_; }  ///< particle, bits of its weight
  /// Per spring: from anchor a to b at rest, m; two rows that mean nothing. On a tool: where the particles are at rest,
  /// from the middle, as a sum of two; the anchor in the tool's frame.
  const std::vector<Float4>& places() const { return places_; }
  /// Per particle: first row and end of its ends().
  const std::vector<Int4>& ranges() const { return ranges_; }
  const std::vector<Int4>& ends() const { return ends_; }  ///< spring, bits of the share of its force

  /// Takes over stiffness, damping and rest lengths of the scene. True where they may have changed.
  bool follow();
  /// Per spring: k (N/m), c (N s/m), breaking force (N), 1 if slack; L, |R| - L (m).
  const std::vector<Float4>& laws() const { return laws_; }

 private:
  void add(const JointSpring& spring);
  void add_anchor(const Anchor& anchor);
  void gather();

  const Scene* scene_;
  Vec3 middle_;
  std::uint64_t seen_ = 0;  // Scene::values_version() + 1
  bool any_tool_ = false;
  std::vector<Int4> springs_, anchors_, ranges_, ends_;
  std::vector<Float4> places_, laws_;
  std::vector<double> rest_distance_;  // |R|
};

/// A step that a device has done, and the sums over a batch, [springs * state_rows], joint by joint.
std::vector<JointSet::Told> told_joints(std::span<const Float4> rows);
/// State rows to begin with: of each spring only whether it is broken.
std::vector<Float4> joint_rows(const std::vector<SceneJoint>& joints, const JointSet& known);

struct FloatContacts {
  /// Of a scene with contacts. Throws Error where bodies are too far apart for floats to tell cells of a grid apart.
  explicit FloatContacts(const Scene& scene);

  ContactOptions options;
  Index bodies = 0;           ///< that have triangles
  double longest_edge = 0.0;  ///< m

  // Rows as glsl/contact/contact_tables.glsl has them.
  std::vector<Int4> particle;        ///< row of the model, body or -1, bits of the mean edge around it (m)
  std::vector<Float4> rest;          ///< [2 particles] m
  std::vector<Int4> triangle;        ///< corners: rows of `particle`; 2 * body + 1 where it has an inside
  std::vector<Float4> triangle_law;  ///< longest edge, m

  bool empty() const { return triangle.empty(); }  ///< nothing can touch anything
  /// Of two that meet, together, m.
  double largest_skins() const {
    return 2.0 * (options.margin > 0.0 ? options.margin : ContactSurface::usual_skin * longest_edge);
  }
};

}  // namespace phymul

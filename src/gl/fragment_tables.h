// SPDX-License-Identifier: MIT
//
// The constants of a body on the device: FloatTables, a texture each, under the same names.
#pragma once

#include <vector>

#include "gl/pass.h"

namespace phymul::gl {

/// What a body holds, as far as shaders differ for it.
struct BodyKind {
  TopologyOptions options;
  int dimension = 3;
  Index particles = 0, bases = 0, volumes = 0, cells = 0;
  bool attractors = false;  ///< particles have a force F_i of their own: any reaction but the conservative
  bool base_terms = false;  ///< bases are evaluated a row each: averaged, conservative
  bool springs = false;
  bool enumerated = false;

  explicit BodyKind(const FloatTables& tables);
  bool conservative() const { return base_terms && !attractors; }
};

class FragmentTables {
 public:
  explicit FragmentTables(const FloatTables& tables);

  const BodyKind& kind() const { return kind_; }

  /// Gives a pass every table it reads.
  void bind(Pass& pass) const;

 private:
  struct Entry {
    const char* name;
    Texture texture;
  };
  template <class Row>
  void add(const char* name, const std::vector<Row>& rows);

  BodyKind kind_;
  std::vector<Entry> textures_;
  // Four lists share one texture, because a pass reads no more than sixteen; they start at these rows.
  int volume_start_ = 0, cell_start_ = 0, spring_start_ = 0;
};

}  // namespace phymul::gl

// SPDX-License-Identifier: MIT
//
// The constants of a body on the device: FloatTables, a texture each, under the same names.
#pragma once

#include <vector>

#include "gl/objects/pass.h"
#include "gl/solver/body_kind.h"

namespace phymul::gl {

class FragmentTables {
 public:
  explicit FragmentTables(const FloatTables& tables);

  const BodyKind& kind() const { return kind_; }
  const std::vector<Index>& materials() const { return materials_; }  ///< of domains, by row

  /// Gives a pass every table it reads.
  void bind(Pass& pass) const;

 private:
  BodyKind kind_;
  std::vector<Index> materials_;
  NamedTables tables_;
  // Of FloatEntries.
  int volume_start_ = 0, spring_start_ = 0;
};

}  // namespace phymul::gl

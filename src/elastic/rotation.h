// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

namespace phymul {

/// The rotation nearest to F.
Mat3 rotation_of(const Mat3& F);

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Where a body differs from the shape that it was filled from: parts that it lacks, and shells that are one.
#pragma once

#include <phymul/body.h>

#include <functional>
#include <string>

namespace phymul {

/// Parts of a shape farther from its body than the spacing asked for there, by samples: `sample` calls its argument
/// with each. "0.012 m around (0, 0, 0.1) m": the diagonal and the middle of a part's box, the longest first, five at
/// most and the number of the others. Empty: none.
std::string lost_parts(const std::function<void(const Contains&)>& sample, const Model& body,
                       const BodyOptions& options);

/// A note, if the body's surface has another number of shells, another Euler number (V - E + F) or more edges of more
/// than two faces than the surface; else empty.
std::string fused_note(const Surface& surface, const Model& body);

}  // namespace phymul

// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace phymul {

/// Calls `write` with a stream to a new file beside `path`, which takes the place of `path` only when complete (of
/// the file it names, where `path` is a link). A pipe or device is written to directly. Throws Error, and leaves no new
/// file, when anything fails.
void replace_file(const std::string& path, const std::function<void(std::ostream&)>& write);

}  // namespace phymul

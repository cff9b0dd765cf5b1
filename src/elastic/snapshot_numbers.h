// SPDX-License-Identifier: MIT
//
// Parts of a snapshot that are numbers alone.
#pragma once

#include <phymul/state.h>

#include <span>
#include <string_view>
#include <vector>

namespace phymul {

void put_numbers(std::string_view name, std::span<const double> numbers, Snapshot& snapshot);
bool has_part(std::string_view name, const Snapshot& snapshot);
/// [count]; none if there is no such part. Throws Error if it is of another body or not finite.
std::vector<double> numbers_of(std::string_view name, std::size_t count, const Snapshot& snapshot);

}  // namespace phymul

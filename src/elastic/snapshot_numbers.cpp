// SPDX-License-Identifier: MIT
#include "snapshot_numbers.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/checked_file.h"

namespace phymul {

void put_numbers(std::string_view name, std::span<const double> numbers, Snapshot& snapshot) {
  ByteWriter out;
  for (const double number : numbers) out.real(number);
  snapshot.parts.push_back({std::string(name), {out.bytes().begin(), out.bytes().end()}});
}

bool has_part(std::string_view name, const Snapshot& snapshot) {
  return std::ranges::find(snapshot.parts, name, &Snapshot::Part::name) != snapshot.parts.end();
}

std::vector<double> numbers_of(std::string_view name, std::size_t count, const Snapshot& snapshot) {
  const auto part = std::ranges::find(snapshot.parts, name, &Snapshot::Part::name);
  if (part == snapshot.parts.end()) return {};
  const std::string label = "the snapshot's part \"" + part->name + '"';
  const std::size_t bytes = count * sizeof(double);
  if (bytes == 0 || part->bytes.size() != bytes) {
    throw Error("Solver::restore: expected " + label + " to have " + std::to_string(bytes) +
                " bytes for this body and these options, got " + std::to_string(part->bytes.size()) +
                "; the solver keeps its state");
  }
  ByteReader in(part->name, {reinterpret_cast<const char*>(part->bytes.data()), bytes});
  std::vector<double> numbers(count);
  for (double& number : numbers) {
    number = in.real("a number");
    if (std::isfinite(number)) continue;
    throw Error("Solver::restore: " + label + " has a number that is not finite; the solver keeps its state");
  }
  return numbers;
}

}  // namespace phymul

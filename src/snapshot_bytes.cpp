// SPDX-License-Identifier: MIT
#include "snapshot_bytes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace phymul {
namespace {

bool all_finite(const VecList& list) {
  return std::all_of(list.begin(), list.end(), [](const Vec3& v) { return v.allFinite(); });
}

}  // namespace

void put_snapshot(ByteWriter& out, const Snapshot& snapshot) {
  out.u64(snapshot.state.position.size());
  out.real(snapshot.state.time);
  out.real(snapshot.last_dt);
  out.u32(static_cast<std::uint32_t>(snapshot.steps_at_rest));
  out.vectors(snapshot.state.position);
  out.vectors(snapshot.state.velocity);
  out.u8(snapshot.displacement.empty() ? 0 : 1);
  out.vectors(snapshot.displacement);
  out.u64(snapshot.parts.size());
  for (const Snapshot::Part& part : snapshot.parts) {
    out.text(part.name);
    out.text({reinterpret_cast<const char*>(part.bytes.data()), part.bytes.size()});
  }
}

Snapshot take_snapshot(ByteReader& in) {
  Snapshot snapshot;
  const std::size_t count = in.count(48, "a number of particles");
  snapshot.state.time = in.real("a time");
  snapshot.last_dt = in.real("the last step");
  const std::uint32_t rested = in.u32("a count of steps at rest");
  if (rested > static_cast<std::uint32_t>(std::numeric_limits<int>::max())) {
    in.fail("expected a count of steps at rest, got " + std::to_string(rested) + "; the file is damaged");
  }
  snapshot.steps_at_rest = static_cast<int>(rested);
  snapshot.state.position = in.vectors(count, "positions");
  snapshot.state.velocity = in.vectors(count, "velocities");
  const std::uint8_t displaced = in.u8("whether there are displacements");
  if (displaced > 1) in.fail("expected 0 or 1, got " + std::to_string(displaced) + "; the file is damaged");
  if (displaced == 1) snapshot.displacement = in.vectors(count, "displacements");
  const std::size_t parts = in.count(8, "a number of parts");
  for (std::size_t k = 0; k < parts; ++k) {
    Snapshot::Part part;
    part.name = in.text("a part's name");
    const std::string bytes = in.text("a part");
    part.bytes.assign(bytes.begin(), bytes.end());
    snapshot.parts.push_back(std::move(part));
  }
  const bool finite = is_finite(snapshot.state) && all_finite(snapshot.displacement) && snapshot.last_dt >= 0.0 &&
                      std::isfinite(snapshot.last_dt);
  if (!finite) in.fail("expected finite numbers in the state before this byte; it was written by something else");
  return snapshot;
}

}  // namespace phymul

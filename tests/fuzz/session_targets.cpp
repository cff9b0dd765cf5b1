// SPDX-License-Identifier: MIT
#include <phymul/recording.h>
#include <phymul/shapes.h>
#include <phymul/solver.h>
#include <phymul/topology_textures.h>

#include <memory>

#include "base/checked_file.h"
#include "fuzz_target.h"
#include "session/input_kinds.h"
#include "session/snapshot_bytes.h"

namespace phymul::fuzz {
namespace {

/// A file of sections with the checksums that its bytes have.
std::string with_checksums(std::string_view bytes) {
  std::string file(bytes);
  for (std::size_t start = 12; start + 16 <= file.size();) {
    ByteReader head("", std::string_view(file).substr(start + 4));
    const std::uint64_t length = head.u64("a length");
    if (length > file.size() - start - 16) break;
    const std::size_t end = start + 12 + static_cast<std::size_t>(length);
    ByteWriter sum;
    sum.u32(checksum(std::string_view(file).substr(start, end - start)));
    file.replace(end, 4, sum.bytes());
    start = end + 4;
  }
  return file;
}

std::string bytes_of(const Snapshot& snapshot) {
  ByteWriter out;
  put_snapshot(out, snapshot);
  return out.bytes();
}

/// Bits, so that 0 and -0 differ.
void check_snapshot(const Snapshot& snapshot) {
  require(is_finite(snapshot.state), "a state that is not finite");
  const std::string once = bytes_of(snapshot);
  ByteReader in("again", once);
  require(bytes_of(take_snapshot(in)) == once && in.remaining() == 0, "another state after writing and reading");
}

struct SmallBody {
  Model model = make_block({0.02, 0.02, 0.02}, 1, 1, 1);
  std::shared_ptr<const TopologyTextures> tables;
  SmallBody() {
    set_material(model, {.young = 1e4, .poisson = 0.3, .density = 1000});
    tables = std::make_shared<const TopologyTextures>(build_topology(model));
  }
};

const SmallBody& small_body() {
  static const SmallBody body;
  return body;
}

/// A recording may ask for any number of steps.
void shorten(Recording& recording) {
  if (recording.inputs.size() > 20) recording.inputs.resize(20);
  for (Input& input : recording.inputs) {
    input.times = 1;
    const bool steps =
        input.kind == input_kind::step || input.kind == input_kind::to_rest || input.kind == input_kind::to_rest_damped;
    if (!steps || input.bytes.size() < 4) continue;
    input.bytes.replace(1, 3, 3, '\0');  // n below 256
  }
}

}  // namespace

void state(std::string_view bytes) {
  const std::string file = with_checksums(bytes);
  Snapshot snapshot;
  if (!accepts_file("any.state", [&] { snapshot = read_state_bytes(file, "any.state"); })) return;
  check_snapshot(snapshot);
  for (const char* backend : {"reference", "cpu"}) {
    const Scene scene(small_body().model);
    const auto solver = make_solver(backend, small_body().tables, scene, {.threads = 1});
    snapshot.topology_hash = solver->topology_hash();
    const Snapshot before = solver->snapshot();
    if (accepts([&] { solver->restore(snapshot); })) {
      solver->step(2, 0.2 * solver->stable_step());
    } else {
      require(solver->snapshot() == before, "a state that was refused, but changed the solver");
    }
    require(is_finite(solver->read()), "a solver whose state is not finite");
  }
}

void recording(std::string_view bytes) {
  const std::string file = with_checksums(bytes);
  Recording read;
  if (!accepts_file("any.rec", [&] { read = read_recording_bytes(file, "any.rec"); })) return;
  check_snapshot(read.start);
  const std::string path = file_with("", ".rec");
  save_recording(read, path);
  require(read_recording(path) == read, "another recording after writing and reading");
  shorten(read);
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene(small_body().model);
    const auto solver = make_solver(backend, small_body().tables, scene, {.threads = 1});
    read.topology_hash = solver->topology_hash();
    read.options = recorded_options(*solver);
    accepts([&] { Replay(read, *solver, scene).run(); });
    require(is_finite(solver->read()), "a solver whose state is not finite");
  }
}

}  // namespace phymul::fuzz

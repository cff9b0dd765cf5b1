// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/recording.h>

#include <limits>
#include <ostream>

#include "base/byte_source.h"
#include "base/checked_file.h"
#include "base/files.h"
#include "snapshot_bytes.h"

namespace phymul {
namespace {

constexpr FileKind recording_kind{"phymulRe", 6, "a recording"};
constexpr const char* head_tag = "head";
constexpr const char* start_tag = "stat";
constexpr const char* scene_tag = "scne";
constexpr const char* inputs_tag = "inpt";
constexpr const char* substeps_field = "a number of substeps";  // only there if it is not 1

/// For a ByteWriter and a recording that is const, or a ByteReader and one that is not.
template <class Bytes, class Any>
void head_fields(Bytes& bytes, Any& recording) {
  bytes.field(recording.topology_hash, "the topology's hash");
  bytes.field(recording.backend, "a backend's name");
  bytes.field(recording.device, "a device's name");
  auto& options = recording.options;
  for (auto* value : {&options.damping_rate, &options.damping_factor, &options.max_displacement_per_step,
                      &options.rest_tolerance, &options.sleep_tolerance, &options.stable_step}) {
    bytes.field(*value, "an option");
  }
  bytes.field(options.rest_steps, "a number of steps");
  bytes.field(options.allows_unstable, "whether steps beyond the limit are allowed");
}

void put_inputs(ByteWriter& out, const std::vector<Input>& inputs) {
  out.u64(inputs.size());
  for (const Input& input : inputs) {
    out.raw(input.kind);
    out.u64(input.times);
    out.u64(input.bytes.size());
    out.raw(input.bytes);
  }
}

std::vector<Input> take_inputs(ByteReader& in) {
  std::vector<Input> inputs(in.count(20, "a number of inputs"));
  for (Input& input : inputs) {
    input.kind = in.raw(4, "an input's kind");
    input.times = in.u64("how often an input was made");
    if (input.times == 0) in.fail("expected 1 or more times, got 0; the file was written by something else");
    input.bytes = in.raw(in.count(1, "an input's length"), "an input");
  }
  in.expect_end("section \"inpt\"");
  return inputs;
}

}  // namespace

void save_recording(const Recording& recording, const std::string& path) {
  ByteWriter head, start, scene, inputs;
  head_fields(head, recording);
  if (recording.options.max_substeps != 1) head.field(recording.options.max_substeps, substeps_field);
  put_snapshot(start, recording.start);
  scene.raw(recording.scene);
  put_inputs(inputs, recording.inputs);
  SectionWriter file(recording_kind);
  file.add(head_tag, head);
  file.add(start_tag, start);
  file.add(scene_tag, scene);
  file.add(inputs_tag, inputs);
  const std::string bytes = file.finish();
  replace_file(path, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

Recording read_recording_bytes(std::string_view bytes, const std::string& name) {
  const std::vector<FileSection> sections =
      read_sections(name, bytes, recording_kind, {head_tag, start_tag, scene_tag, inputs_tag});
  Recording recording;
  const auto reader = [&](std::size_t k) { return ByteReader(name, sections[k].payload, sections[k].first_byte); };
  ByteReader head = reader(0), start = reader(1), inputs = reader(3);
  head_fields(head, recording);
  if (head.remaining() > 0) head.field(recording.options.max_substeps, substeps_field);
  const RecordedOptions& options = recording.options;
  if (!(options == options)) {
    head.fail("expected numbers as options before this byte, got NaN; the file was written by something else");
  }
  head.expect_end("section \"head\"");
  recording.start = take_snapshot(start);
  recording.start.topology_hash = recording.topology_hash;
  recording.start.backend = recording.backend;
  start.expect_end("section \"stat\"");
  recording.scene = sections[2].payload;
  recording.inputs = take_inputs(inputs);
  return recording;
}

Recording read_recording(const std::string& path) {
  return read_recording_bytes(read_whole_file(path, std::numeric_limits<std::size_t>::max()), path);
}

}  // namespace phymul

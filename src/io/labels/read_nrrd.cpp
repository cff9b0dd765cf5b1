// SPDX-License-Identifier: MIT
#include "voxels.h"

#ifdef PHYMUL_HAS_TEEM
#include <teem/nrrd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/files.h"

namespace phymul {
namespace {

using File = std::unique_ptr<Nrrd, Nrrd* (*)(Nrrd*)>;

constexpr IntegerCode integers[] = {
    {nrrdTypeChar, NumberType::int8},     {nrrdTypeUChar, NumberType::uint8},   {nrrdTypeShort, NumberType::int16},
    {nrrdTypeUShort, NumberType::uint16}, {nrrdTypeInt, NumberType::int32},     {nrrdTypeUInt, NumberType::uint32},
    {nrrdTypeLLong, NumberType::int64},   {nrrdTypeULLong, NumberType::uint64},
};

/// Characters of a path, and of a line of the header that is neither a key/value pair nor a comment. teem puts these
/// into its messages, whose buffer 1,000 of them overflow.
constexpr std::size_t longest_text = 512;

bool names_a_list(std::string_view line) {
  const std::string field = lower_case(line.substr(0, line.find(':')));
  return field.find("file") != std::string::npos && line.find("LIST") != std::string_view::npos;
}

/// `lists`: a name of a file, whatever is in it.
void require_line(const std::string& path, std::size_t number, std::string_view line, bool lists) {
  if (line.find('\0') != std::string_view::npos) {
    fail_format(path, number, "expected text in the header, got a byte of 0");
  }
  if (!lists && (line.starts_with('#') || line.find(":=") < line.find(": "))) return;
  if (line.size() > longest_text) {
    fail_format(path, number,
                "expected lines of at most " + std::to_string(longest_text) + " characters in the header, got " +
                    std::to_string(line.size()));
  }
  // teem gives numbered names of files to sprintf as they are.
  if (line.find('%') != std::string_view::npos) {
    fail_format(path, number,
                "expected a header without \"%\", as in numbered names of files; put the voxels into one");
  }
}

/// What teem must not see. It would also read other formats, by their first bytes. It ends a line at a lone carriage
/// return too, and does not end a list of files at an empty line. Returns where the header ends.
std::streamoff require_header(const std::string& path) {
  if (path.size() > longest_text) {
    fail_access(path, "expected a path of at most " + std::to_string(longest_text) + " characters for NRRD");
  }
  std::ifstream file = open_file(path);
  bool lists = false;
  std::string text;
  for (std::size_t number = 1; std::getline(file, text); ++number) {
    if (number == 1 && !text.starts_with("NRRD")) {
      fail_format(path, 1, "expected an image in NRRD, which begins with NRRD, got other bytes");
    }
    if (!lists && (text.empty() || text == "\r")) return file.tellg();
    for (std::string_view rest = text; !rest.empty();) {
      const std::string_view line = rest.substr(0, rest.find('\r'));
      rest.remove_prefix(std::min(rest.size(), line.size() + 1));
      require_line(path, number, line, lists);
      lists = lists || names_a_list(line);
    }
  }
  return 0;
}

/// Of gzipped voxels behind the header, which teem does not compare: it stops when it has all voxels.
void require_checksum(const std::string& path, std::streamoff start) {
  std::ifstream file = open_file(path);
  file.seekg(start);
  z_stream stream{};
  if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) throw std::bad_alloc();
  std::array<Bytef, 1 << 14> in{}, out{};
  int result = Z_OK;
  while (result == Z_OK && !file.eof()) {
    file.read(reinterpret_cast<char*>(in.data()), in.size());
    stream.next_in = in.data();
    stream.avail_in = static_cast<uInt>(file.gcount());
    do {
      stream.next_out = out.data();
      stream.avail_out = out.size();
      result = inflate(&stream, Z_NO_FLUSH);
    } while (result == Z_OK && stream.avail_out == 0);
    if (result == Z_BUF_ERROR) result = Z_OK;  // it wants the next bytes
  }
  inflateEnd(&stream);
  if (result == Z_STREAM_END) return;
  fail_format(path, 0,
              "expected an image in NRRD with whole voxels in gzip and their checksum; the file is cut off or damaged");
}

using Reading = std::unique_ptr<NrrdIoState, NrrdIoState* (*)(NrrdIoState*)>;

Reading make_reading() {
  Reading io(nrrdIoStateNew(), nrrdIoStateNix);
  if (!io) throw std::bad_alloc();
  return io;
}

/// The header alone, or all.
File load(const std::string& path, NrrdIoState* io, bool header_alone) {
  File file(nrrdNew(), nrrdNuke);
  if (!file) throw std::bad_alloc();
  nrrdIoStateSet(io, nrrdIoStateSkipData, header_alone ? AIR_TRUE : AIR_FALSE);
  if (nrrdLoad(file.get(), path.c_str(), io) == 0) return file;
  std::unique_ptr<char, void (*)(void*)> reasons(biffGetDone(NRRD), std::free);
  std::string last = reasons ? reasons.get() : "";
  // One reason a line, the innermost last.
  last = std::string(trim(last));
  last = std::string(trim(std::string_view(last).substr(last.rfind('\n') + 1)));
  fail_format(path, 0, "expected an image in NRRD, which teem cannot read: " + last);
}

/// teem makes other numbers of those that do not fit their type, and reads no further than it must.
std::vector<std::uint16_t> labels_of_text(const std::string& path, std::streamoff start, std::size_t count,
                                          NumberType type) {
  std::string text = read_whole_file(path, std::size_t{1} << 31);
  std::ranges::replace(text, ',', ' ');  // which teem takes for one, too
  ByteSource in(path, text);
  in.seek(static_cast<std::size_t>(start));
  std::vector<std::uint16_t> labels = labels_of(path, in, count, type);
  if (!in.word().empty()) in.fail("expected " + std::to_string(count) + " voxels, got more");
  return labels;
}

/// Metres.
double length_of(const std::string& path, const std::string& unit) {
  static const std::map<std::string, double> known{
      {"", 1e-3},      {"m", 1.0},          {"cm", 1e-2},        {"centi", 1e-2},  {"mm", 1e-3},
      {"milli", 1e-3}, {"\xc2\xb5m", 1e-6}, {"\xce\xbcm", 1e-6}, {"micron", 1e-6}, {"micro", 1e-6},
      {"um", 1e-6},    {"nm", 1e-9},        {"nano", 1e-9}};
  std::string name = lower_case(unit);
  if (name.size() > 2 && name.back() == 's') name.pop_back();
  for (const std::string_view metre : {"meter", "metre"}) {
    if (name.ends_with(metre)) name.resize(name.size() - (name == metre ? 4 : 5));
  }
  const auto found = known.find(name);
  if (found != known.end()) return found->second;
  fail_format(path, 0, "expected a length in m, cm, mm, um or nm, got \"" + unit + "\"");
}

/// Signs that turn a place of the file's space into one of RAS.
Vec3 turn_to_ras(const std::string& path, const Nrrd& file, LabelImage& image) {
  if (file.space == nrrdSpaceLeftAnteriorSuperior) return {-1, 1, 1};
  if (file.space == nrrdSpaceLeftPosteriorSuperior) return {-1, -1, 1};
  if (file.space != nrrdSpaceRightAnteriorSuperior) {
    image.notes.push_back(path + (file.spaceDim > 0
                                      ? ": does not say what its axes are to a patient (space); taken for RAS"
                                      : ": says nothing about its frame; taken to begin at 0, along x, y and z"));
  }
  return {1, 1, 1};
}

void set_frame(const std::string& path, const Nrrd& file, const std::vector<unsigned>& axes, LabelImage& image) {
  const auto directed = std::ranges::count_if(
      axes, [&](unsigned axis) { return file.spaceDim > 0 && std::isfinite(file.axis[axis].spaceDirection[0]); });
  const bool has_directions = directed == 3;
  if (directed % 3 != 0) fail_format(path, 0, "expected space directions of all three axes or of none");
  Vec3 units;
  int missing = 0, unspaced = 0;
  for (int k = 0; k < 3; ++k) {
    const char* own = has_directions ? file.spaceUnits[k] : file.axis[axes[k]].units;
    missing += !own || !*own;
    unspaced += !has_directions && !std::isfinite(file.axis[axes[k]].spacing);
    units[k] = length_of(path, own ? own : "");
  }
  if (missing % 3 != 0) fail_format(path, 0, "expected units of length for all axes or for none");
  if (unspaced % 3 != 0) fail_format(path, 0, "expected spacings of all three axes or of none");
  if (file.spaceDim != 0 && file.spaceDim != 3) {
    fail_format(path, 0, "expected a space of three dimensions, got " + std::to_string(file.spaceDim));
  }
  const Vec3 turn = turn_to_ras(path, file, image);
  if (file.spaceDim > 0 && !std::isfinite(file.spaceOrigin[0])) {
    image.notes.push_back(path + ": does not say where it begins (space origin); taken to begin at 0");
  }
  for (int k = 0; k < 3; ++k) {
    const NrrdAxisInfo& axis = file.axis[axes[k]];
    if (has_directions) {
      for (int row = 0; row < 3; ++row) image.step[k][row] = units[row] * turn[row] * axis.spaceDirection[row];
    } else {
      image.step[k] = units[k] * turn[k] * (std::isfinite(axis.spacing) ? axis.spacing : 1.0) * Vec3::Unit(k);
    }
    const double origin = file.spaceOrigin[k];
    image.origin[k] = std::isfinite(origin) ? units[k] * turn[k] * origin : 0.0;
  }
}

using SegmentNames = std::map<std::pair<std::int64_t, std::uint16_t>, std::string>;  // by layer and label

/// Of 3D Slicer's keys.
SegmentNames names_of(const Nrrd& file) {
  std::map<std::string, std::string> values;
  for (unsigned k = 0; k < nrrdKeyValueSize(&file); ++k) values[file.kvp[2 * k]] = file.kvp[2 * k + 1];
  SegmentNames names;
  for (const auto& [key, name] : values) {
    if (!key.starts_with("Segment") || !key.ends_with("_Name") || name.empty()) continue;
    const auto number = [&, segment = key.substr(0, key.size() - 4)](const char* what) {
      const auto found = values.find(segment + what);
      return parse_integer(found != values.end() ? found->second : "");
    };
    const std::optional<std::int64_t> label = number("LabelValue");
    if (!label || *label <= 0 || *label > 65535) continue;
    names[{number("Layer").value_or(0), static_cast<std::uint16_t>(*label)}] = name;
  }
  return names;
}

/// Makes one label a voxel of image.label, which has one a voxel and layer; `below`: numbers between those of two
/// layers. Layers have labels of their own: they are numbered anew.
void merge_layers(const std::string& path, const SegmentNames& names, std::size_t layers, std::size_t below,
                  LabelImage& image) {
  struct Own {
    Index voxels = 0;
    std::uint16_t number = 0;  // in the image
  };
  std::map<SegmentNames::key_type, Own> labels;
  for (std::size_t row = 0; row < image.label.size(); ++row) {
    if (image.label[row] != 0) ++labels[{row / below % layers, image.label[row]}].voxels;
  }
  if (labels.size() > 65535) fail_format(path, 0, "expected at most 65535 labels in all layers");
  std::string text;
  for (auto& [key, own] : labels) {
    own.number = static_cast<std::uint16_t>(image.names.size() + 1);
    const auto named = names.find(key);
    const std::string other = "label " + std::to_string(key.second) + " of layer " + std::to_string(key.first);
    const std::string& name = image.names[own.number] = named != names.end() ? named->second : other;
    text += (text.empty() ? "" : ", ") + std::to_string(own.number) + " (" + name + ')';
  }
  image.notes.push_back(path + ": segments are in layers; their labels are numbered anew: " + text);
  std::vector<std::uint16_t> merged(image.label.size() / layers);
  std::size_t shared = 0;
  for (std::size_t voxel = 0; voxel < merged.size(); ++voxel) {
    const Own* least = nullptr;
    int here = 0;
    for (std::size_t layer = 0; layer < layers; ++layer) {
      const auto own = labels.find(
          {static_cast<std::int64_t>(layer), image.label[(voxel / below * layers + layer) * below + voxel % below]});
      if (own == labels.end()) continue;
      if (!least || own->second.voxels < least->voxels) least = &own->second;
      shared += ++here == 2;
    }
    if (least) merged[voxel] = least->number;
  }
  image.label = std::move(merged);
  if (shared == 0) return;
  image.notes.push_back(path + ": " + std::to_string(shared) +
                        " voxels are in more than one segment; each went to the smaller one");
}

}  // namespace

LabelImage read_nrrd(const std::string& path) {
  static std::mutex one_at_a_time;  // teem collects its reasons in one place
  const std::scoped_lock lock(one_at_a_time);
  const std::streamoff start = require_header(path);
  const Reading of_header = make_reading();
  const File header = load(path, of_header.get(), true);
  const NumberType type = integer_type(path, integers, header->type, airEnumStr(nrrdType, header->type));
  std::vector<std::int64_t> sizes;
  std::vector<unsigned> axes;      // of space
  std::optional<unsigned> layers;  // 3D Slicer's, of segments that overlap
  for (unsigned axis = 0; axis < header->dim; ++axis) {
    sizes.push_back(static_cast<std::int64_t>(header->axis[axis].size));
    const bool is_list = header->dim == 4 && header->axis[axis].kind == nrrdKindList;
    if (is_list) layers = axis;
    if (!is_list) axes.push_back(axis);
  }
  if (axes.size() != 3) {
    fail_format(path, 0,
                "expected an image of three dimensions, or a fourth of kind \"list\" for layers of segments, got " +
                    std::to_string(header->dim) + "; save one label image of it");
  }
  for (const unsigned axis : axes) {
    const int kind = header->axis[axis].kind;
    if (kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace) continue;
    fail_format(path, 0, std::string("expected three axes of space, got one of kind ") + airEnumStr(nrrdKind, kind));
  }
  const std::size_t count = voxel_count(path, sizes, type);
  const bool elsewhere = of_header->dataFNFormat != nullptr || of_header->dataFNArr->len > 0;
  // bzip2 makes gigabytes of some hundred bytes.
  if (!elsewhere && of_header->encoding != nrrdEncodingBzip2) require_voxel_bytes(path, count, type);
  const bool is_at_start = !elsewhere && of_header->lineSkip == 0 && of_header->byteSkip == 0;
  if (is_at_start && of_header->encoding == nrrdEncodingGzip) require_checksum(path, start);
  if (is_at_start && of_header->encoding == nrrdEncodingRaw) {
    const std::uint64_t all = static_cast<std::uint64_t>(start) + count * size_of(type);
    require_whole_voxels(path, std::max<std::uint64_t>(std::filesystem::file_size(path), all) - all, type);
  }

  LabelImage image;
  for (int k = 0; k < 3; ++k) image.size[k] = static_cast<Index>(sizes[axes[k]]);
  if (of_header->encoding == nrrdEncodingAscii) {
    if (!is_at_start) fail_format(path, 0, "expected ascii right behind the header; save it with encoding raw or gzip");
    image.label = labels_of_text(path, start, count, type);
  } else {
    const File file = load(path, make_reading().get(), false);
    ByteSource in(path, {static_cast<const char*>(file->data), count * size_of(type)});
    in.use_binary(false);
    image.label = labels_of(path, in, count, type);
  }
  set_frame(path, *header, axes, image);
  const SegmentNames names = names_of(*header);
  if (layers) {
    const auto below = std::accumulate(sizes.begin(), sizes.begin() + *layers, std::int64_t{1}, std::multiplies<>());
    merge_layers(path, names, static_cast<std::size_t>(sizes[*layers]), static_cast<std::size_t>(below), image);
  } else {
    for (const auto& [key, name] : names) image.names[key.second] = name;
  }
  return image;
}

}  // namespace phymul

#else

namespace phymul {

LabelImage read_nrrd(const std::string& path) {
  fail_without(path, "teem", "libteem-dev");
}

}  // namespace phymul

#endif

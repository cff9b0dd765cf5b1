// SPDX-License-Identifier: MIT
//
// What the readers of labelled images share.
#pragma once

#include <phymul/label_file.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/byte_source.h"

namespace phymul {

/// A format's own number of a type of integers, and that type.
struct IntegerCode {
  int code;
  NumberType type;
};

/// The type behind a format's number. Throws Error where it is none of these; `name` is what the format calls it.
NumberType integer_type(const std::string& path, std::span<const IntegerCode> known, int code, const char* name);

/// Numbers of these sizes that an image holds. Throws Error for a size below 1, and for more than 2^31 bytes.
std::size_t voxel_count(const std::string& path, const std::vector<std::int64_t>& sizes, NumberType type);

/// Throws Error: the file ends before its voxels do.
[[noreturn]] void fail_missing_voxels(const std::string& path, std::size_t count, NumberType type);

/// Throws Error where the bytes behind the voxels hold a part of one: some were added or lost.
void require_whole_voxels(const std::string& path, std::uint64_t more, NumberType type);

/// Throws it where a file cannot hold so many bytes of voxels, however well deflated.
void require_voxel_bytes(const std::string& path, std::size_t count, NumberType type);

/// The next numbers as labels. Throws Error for one that is not from 0 to 65,535, or to 255 where it has 8 bits.
std::vector<std::uint16_t> labels_of(const std::string& path, ByteSource& in, std::size_t count, NumberType type);

/// Throws Error unless the steps are finite and span space.
void require_frame(const std::string& path, const LabelImage& image);

/// Throws Error: `what` reads the format, and phymul was built without it.
[[noreturn]] void fail_without(const std::string& path, const std::string& what, const std::string& package);

LabelImage read_nifti(const std::string& path, const LabelFileOptions& options);
LabelImage read_nrrd(const std::string& path);

}  // namespace phymul

// SPDX-License-Identifier: MIT
//
// Labelled images from files.
#pragma once

#include <phymul/labels.h>

#include <string>

namespace phymul {

/// Reads .nii and .nii.gz (NIfTI-1, where phymul was built with nifticlib), .nrrd and .nhdr (NRRD, where it was built
/// with teem): three-dimensional images of integers from 0 to 65,535. Lengths become metres; files that name no unit
/// are taken to be in millimetres.
///
/// Places are in the frame of NIfTI, RAS: x to the patient's right, y to the front, z to the head. NRRD files in LPS or
/// LAS are turned into it. Programs made with ITK show coordinates in LPS, where x and y have the opposite sign; so do
/// many STL files made from segmentations. Of a NIfTI file the sform is used, else the qform, else the voxel sizes
/// alone. A file that says nothing about its frame is noted. NRRD files of 3D Slicer also give names.
///
/// Throws Error for a file that cannot be read or ends early, other types and dimensions, values that are scaled or out
/// of range, a frame that is singular, more than 2^31 bytes of voxels, and if phymul was built without the library.
LabelImage read_labels(const std::string& path);

}  // namespace phymul

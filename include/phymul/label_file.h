// SPDX-License-Identifier: MIT
//
// Labelled images from files.
#pragma once

#include <phymul/labels.h>

#include <string>

namespace phymul {

/// Which of the two frames of a NIfTI file to use.
enum class NiftiFrame { either, sform, qform };

struct LabelFileOptions {
  /// sform, qform: that one, without comparison; an Error if the file has none. either: as read_labels() says.
  NiftiFrame nifti_frame = NiftiFrame::either;
};

/// Reads .nii and .nii.gz (NIfTI-1, where phymul was built with nifticlib), .nrrd and .nhdr (NRRD, where it was built
/// with teem): three-dimensional images of integers from 0 to 65,535. Lengths become metres; files that name no unit
/// are taken to be in millimetres.
///
/// Places are in the frame of NIfTI, RAS: x to the patient's right, y to the front, z to the head. NRRD files in LPS or
/// LAS are turned into it. Programs made with ITK show coordinates in LPS, where x and y have the opposite sign; so do
/// many STL files made from segmentations. Of a NIfTI file the sform is used, else the qform, else the voxel sizes
/// alone. If sform and qform disagree, a note has the distance. A file that says nothing about its frame, or not where
/// it begins, is noted.
///
/// NRRD files of 3D Slicer also give names, and may have a fourth axis of kind "list" with layers of segments: a voxel
/// in several segments gets the one of fewest voxels, and the labels are numbered anew; notes say so.
///
/// Throws Error for a file that cannot be read or ends early, other types and dimensions, values that are scaled or out
/// of range, a frame that is singular or said in part, axes that are not of space, sform and qform that are mirror
/// images of each other unless `options` chooses one, more than 2^31 bytes of voxels, and if phymul was built without
/// the library.
LabelImage read_labels(const std::string& path, const LabelFileOptions& options = {});

}  // namespace phymul

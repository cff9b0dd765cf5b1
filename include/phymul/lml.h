// SPDX-License-Identifier: MIT
//
// Loads Markup Language: what acts on the body, as an XML file.
#pragma once

#include <phymul/scene.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace phymul {

/// Reads loads for a model; appliedTo indices are the model's file indices (rows where it has none), names its
/// groups. All units are converted to SI; a load without a unit is taken in mm, radian, N, kPa or m/s^2.
/// Throws Error ("file:line: ...") and leaves nothing behind; assumed units and skipped elements each leave a
/// sentence in `notes` where given.
std::vector<Load> read_lml(const std::string& path, const Model& model, std::vector<std::string>* notes = nullptr);

/// The same from memory; `source` stands for the file name in messages.
std::vector<Load> read_lml_text(std::string text, const std::string& source, const Model& model,
                                std::vector<std::string>* notes = nullptr);

/// Writes loads in SI-near units (mm, radian, N, kPa, m/s^2) so that reading gives equal ones.
void write_lml(const std::vector<Load>& loads, const Model& model, const std::string& path);
void write_lml(const std::vector<Load>& loads, const Model& model, std::ostream& out);

}  // namespace phymul

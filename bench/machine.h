// SPDX-License-Identifier: MIT
//
// On what a result was measured.
#pragma once

#include <string>
#include <utility>
#include <vector>

std::string today();  ///< UTC
/// Processes that wanted a processor in the minute before, on average: a quiet machine has none or one.
std::string load_before();
std::string processor();  ///< its name, as the system tells it

/// Date, phymul's version, processor, compiler and flags, in the order to print them.
std::vector<std::pair<std::string, std::string>> machine_facts();

/// Is a device, as Solver::device names it, a processor that plays GPU? Its times are never called a GPU's.
bool is_software(const std::string& device);

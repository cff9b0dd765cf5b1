// SPDX-License-Identifier: MIT
#include "machine.h"

#include <phymul/version.h>

#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <thread>

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", std::gmtime(&now));
  return text.data();
}

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string load_before() {
  std::ifstream load("/proc/loadavg");
  std::string minute;
  return load >> minute ? minute : "unknown";
}

std::vector<std::pair<std::string, std::string>> machine_facts() {
  return {
      {"date", today()},
      {"phymul", PHYMUL_VERSION},
      {"processor", processor() + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads"},
      {"load before the run", load_before() + " (1 or less is quiet)"},
      {"compiler", "GCC or compatible " __VERSION__},
      {"build", PHYMUL_BENCH_BUILD},
      {"compiled shaders kept by Mesa", std::getenv("MESA_SHADER_CACHE_DISABLE") ? "no" : "yes, from earlier runs"}};
}

bool is_software(const std::string& device) {
  for (const char* name : {"llvmpipe", "softpipe", "SwiftShader", "software"}) {
    if (device.find(name) != std::string::npos) return true;
  }
  return false;
}

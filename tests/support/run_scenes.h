// SPDX-License-Identifier: MIT
//
// Runs that tests of saved states and recordings share.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cstring>
#include <functional>
#include <random>

#include "base/checked_file.h"
#include "bodies.h"
#include "message_of.h"
#include "steps.h"

namespace phymul::test {

/// A calibrated block, 1,000 particles and so more than one cluster, wherever it is asked to stand.
inline Model block_at(const Vec3& origin) {
  return with_material(moved(make_block({0.06, 0.03, 0.03}, 15, 8, 8), origin));
}

inline Load pull(const Model& model, const char* group, const Vec3& direction, std::vector<ValueEvent> events,
                 LoadType type = LoadType::translation) {
  return {.type = type,
          .particles = model.group(group),
          .events = std::move(events),
          .direction = direction,
          .applied_to = group};
}

struct BackendCase {
  const char* name;
  int threads;
};
inline constexpr BackendCase cpu_backends[] = {{"reference", 0}, {"cpu", 1}, {"cpu", 2}};

inline SolverOptions options_for(const BackendCase& backend, double damping = 5.0) {
  return {.damping = {.rate = damping}, .threads = backend.threads};
}

inline std::string path_for(const char* name) {
  return testing::TempDir() + "phymul_" + name;
}

/// Bits, not values: 0 and -0 differ.
inline bool same_bits(const VecList& a, const VecList& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(Vec3) * a.size()) == 0;
}
inline bool same_bits(const State& a, const State& b) {
  return a.time == b.time && same_bits(a.position, b.position) && same_bits(a.velocity, b.velocity);
}

/// A file's bytes are read as they are, but not cut at any byte nor with any bit turned.
inline void expect_damage_is_refused(const std::string& good, const std::function<void(const std::string&)>& read) {
  ASSERT_EQ(message_of([&] { read(good); }), "(no error)");
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_NE(message_of([&] { read(good.substr(0, length)); }), "(no error)") << length;
  }
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ 1 << bit % 8);
    EXPECT_NE(message_of([&] { read(bad); }), "(no error)") << bit;
  }
}

/// Erases, inserts or turns a few of some bytes, as a program with a mistake would write them.
inline void hurt(std::string& bytes, std::mt19937& bits) {
  for (std::size_t times = 1 + bits() % 3; times > 0 && !bytes.empty(); --times) {
    const std::size_t at = bits() % bytes.size();
    const unsigned way = bits() % 4;
    if (way == 0) bytes.erase(at, 1 + bits() % 9);
    if (way == 1) bytes.insert(at, 1 + bits() % 9, '\xff');
    if (way > 1) bytes[at] = static_cast<char>(bytes[at] ^ 1 << bits() % 8);
  }
}

/// Damage behind right checksums, in any section but the first: `use` takes a file or throws an Error.
inline void expect_mutants_are_harmless(const FileKind& kind, std::initializer_list<std::string_view> tags,
                                        const std::string& good, const std::function<void(const std::string&)>& use) {
  const std::vector<FileSection> sections = read_sections("good", good, kind, tags);
  std::mt19937 bits(5);
  int taken = 0, refused = 0;
  for (int k = 0; k < 4000; ++k) {
    SectionWriter file(kind);
    const std::size_t hurt_one = 1 + bits() % (sections.size() - 1);
    for (std::size_t s = 0; s < sections.size(); ++s) {
      std::string bytes(sections[s].payload);
      if (s == hurt_one) hurt(bytes, bits);
      ByteWriter payload;
      payload.raw(bytes);
      file.add(sections[s].tag, payload);
    }
    ++(message_of([&] { use(file.finish()); }) == "(no error)" ? taken : refused);
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 1000);
}

}  // namespace phymul::test

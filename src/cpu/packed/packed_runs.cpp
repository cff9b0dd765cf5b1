// SPDX-License-Identifier: MIT
#include "packed_averages.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <tuple>

namespace phymul::cpu {
namespace {

/// Links of `lanes` slots at once take as long as so many of one slot, which goes by packs of four components.
constexpr double links_for(int lanes) {
  return lanes > 4 ? 3.0 : 2.0;
}

int axes_of(const simd::RunLink& link) {
  int axes = 0;
  for (int a = 0; a < 3; ++a) {
    if (link.there[a] != 0.0f || link.back[a] != 0.0f) axes |= 1 << a;
  }
  return axes;
}

std::string_view bytes_of(const simd::RunLink* links, std::size_t count) {
  static_assert(sizeof(simd::RunLink) == 32);
  return {reinterpret_cast<const char*>(links), count * sizeof(simd::RunLink)};
}

}  // namespace

void RunPacker::add(std::vector<simd::RunLink>& links) {
  to_.slot_links += static_cast<double>(links.size());
  std::erase_if(links, [](const simd::RunLink& link) { return axes_of(link) == 0 && link.stiffness == 0.0f; });
  std::ranges::sort(links, {}, [](const simd::RunLink& link) { return std::tuple(axes_of(link), link.shift); });
  const std::int32_t stencil = stencil_of(links);
  if (to_.runs.empty() || to_.runs.back().stencil != stencil) {
    end_run();
    to_.runs.push_back({slots_, stencil});
  }
  if (slots_ % lanes_ == 0) to_.first_run.push_back(static_cast<std::int32_t>(to_.runs.size()) - 1);
  ++slots_;
}

std::int32_t RunPacker::stencil_of(const std::vector<simd::RunLink>& links) {
  const std::string_view bytes = bytes_of(links.data(), links.size());
  const auto is = [&](std::int32_t stencil) {
    const std::int32_t* first = to_.stencils[stencil].first;
    return bytes == bytes_of(to_.links.data() + first[0], static_cast<std::size_t>(first[8] - first[0]));
  };
  if (!to_.runs.empty() && is(to_.runs.back().stencil)) return to_.runs.back().stencil;
  const auto next = static_cast<std::int32_t>(to_.stencils.size());
  const auto [known, is_new] = stencils_.try_emplace(std::hash<std::string_view>()(bytes), next);
  if (!is_new && is(known->second)) return known->second;
  simd::Stencil stencil;
  auto link = links.begin();
  for (int axes = 0; axes < 9; ++axes) {
    link = std::find_if(link, links.end(), [&](const simd::RunLink& l) { return axes_of(l) >= axes; });
    stencil.first[axes] = static_cast<std::int32_t>(to_.links.size()) + static_cast<std::int32_t>(link - links.begin());
  }
  to_.links.insert(to_.links.end(), links.begin(), links.end());
  to_.stencils.push_back(stencil);
  return next;
}

void RunPacker::end_run() {
  if (to_.runs.empty()) return;
  const std::int32_t length = slots_ - to_.runs.back().first, *first = to_.stencils[to_.runs.back().stencil].first;
  to_.run_links += static_cast<double>(first[8] - first[0]) * ((length + lanes_ - 1) / lanes_);
}

bool RunPacker::worthwhile() const {
  return links_for(lanes_) * to_.run_links < to_.slot_links;
}

void RunPacker::finish() {
  end_run();
  to_.runs.push_back({slots_, 0});
  to_.first_run.push_back(static_cast<std::int32_t>(to_.runs.size()) - 1);
  // An odd number of lines of the cache: components of a slot must not all fall into the same places of a cache.
  to_.stride = ((slots_ + lanes_ + 15) / 16 | 1) * 16;
}

simd::Runs PackedRuns::job(float* components) const {
  if (empty()) return {};
  return {.runs = runs.data(),
          .first_run = first_run.data(),
          .stencils = stencils.data(),
          .links = links.data(),
          .components = components,
          .stride = stride};
}

}  // namespace phymul::cpu

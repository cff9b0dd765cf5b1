// SPDX-License-Identifier: MIT
#include "plain_ticks.h"

#include <algorithm>

namespace phymul::bench {
namespace {

/// Of a tick: about as many as a body of 5,000 particles has clusters in four steps. A thread takes the next one when
/// it is through with one, so that the tick does not wait for a thread that comes late.
constexpr std::uint32_t pieces = 40;

float multiply_adds(long rounds) {
  float sum[16]{};
  for (long r = 0; r < rounds; ++r) {
    for (float& s : sum) s = s * 0.5f + 1.0f;
  }
  float all = 0.0f;
  for (const float s : sum) all += s;
  return all;
}

}  // namespace

PlainTicks::PlainTicks(int threads) {
  for (int k = 1; k < threads; ++k) others_.emplace_back([this] { serve(); });
}

PlainTicks::~PlainTicks() {
  ending_.store(true);
  tick_.fetch_add(1);
  tick_.notify_all();
}

void PlainTicks::take_pieces(std::uint32_t tick) {
  std::uint64_t claimed = claimed_.load();
  while (claimed >> 32 == tick && static_cast<std::uint32_t>(claimed) < pieces) {
    if (!claimed_.compare_exchange_weak(claimed, claimed + 1)) continue;
    volatile float result = multiply_adds(rounds_);
    static_cast<void>(result);
    done_.fetch_add(1);
    claimed = claimed_.load();
  }
}

void PlainTicks::serve() {
  std::uint32_t seen = 0;
  for (;;) {
    tick_.wait(seen);
    seen = tick_.load();
    if (ending_.load()) return;
    take_pieces(seen);
  }
}

void PlainTicks::work() {
  const std::uint32_t tick = tick_.load() + 1;
  done_.store(0);
  claimed_.store(std::uint64_t{tick} << 32);
  tick_.store(tick);
  tick_.notify_all();
  take_pieces(tick);
  while (done_.load() < static_cast<int>(pieces)) std::this_thread::yield();
}

void PlainTicks::scale(double found, double wanted) {
  rounds_ = std::max(1L, static_cast<long>(static_cast<double>(rounds_) * wanted / found));
}

}  // namespace phymul::bench

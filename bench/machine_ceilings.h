// SPDX-License-Identifier: MIT
//
// What one core of this machine can do at most, measured: the ceilings that rates are shares of.
#pragma once

namespace phymul::bench {

/// Multiply-adds of whole vectors a second, of the widest vectors this processor has among AVX-512, AVX2 and 4 floats.
/// Needs about `seconds` of processor time, as the other does.
double vector_multiply_adds(double seconds);

/// The same of `threads` threads at once over that of one, by the wall clock: the median of `pairs` measurements, each
/// of twice so many seconds. Threads of ours cannot gain more than this; a virtual processor that shares its core with
/// others gives less than its number says, and may do so for seconds at a time.
double threads_gain(int threads, int pairs = 7, double seconds = 0.05);

/// Bytes a second read one after another from an array of that many.
double read_bandwidth(double bytes, double seconds);

}  // namespace phymul::bench

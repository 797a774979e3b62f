// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Closest cells of many samples at once. A look-up waits for memory; asking for a whole batch
// before the first answer is needed hides most of the wait.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "evidence.hpp"

namespace rops {

constexpr std::size_t kBatch = 32;

struct Batch {
  std::size_t size = 0;
  Float3 points[kBatch];       // moved into the frame of `to`
  std::int32_t cells[kBatch];  // surface cells of `to`, -1 where none is near
};

// Samples first .. first + kBatch (not beyond last) of `from`, moved by T into the frame of `to`.
inline void look_up(const Evidence& from, const Field& to, const Rigid& T, std::size_t first,
                    std::size_t last, Batch& out) {
  std::int32_t at[kBatch];
  out.size = std::min(kBatch, last - first);
  for (std::size_t k = 0; k < out.size; ++k) {
    out.points[k] = T.apply(from.samples[first + k].point);
    at[k] = to.locate(out.points[k]);
    if (at[k] >= 0) __builtin_prefetch(&to.nearest[at[k]]);
  }
  for (std::size_t k = 0; k < out.size; ++k) {
    out.cells[k] = at[k] < 0 ? -1 : to.nearest[at[k]];
    if (out.cells[k] >= 0) __builtin_prefetch(&to.surface[out.cells[k]]);
  }
}

}  // namespace rops

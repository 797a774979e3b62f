// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace rops {

// Call body(i) for i < count on `threads` threads (0: all cores). Each i must write only its own
// result, which then does not depend on the number of threads.
template <class Body>
void parallel(std::size_t count, int threads, Body&& body) {
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t hands = std::max<std::size_t>(
      1, std::min<std::size_t>(threads > 0 ? threads : cores, count));
  std::vector<std::thread> pool;
  for (std::size_t h = 1; h < hands; ++h)
    pool.emplace_back([&body, h, count, hands] {
      for (std::size_t i = h; i < count; i += hands) body(i);
    });
  for (std::size_t i = 0; i < count; i += hands) body(i);
  for (std::thread& t : pool) t.join();
}

}  // namespace rops

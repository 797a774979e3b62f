// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// The kernels' only threads: started for one loop and joined at its end.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace rops {

// Call body(i) for i < count on `threads` threads (0: all cores), where every thread makes a body
// of its own by make(), with the scratch that it needs. Indices are dealt `chunk` at a time, in
// order. Each i must write only its own result, which then does not depend on who computed it.
template <class Make>
void parallel_with(std::size_t count, std::size_t chunk, int threads, Make&& make) {
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t chunks = (count + chunk - 1) / chunk;
  const std::size_t hands = std::min<std::size_t>(threads > 0 ? threads : cores, chunks);
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    auto body = make();
    for (std::size_t begin; (begin = next.fetch_add(chunk)) < count;)
      for (std::size_t i = begin; i < std::min(begin + chunk, count); ++i) body(i);
  };
  std::vector<std::thread> others;
  for (std::size_t h = 1; h < hands; ++h) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

// The same without scratch.
template <class Body>
void parallel(std::size_t count, int threads, Body&& body) {
  parallel_with(count, 1, threads, [&body] { return [&body](std::size_t i) { body(i); }; });
}

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Numbers for the cubic cells that points fall into.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace rops {

// Cubic cells numbered as they are met. A key has 21 bits an axis.
class CellNumbers {
 public:
  CellNumbers(const double* points, std::size_t n, double side) {
    std::array<double, 3> high{};
    for (int k = 0; k < 3; ++k) low_[k] = high[k] = n ? points[k] : 0.0;
    for (std::size_t i = 1; i < n; ++i)
      for (int k = 0; k < 3; ++k) {
        low_[k] = std::min(low_[k], points[3 * i + k]);
        high[k] = std::max(high[k], points[3 * i + k]);
      }
    for (int k = 0; k < 3; ++k) side = std::max(side, (high[k] - low_[k]) / kMost);
    inverse_ = side > 0 ? 1.0 / side : 0.0;
    grow(1 << 12);
  }

  std::size_t count() const { return keys_.size(); }

  std::uint64_t key_of(const double* p) const {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key = key << 21 | static_cast<std::uint64_t>((p[k] - low_[k]) * inverse_);
    return key;
  }
  // A number at random for each group of 4 x 4 x 4 cells.
  static std::uint64_t mixed_group(std::uint64_t key) {
    key &= ~(3ull << 42 | 3ull << 21 | 3ull);
    key = (key ^ (key >> 29)) * 0x9E3779B97F4A7C15ull;
    return key ^ (key >> 32);
  }

  // The number of the cell of a key.
  std::size_t of(std::uint64_t key) {
    if (key == last_key_ && !keys_.empty()) return last_;
    last_key_ = key;
    if (4 * keys_.size() >= table_.size()) grow(4 * table_.size());
    std::size_t slot = slot_of(key);
    for (; table_[slot].number >= 0; slot = (slot + 1) & mask_)
      if (table_[slot].key == key) return last_ = table_[slot].number;
    table_[slot] = {key, static_cast<std::int32_t>(keys_.size())};
    keys_.push_back(key);
    return last_ = keys_.size() - 1;
  }

 private:
  static constexpr double kMost = 2097000.0;

  struct Slot {
    std::uint64_t key;
    std::int32_t number;
  };

  // Cells of one group lie together, as do the points of a scan that fill them.
  std::size_t slot_of(std::uint64_t key) const {
    const std::uint64_t inside = (key >> 40 & 12) | (key >> 21 & 3) | (key & 3) << 4;
    return (static_cast<std::size_t>(mixed_group(key) >> 20) << 6 | inside) & mask_;
  }
  void grow(std::size_t slots) {
    mask_ = slots - 1;
    table_.assign(slots, {0, -1});
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      std::size_t slot = slot_of(keys_[c]);
      while (table_[slot].number >= 0) slot = (slot + 1) & mask_;
      table_[slot] = {keys_[c], static_cast<std::int32_t>(c)};
    }
  }

  std::array<double, 3> low_{};
  double inverse_ = 0;
  std::vector<std::uint64_t> keys_;
  std::vector<Slot> table_;
  std::size_t mask_ = 0, last_ = 0;
  std::uint64_t last_key_ = 0;
};

}  // namespace rops

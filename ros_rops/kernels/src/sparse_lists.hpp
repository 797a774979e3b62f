// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Lists of items by cell of an endless grid: memory follows the items, not the extent.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace rops {

// Number of the cell, of unit length, that `x` lies in. Where it does not fit a key it wraps
// around: cells far apart then share a list, which costs time but no exactness.
inline std::int64_t cell_index(double x) {
  constexpr double kFar = 1e15;
  return static_cast<std::int64_t>(std::floor(x < -kFar ? -kFar : x > kFar ? kFar : x));
}
inline std::uint64_t cell_key(std::int64_t x, std::int64_t y) {
  return static_cast<std::uint64_t>(x) << 32 | (static_cast<std::uint64_t>(y) & 0xffffffffu);
}
inline std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::uint64_t kMask = (1u << 21) - 1;
  return (static_cast<std::uint64_t>(x) & kMask) << 42 |
         (static_cast<std::uint64_t>(y) & kMask) << 21 | (static_cast<std::uint64_t>(z) & kMask);
}

// Slots 0, 1, ... for keys, in the order in which these first came.
class KeySlots {
 public:
  static constexpr std::uint32_t kNone = ~0u;

  std::uint32_t find(std::uint64_t key) const {
    for (std::size_t at = home(key);; at = (at + 1) & mask_) {
      if (slots_[at] == kNone || keys_[at] == key) return slots_[at];
    }
  }
  std::uint32_t insert(std::uint64_t key) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    std::size_t at = home(key);
    while (slots_[at] != kNone && keys_[at] != key) at = (at + 1) & mask_;
    if (slots_[at] == kNone) {
      keys_[at] = key;
      slots_[at] = static_cast<std::uint32_t>(count_++);
    }
    return slots_[at];
  }
  std::size_t size() const { return count_; }

 private:
  std::size_t home(std::uint64_t key) const {
    std::uint64_t h = key * 0x9e3779b97f4a7c15ull;
    return (h ^ (h >> 29)) & mask_;
  }
  void grow() {
    std::vector<std::uint64_t> keys(2 * keys_.size());
    std::vector<std::uint32_t> slots(2 * slots_.size(), kNone);
    keys.swap(keys_), slots.swap(slots_);
    mask_ = slots_.size() - 1;
    for (std::size_t k = 0; k < slots.size(); ++k) {
      if (slots[k] == kNone) continue;
      std::size_t at = home(keys[k]);
      while (slots_[at] != kNone) at = (at + 1) & mask_;
      keys_[at] = keys[k], slots_[at] = slots[k];
    }
  }

  std::vector<std::uint64_t> keys_ = std::vector<std::uint64_t>(64);
  std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(64, kNone);
  std::size_t mask_ = 63, count_ = 0;
};

class SparseLists {
 public:
  SparseLists() = default;
  // cells_of(item, emit) calls emit(key) for each cell that the item belongs to; items stand in
  // their order in every list.
  template <class CellsOf>
  SparseLists(std::size_t items, CellsOf&& cells_of) {
    std::vector<std::uint32_t> counts;
    for (std::size_t i = 0; i < items; ++i)
      cells_of(i, [&](std::uint64_t key) {
        const std::uint32_t slot = slots_.insert(key);
        if (slot == counts.size()) counts.push_back(0);
        ++counts[slot];
      });
    first_.assign(counts.size() + 1, 0);
    for (std::size_t s = 0; s < counts.size(); ++s) first_[s + 1] = first_[s] + counts[s];
    items_.resize(first_.back());
    counts.assign(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < items; ++i)
      cells_of(i, [&](std::uint64_t key) {
        items_[counts[slots_.find(key)]++] = static_cast<std::uint32_t>(i);
      });
  }
  std::pair<const std::uint32_t*, const std::uint32_t*> at(std::uint64_t key) const {
    const std::uint32_t slot = slots_.find(key);
    if (slot == KeySlots::kNone) return {nullptr, nullptr};
    return {items_.data() + first_[slot], items_.data() + first_[slot + 1]};
  }

 private:
  KeySlots slots_;
  std::vector<std::uint32_t> first_{0}, items_;
};

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
//
// A view's points in a hash of cells, for nearest neighbours within a few mesh resolutions:
// scattered points cost memory by their number, not by the box around them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace rops::fine {

using Vec3 = std::array<double, 3>;

inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vec3 minus(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

class CellHash {
 public:
  using Cell = std::array<std::int64_t, 3>;

  // The points are sorted by cell; order[k] is the original index of the k-th sorted point.
  CellHash(const double* xyz, std::size_t n, double cell) : cell_(cell), points_(n), order_(n) {
    for (int a = 0; a < 3; ++a) origin_[a] = end_[a] = n ? xyz[a] : 0.0;
    for (std::size_t i = 1; i < n; ++i)
      for (int a = 0; a < 3; ++a) {
        origin_[a] = std::min(origin_[a], xyz[3 * i + a]);
        end_[a] = std::max(end_[a], xyz[3 * i + a]);
      }
    std::vector<std::pair<Key, std::int32_t>> keyed(n);
    for (std::size_t i = 0; i < n; ++i)
      keyed[i] = {key(cell_of({xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]})),
                  static_cast<std::int32_t>(i)};
    std::sort(keyed.begin(), keyed.end());
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = order_[k] = keyed[k].second;
      points_[k] = {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]};
      if (k == 0 || keyed[k].first != cells_.back()) {
        cells_.push_back(keyed[k].first);
        starts_.push_back(static_cast<std::int32_t>(k));
      }
    }
    starts_.push_back(static_cast<std::int32_t>(n));
    build_table();
  }

  std::size_t size() const { return points_.size(); }
  std::size_t cell_count() const { return cells_.size(); }
  double cell_size() const { return cell_; }
  const Vec3& point(std::size_t k) const { return points_[k]; }
  std::int32_t original(std::size_t k) const { return order_[k]; }
  std::int32_t cell_begin(std::size_t c) const { return starts_[c]; }

  // Sorted indices [begin, end) of the points of one cell.
  std::pair<std::int32_t, std::int32_t> range(const Cell& cell) const {
    for (int a = 0; a < 3; ++a)
      if (cell[a] < 0 || cell[a] > kMost) return {0, 0};
    const Key wanted = key(cell);
    for (std::size_t slot = mix(wanted) & mask_;; slot = (slot + 1) & mask_) {
      const std::int32_t c = table_[slot];
      if (c < 0) return {0, 0};
      if (cells_[c] == wanted) return {starts_[c], starts_[c + 1]};
    }
  }

  Cell cell_of(const Vec3& p) const {
    Cell cell;
    for (int a = 0; a < 3; ++a) {
      // Beyond the key's range nothing is found; clamping keeps the conversion defined, and
      // adding 1 makes it round down.
      const double scaled = (p[a] - origin_[a]) / cell_ + 1.0;
      cell[a] = static_cast<std::int64_t>(std::min(std::max(scaled, 0.0), kMost + 2.0)) - 1;
    }
    return cell;
  }

  // The nearest point within `radius` of `p` (sorted index, squared distance), or -1.
  std::pair<std::int32_t, double> nearest(const Vec3& p, double radius) const {
    std::int32_t best = -1;
    double least = radius * radius;
    for (int a = 0; a < 3; ++a)
      if (!(p[a] >= origin_[a] - radius && p[a] <= end_[a] + radius)) return {best, least};
    const Cell home = cell_of(p);
    scan(home, p, &best, &least);
    const double reach = std::sqrt(least);
    const Cell low = cell_of({p[0] - reach, p[1] - reach, p[2] - reach});
    const Cell high = cell_of({p[0] + reach, p[1] + reach, p[2] + reach});
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const Cell cell = {x, y, z};
          if (cell != home && gap(cell, p) < least) scan(cell, p, &best, &least);
        }
    return {best, least};
  }

 private:
  // x and y, z; 32 bits each: outliers 1e9 cells away do not matter.
  using Key = std::pair<std::uint64_t, std::uint32_t>;
  static constexpr std::int64_t kMost = 0xFFFFFFFEll;

  static Key key(const Cell& c) {
    return {(static_cast<std::uint64_t>(c[0]) << 32) | static_cast<std::uint64_t>(c[1]),
            static_cast<std::uint32_t>(c[2])};
  }
  static std::size_t mix(const Key& key) {
    std::uint64_t k = key.first ^ (key.second * 0xC2B2AE3D27D4EB4Full);
    k = (k ^ (k >> 32)) * 0x9E3779B97F4A7C15ull;
    return static_cast<std::size_t>(k >> 29);
  }
  double gap(const Cell& cell, const Vec3& p) const {
    double sum = 0.0;
    for (int a = 0; a < 3; ++a) {
      const double from = origin_[a] + cell[a] * cell_;
      const double out = std::max(0.0, std::max(from - p[a], p[a] - from - cell_));
      sum += out * out;
    }
    return sum;
  }
  void scan(const Cell& cell, const Vec3& p, std::int32_t* best, double* least) const {
    const auto [begin, end] = range(cell);
    for (std::int32_t k = begin; k < end; ++k) {
      const Vec3 d = minus(points_[k], p);
      const double squared = dot(d, d);
      if (squared < *least) {
        *least = squared;
        *best = k;
      }
    }
  }
  void build_table() {
    std::size_t slots = 16;
    while (slots < 2 * cells_.size()) slots *= 2;
    mask_ = slots - 1;
    table_.assign(slots, -1);
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      std::size_t slot = mix(cells_[c]) & mask_;
      while (table_[slot] >= 0) slot = (slot + 1) & mask_;
      table_[slot] = static_cast<std::int32_t>(c);
    }
  }

  double cell_;
  Vec3 origin_, end_;
  std::vector<Vec3> points_;
  std::vector<std::int32_t> order_;
  std::vector<Key> cells_;
  std::vector<std::int32_t> starts_;
  std::vector<std::int32_t> table_;
  std::size_t mask_ = 0;
};

}  // namespace rops::fine

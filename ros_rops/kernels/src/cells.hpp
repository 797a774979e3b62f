// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// A uniform grid over points: sorted by cell, so that what a ball can hold is a few runs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace rops {

class Cells {
 public:
  // `chosen`: indices of the points to sort; `size`: wished cell edge (enlarged where the
  // extent would need too many cells).
  Cells(const double* points, const std::vector<std::int32_t>& chosen, double size)
      : order(chosen) {
    std::array<double, 3> high;
    low_.fill(std::numeric_limits<double>::max());
    high.fill(std::numeric_limits<double>::lowest());
    for (const std::int32_t i : chosen)
      for (int k = 0; k < 3; ++k) {
        low_[k] = std::min(low_[k], points[3 * i + k]);
        high[k] = std::max(high[k], points[3 * i + k]);
      }
    for (int k = 0; k < 3; ++k) size = std::max(size, (high[k] - low_[k]) / kMostCells);
    inverse_ = chosen.empty() || !(size > 0) ? 0.0 : 1 / size;
    size_ = size;
    std::size_t total = 1;
    for (int k = 0; k < 3; ++k) {
      counts_[k] = chosen.empty() ? 1 : index(high[k], k, std::numeric_limits<int>::max()) + 1;
      total *= counts_[k];
    }
    sort(points, total);
  }

  // Points in cell order: order[i] is the index of the i-th.
  std::vector<std::int32_t> order;

  // Call visit(begin, end) for every run of positions in `order` that may lie within `radius`.
  template <typename Visit>
  void for_each_run(const double* p, double radius, Visit visit) const {
    const double slack = radius * (1 + 1e-9);
    const int y0 = cell(p[1] - slack, 1), y1 = cell(p[1] + slack, 1);
    const int z0 = cell(p[2] - slack, 2), z1 = cell(p[2] + slack, 2);
    for (int z = z0; z <= z1; ++z)
      for (int y = y0; y <= y1; ++y) {
        const double dy = gap(p[1], y, 1), dz = gap(p[2], z, 2);
        const double left = slack * slack - dy * dy - dz * dz;
        if (left < 0) continue;
        const double half = std::sqrt(left);
        const std::size_t row = (static_cast<std::size_t>(z) * counts_[1] + y) * counts_[0];
        const std::size_t begin = start_[row + cell(p[0] - half, 0)];
        const std::size_t end = start_[row + cell(p[0] + half, 0) + 1];
        if (begin < end) visit(begin, end);
      }
  }

 private:
  static constexpr int kMostCells = 128;  // along an axis: two million in all

  int index(double value, int axis, int most) const {
    const double position = (value - low_[axis]) * inverse_;
    return position <= 0 ? 0 : static_cast<int>(std::min<double>(position, most));
  }
  int cell(double value, int axis) const { return index(value, axis, counts_[axis] - 1); }

  // Distance from `value` to the cells of row `at` along `axis`; rim cells are not shortened.
  double gap(double value, int at, int axis) const {
    const double begin = low_[axis] + at * size_;
    const double slack = 1e-9 * size_;
    return std::max({begin - slack - value, value - begin - size_ - slack, 0.0});
  }

  void sort(const double* points, std::size_t total) {
    std::vector<std::size_t> where(order.size());
    start_.assign(total + 1, 0);
    for (std::size_t i = 0; i < order.size(); ++i) {
      const double* p = points + 3 * static_cast<std::size_t>(order[i]);
      where[i] = (static_cast<std::size_t>(cell(p[2], 2)) * counts_[1] + cell(p[1], 1)) *
                     counts_[0] + cell(p[0], 0);
      ++start_[where[i] + 1];
    }
    for (std::size_t c = 0; c < total; ++c) start_[c + 1] += start_[c];
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    std::vector<std::int32_t> sorted(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) sorted[next[where[i]]++] = order[i];
    order.swap(sorted);
  }

  std::array<double, 3> low_;
  std::array<int, 3> counts_;
  double size_, inverse_;
  std::vector<std::size_t> start_;
};

}  // namespace rops

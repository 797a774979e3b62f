// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Clouds as sensors deliver them: holes dropped, neighbours averaged.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "parallel.hpp"

namespace py = pybind11;

namespace {
template <class T>
using Array = py::array_t<T, py::array::c_style>;

// Which points are measured, and their numbers without gaps; -1 for holes.
template <class T>
py::tuple measured(const Array<T>& points, double limit) {
  const py::ssize_t n = points.shape(0);
  Array<std::int32_t> numbers(n);
  const T* p = points.data();
  std::int32_t* number = numbers.mutable_data();
  std::int32_t count = 0;
  const T most = static_cast<T>(limit);
  {
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < n; ++i, p += 3) {
      // NaN compares false.
      const bool good = (std::abs(p[0]) <= most) & (std::abs(p[1]) <= most) &
                        (std::abs(p[2]) <= most);
      number[i] = good ? count : -1;
      count += good;
    }
  }
  Array<double> kept({static_cast<py::ssize_t>(count), py::ssize_t{3}});
  double* out = kept.mutable_data();
  p = points.data();
  {
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < n; ++i)
      if (number[i] >= 0)
        for (int k = 0; k < 3; ++k) out[3 * static_cast<py::ssize_t>(number[i]) + k] = p[3 * i + k];
  }
  return py::make_tuple(kept, numbers);
}

// How many points are known in z alone, and how many lie at the origin.
template <class T>
py::tuple count_holes(const Array<T>& points) {
  const py::ssize_t n = points.shape(0);
  const T* p = points.data();
  std::int64_t halves = 0, zeros = 0;
  {
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < n; ++i, p += 3) {
      const T sum = p[0] + p[1];
      halves += !(std::abs(sum) <= std::numeric_limits<T>::max()) & (p[2] == p[2]);
      zeros += (p[0] == 0) & (p[1] == 0) & (p[2] == 0);
    }
  }
  return py::make_tuple(halves, zeros);
}

struct Sum {
  double x = 0, y = 0, z = 0;
  std::int64_t red = 0, green = 0, blue = 0, count = 0;

  void add(const double* p, const std::uint8_t* c) {
    x += p[0];
    y += p[1];
    z += p[2];
    if (c) {
      red += c[0];
      green += c[1];
      blue += c[2];
    }
    ++count;
  }
  void write(double* p, std::uint8_t* c) const {
    const double n = static_cast<double>(count);
    p[0] = x / n;
    p[1] = y / n;
    p[2] = z / n;
    if (!c) return;
    // To the nearest, halves to even, as NumPy rounds.
    c[0] = static_cast<std::uint8_t>(std::nearbyint(static_cast<double>(red) / n));
    c[1] = static_cast<std::uint8_t>(std::nearbyint(static_cast<double>(green) / n));
    c[2] = static_cast<std::uint8_t>(std::nearbyint(static_cast<double>(blue) / n));
  }
};

const std::uint8_t* colors_of(const Array<std::uint8_t>& colors) {
  return colors.shape(0) ? colors.data() : nullptr;
}

// Means of those sums that have points, their numbers, and where they stand.
py::tuple means_of(const std::vector<Sum>& sums, bool painted) {
  Array<std::int32_t> numbers(static_cast<py::ssize_t>(sums.size()));
  std::int32_t count = 0;
  for (std::size_t b = 0; b < sums.size(); ++b)
    numbers.mutable_data()[b] = sums[b].count ? count++ : -1;
  const auto rows = static_cast<py::ssize_t>(count);
  Array<double> points({rows, py::ssize_t{3}});
  Array<std::uint8_t> colors({painted ? rows : 0, py::ssize_t{3}});
  double* p = points.mutable_data();
  std::uint8_t* c = painted ? colors.mutable_data() : nullptr;
  for (const Sum& sum : sums) {
    if (!sum.count) continue;
    sum.write(p, c);
    p += 3;
    if (c) c += 3;
  }
  return py::make_tuple(points, colors, numbers);
}

// One row of blocks: of each, the points not deeper than its nearest by more than `slack`.
struct BlockRow {
  const std::int32_t* grid;
  const double* points;
  const std::uint8_t* colors;
  std::size_t height, width, side;
  std::array<double, 3> axis;
  double slack;

  double depth(const double* p) const { return p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2]; }

  template <class Body>
  void each(std::size_t row, Body&& body) const {
    const std::size_t end = std::min((row + 1) * side, height);
    for (std::size_t i = row * side; i < end; ++i)
      for (std::size_t j = 0, block = 0, left = side; j < width; ++j) {
        const std::int32_t at = grid[i * width + j];
        if (at >= 0) body(block, static_cast<std::size_t>(at));
        if (--left == 0) {
          left = side;
          ++block;
        }
      }
  }
  void operator()(std::size_t row, Sum* sums, std::vector<double>& nearest) const {
    std::fill(nearest.begin(), nearest.end(), std::numeric_limits<double>::infinity());
    each(row, [&](std::size_t b, std::size_t i) {
      nearest[b] = std::min(nearest[b], depth(points + 3 * i));
    });
    each(row, [&](std::size_t b, std::size_t i) {
      if (depth(points + 3 * i) - nearest[b] <= slack)
        sums[b].add(points + 3 * i, colors ? colors + 3 * i : nullptr);
    });
  }
};

py::tuple block_means(const Array<double>& points, const Array<std::int32_t>& grid,
                      const Array<std::uint8_t>& colors, std::array<double, 3> axis,
                      std::size_t side, double slack, int threads) {
  const auto height = static_cast<std::size_t>(grid.shape(0));
  const auto width = static_cast<std::size_t>(grid.shape(1));
  const std::size_t rows = (height + side - 1) / side, columns = (width + side - 1) / side;
  const BlockRow body{grid.data(), points.data(), colors_of(colors), height, width,
                      side,        axis,          slack};
  std::vector<Sum> sums(rows * columns);
  {
    py::gil_scoped_release release;
    rops::parallel_with(rows, 4, threads, [&] {
      return [&, nearest = std::vector<double>(columns)](std::size_t row) mutable {
        body(row, sums.data() + row * columns, nearest);
      };
    });
  }
  return means_of(sums, body.colors != nullptr);
}

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

std::size_t count_cells(const Array<double>& points, double side) {
  const auto n = static_cast<std::size_t>(points.shape(0));
  const double* p = points.data();
  py::gil_scoped_release release;
  CellNumbers cells(p, n, side);
  for (std::size_t i = 0; i < n; ++i) cells.of(cells.key_of(p + 3 * i));
  return cells.count();
}

// All points of one group of 4 x 4 x 4 cells in `share`, the groups taken at random.
Array<double> some_groups(const Array<double>& points, double side, std::uint64_t share) {
  const auto n = static_cast<std::size_t>(points.shape(0));
  const double* p = points.data();
  std::vector<double> chosen;
  {
    py::gil_scoped_release release;
    const CellNumbers cells(p, n, side);
    for (std::size_t i = 0; i < n; ++i, p += 3)
      if (CellNumbers::mixed_group(cells.key_of(p)) % share == 0)
        chosen.insert(chosen.end(), p, p + 3);
  }
  Array<double> result({static_cast<py::ssize_t>(chosen.size() / 3), py::ssize_t{3}});
  std::copy(chosen.begin(), chosen.end(), result.mutable_data());
  return result;
}

py::tuple cell_means(const Array<double>& points, const Array<std::uint8_t>& colors,
                     double side) {
  const auto n = static_cast<std::size_t>(points.shape(0));
  const double* p = points.data();
  const std::uint8_t* c = colors_of(colors);
  std::vector<Sum> sums;
  {
    py::gil_scoped_release release;
    CellNumbers cells(p, n, side);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t cell = cells.of(cells.key_of(p + 3 * i));
      if (cell == sums.size()) sums.emplace_back();
      sums[cell].add(p + 3 * i, c ? c + 3 * i : nullptr);
    }
  }
  const py::tuple means = means_of(sums, c != nullptr);
  return py::make_tuple(means[0], means[1]);
}
}  // namespace

namespace rops {
void bind_points(py::module_& m) {
  m.def("measured_single", &measured<float>);
  m.def("measured_double", &measured<double>);
  m.def("count_holes_single", &count_holes<float>);
  m.def("count_holes_double", &count_holes<double>);
  m.def("block_means", &block_means);
  m.def("count_cells", &count_cells);
  m.def("some_groups", &some_groups);
  m.def("cell_means", &cell_means);
}
}  // namespace rops

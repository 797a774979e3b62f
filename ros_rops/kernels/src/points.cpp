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
#include <cstring>
#include <limits>
#include <vector>

#include "cell_numbers.hpp"
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

// How many points are known in z alone, and how many lie at the origin. By the bits of numbers
// (`Bits`, as wide as T), which takes a third of the time of comparing them.
template <class T, class Bits>
py::tuple count_holes(const Array<T>& points) {
  constexpr Bits infinity = (((Bits{1} << (sizeof(T) == 4 ? 8 : 11)) - 1))
                            << (std::numeric_limits<T>::digits - 1);
  constexpr Bits size = ~(Bits{1} << (8 * sizeof(Bits) - 1));
  const auto n = static_cast<std::size_t>(points.shape(0));
  const T* p = points.data();
  std::size_t halves = 0, zeros = 0;
  {
    py::gil_scoped_release release;
    for (std::size_t begin = 0; begin < n; begin += 1024) {
      Bits bits[3 * 1024], half = 0, zero = 0;
      const std::size_t count = std::min<std::size_t>(1024, n - begin);
      std::memcpy(bits, p + 3 * begin, 3 * count * sizeof(T));
      for (std::size_t i = 0; i < count; ++i) {
        const Bits x = bits[3 * i] & size, y = bits[3 * i + 1] & size, z = bits[3 * i + 2] & size;
        half += ((x >= infinity) | (y >= infinity)) & (z <= infinity);
        zero += (x | y | z) == 0;
      }
      halves += half;
      zeros += zero;
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

std::size_t count_cells(const Array<double>& points, double side) {
  const auto n = static_cast<std::size_t>(points.shape(0));
  const double* p = points.data();
  py::gil_scoped_release release;
  rops::CellNumbers cells(p, n, side);
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
    const rops::CellNumbers cells(p, n, side);
    for (std::size_t i = 0; i < n; ++i, p += 3)
      if (rops::CellNumbers::mixed_group(cells.key_of(p)) % share == 0)
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
    rops::CellNumbers cells(p, n, side);
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
  m.def("count_holes_single", &count_holes<float, std::uint32_t>);
  m.def("count_holes_double", &count_holes<double, std::uint64_t>);
  m.def("block_means", &block_means);
  m.def("count_cells", &count_cells);
  m.def("some_groups", &some_groups);
  m.def("cell_means", &cell_means);
}
}  // namespace rops

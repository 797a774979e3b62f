// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Nearest descriptors (III-B, eq. 5) in whole numbers: exact, so that neither the order of sums
// nor the number of threads can change a match.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "lanes.hpp"
#include "parallel.hpp"

namespace py = pybind11;

namespace rops {
namespace {

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

// Norms of at most this keep every sum of products within 32 bits.
constexpr double kLongest = 30000.0;
constexpr std::size_t kLane = 16;

// Descriptors in whole numbers, rows padded with zeros.
struct Whole {
  std::size_t count, stride;
  std::vector<std::int16_t> rows;
  std::vector<std::int32_t> norms;  // squared

  Whole(const Floats& from, double scale)
      : count(from.shape(0)),
        stride((from.shape(1) + kLane - 1) / kLane * kLane),
        rows(count * stride, 0),
        norms(count, 0) {
    const std::size_t length = from.shape(1);
    const float* in = from.data();
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t d = 0; d < length; ++d) {
        const auto v = static_cast<std::int16_t>(std::lround(in[i * length + d] * scale));
        rows[i * stride + d] = v;
        norms[i] += static_cast<std::int32_t>(v) * v;
      }
  }
};

double longest(const Floats& from) {
  double most = 0;
  for (py::ssize_t i = 0; i < from.shape(0); ++i) {
    double sum = 0;
    for (py::ssize_t d = 0; d < from.shape(1); ++d) {
      const double v = from.data()[i * from.shape(1) + d];
      sum += v * v;
    }
    most = std::max(most, sum);
  }
  return std::sqrt(most);
}

// Products of one row with all rows of `b`.
ROPS_CLONES void products(const std::int16_t* a, const Whole& b, std::int32_t* out) {
  for (std::size_t j = 0; j < b.count; ++j) {
    const std::int16_t* row = b.rows.data() + j * b.stride;
    std::int32_t sum = 0;
    for (std::size_t d = 0; d < b.stride; ++d) sum += static_cast<std::int32_t>(a[d]) * row[d];
    out[j] = sum;
  }
}

// The k nearest rows of `b` for row i of `a`, ties to the lower index.
void nearest(const Whole& a, std::size_t i, const Whole& b, std::size_t k, std::int32_t* index,
             std::int64_t* distance) {
  static thread_local std::vector<std::int32_t> dots;
  dots.resize(b.count);
  products(a.rows.data() + i * a.stride, b, dots.data());
  std::fill(distance, distance + k, std::numeric_limits<std::int64_t>::max());
  for (std::size_t j = 0; j < b.count; ++j) {
    const std::int64_t d = static_cast<std::int64_t>(a.norms[i]) + b.norms[j] - 2ll * dots[j];
    if (d >= distance[k - 1]) continue;
    std::size_t at = k - 1;
    for (; at > 0 && distance[at - 1] > d; --at) {
      distance[at] = distance[at - 1];
      index[at] = index[at - 1];
    }
    distance[at] = d;
    index[at] = static_cast<std::int32_t>(j);
  }
}

py::tuple nearest_descriptors(const Floats& a, const Floats& b, std::size_t k, bool both,
                              int threads) {
  const double most = std::max(longest(a), longest(b));
  const double scale = most > 0 ? kLongest / most : 0.0;
  py::list out;
  const auto side = [&](const Floats& from, const Floats& to) {
    const std::size_t few = std::min<std::size_t>(k, to.shape(0));
    const std::vector<py::ssize_t> shape{from.shape(0), static_cast<py::ssize_t>(few)};
    py::array_t<std::int32_t> index(shape);
    py::array_t<float> distance(shape);
    std::int32_t* at = index.mutable_data();
    float* length = distance.mutable_data();
    {
      py::gil_scoped_release release;
      const Whole x(from, scale), y(to, scale);
      parallel(x.count, threads, [&](std::size_t i) {
        std::vector<std::int64_t> squared(few);
        nearest(x, i, y, few, at + i * few, squared.data());
        for (std::size_t r = 0; r < few; ++r)
          length[i * few + r] =
              scale > 0 ? static_cast<float>(std::sqrt(static_cast<double>(squared[r])) / scale) : 0;
      });
    }
    out.append(py::make_tuple(index, distance));
  };
  side(a, b);
  if (both) side(b, a);
  return py::tuple(out);
}

}  // namespace

void bind_matching(py::module_& m) { m.def("_nearest_descriptors", &nearest_descriptors); }

}  // namespace rops

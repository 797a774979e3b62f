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

// Rows of `a` whose products with a row of `b` are taken together, to read `b` less often.
constexpr std::size_t kRows = 4;

// Products of kRows rows with all rows of `b`: out[j * kRows + r].
ROPS_CLONES void products(const std::int16_t* const* a, const Whole& b, std::int32_t* out) {
  const std::int16_t *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
  for (std::size_t j = 0; j < b.count; ++j) {
    const std::int16_t* row = b.rows.data() + j * b.stride;
    std::int32_t s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    for (std::size_t d = 0; d < b.stride; ++d) {
      const std::int32_t v = row[d];
      s0 += a0[d] * v, s1 += a1[d] * v, s2 += a2[d] * v, s3 += a3[d] * v;
    }
    std::int32_t* to = out + j * kRows;
    to[0] = s0, to[1] = s1, to[2] = s2, to[3] = s3;
  }
}

// The k nearest by a column of products; ties to the lower index.
void keep_nearest(const std::int32_t* dots, std::int64_t norm, const Whole& b, std::size_t k,
                  std::int32_t* index, std::int64_t* distance) {
  std::fill(distance, distance + k, std::numeric_limits<std::int64_t>::max());
  for (std::size_t j = 0; j < b.count; ++j) {
    const std::int64_t d = norm + b.norms[j] - 2ll * dots[j * kRows];
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

// The k nearest rows of `b`, and how far they are, for every row of `a`.
void nearest_rows(const Whole& a, const Whole& b, std::size_t k, double scale, int threads,
                  std::int32_t* index, float* length) {
  parallel((a.count + kRows - 1) / kRows, threads, [&](std::size_t block) {
    static thread_local std::vector<std::int32_t> dots;
    dots.resize(b.count * kRows);
    const std::size_t first = block * kRows, last = std::min(first + kRows, a.count);
    const std::int16_t* rows[kRows];
    for (std::size_t r = 0; r < kRows; ++r)
      rows[r] = a.rows.data() + std::min(first + r, last - 1) * a.stride;
    products(rows, b, dots.data());
    std::vector<std::int64_t> squared(k);
    for (std::size_t i = first; i < last; ++i) {
      keep_nearest(dots.data() + (i - first), a.norms[i], b, k, index + i * k, squared.data());
      for (std::size_t r = 0; r < k; ++r)
        length[i * k + r] =
            scale > 0 ? static_cast<float>(std::sqrt(static_cast<double>(squared[r])) / scale) : 0;
    }
  });
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
      nearest_rows(Whole(from, scale), Whole(to, scale), few, scale, threads, at, length);
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

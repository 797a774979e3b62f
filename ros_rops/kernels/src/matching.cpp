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
#include <memory>
#include <mutex>
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

// For each of many rows the k nearest of the other side, and how far they are (squared).
struct Lists {
  std::size_t k;
  std::vector<std::int32_t> index;
  std::vector<std::int64_t> distance;

  Lists(std::size_t rows, std::size_t few)
      : k(few), index(rows * few), distance(rows * few, kNone) {}

  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  std::int64_t farthest(std::size_t row) const { return distance[row * k + k - 1]; }

  // Ties go to the lower index, whatever the order of the calls.
  void offer(std::size_t row, std::int32_t i, std::int64_t d) {
    std::int64_t* far = distance.data() + row * k;
    std::int32_t* who = index.data() + row * k;
    const auto before = [&](std::size_t at) {
      return d < far[at] || (d == far[at] && d != kNone && i < who[at]);
    };
    if (!before(k - 1)) return;
    std::size_t at = k - 1;
    for (; at > 0 && before(at - 1); --at) far[at] = far[at - 1], who[at] = who[at - 1];
    far[at] = d, who[at] = i;
  }

  void write(double scale, std::int32_t* to, float* length) const {
    std::copy(index.begin(), index.end(), to);
    for (std::size_t at = 0; at < distance.size(); ++at)
      length[at] =
          scale > 0 ? static_cast<float>(std::sqrt(static_cast<double>(distance[at])) / scale) : 0;
  }
};

// Offer all rows of `a` and of `b` to each other: every product is taken once, for both sides.
void nearest_rows(const Whole& a, const Whole& b, int threads, Lists& of_a, Lists* of_b) {
  std::vector<std::unique_ptr<Lists>> shares;  // one a thread, of the rows of `b`
  std::mutex guard;
  parallel_with((a.count + kRows - 1) / kRows, 1, threads, [&] {
    Lists* share = nullptr;
    if (of_b) {
      const std::lock_guard<std::mutex> lock(guard);
      shares.push_back(std::make_unique<Lists>(b.count, of_b->k));
      share = shares.back().get();
    }
    return [&, share, dots = std::vector<std::int32_t>(b.count * kRows)](
               std::size_t block) mutable {
      const std::size_t first = block * kRows, last = std::min(first + kRows, a.count);
      const std::int16_t* rows[kRows];
      for (std::size_t r = 0; r < kRows; ++r)
        rows[r] = a.rows.data() + std::min(first + r, last - 1) * a.stride;
      products(rows, b, dots.data());
      for (std::size_t i = first; i < last; ++i) {
        const std::int64_t norm = a.norms[i];
        const auto self = static_cast<std::int32_t>(i);
        const std::int32_t* dot = dots.data() + (i - first);
        for (std::size_t j = 0; j < b.count; ++j) {
          const std::int64_t d = norm + b.norms[j] - 2ll * dot[j * kRows];
          if (d < of_a.farthest(i)) of_a.offer(i, static_cast<std::int32_t>(j), d);
          if (share && d < share->farthest(j)) share->offer(j, self, d);
        }
      }
    };
  });
  if (!of_b) return;
  for (const auto& share : shares)
    for (std::size_t j = 0; j < b.count; ++j)
      for (std::size_t r = 0; r < of_b->k; ++r)
        of_b->offer(j, share->index[j * of_b->k + r], share->distance[j * of_b->k + r]);
}

py::tuple nearest_descriptors(const Floats& a, const Floats& b, std::size_t k, bool both,
                              int threads) {
  const double most = std::max(longest(a), longest(b));
  const double scale = most > 0 ? kLongest / most : 0.0;
  Lists of_a(a.shape(0), std::min<std::size_t>(k, b.shape(0))),
      of_b(both ? b.shape(0) : 0, std::min<std::size_t>(k, a.shape(0)));
  {
    py::gil_scoped_release release;
    nearest_rows(Whole(a, scale), Whole(b, scale), threads, of_a, both ? &of_b : nullptr);
  }
  py::list out;
  for (const Lists* side : {&of_a, &of_b}) {
    if (side == &of_b && !both) continue;
    const auto few = static_cast<py::ssize_t>(side->k);
    const std::vector<py::ssize_t> shape{
        static_cast<py::ssize_t>(side->index.size()) / few, few};
    py::array_t<std::int32_t> index(shape);
    py::array_t<float> distance(shape);
    side->write(scale, index.mutable_data(), distance.mutable_data());
    out.append(py::make_tuple(index, distance));
  }
  return py::tuple(out);
}

}  // namespace

void bind_matching(py::module_& m) { m.def("_nearest_descriptors", &nearest_descriptors); }

}  // namespace rops

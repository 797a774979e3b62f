// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// How many points a pose takes near a surface (III-C), for many poses: exact. Small cells say at
// once of most places that they are near, or far from, the target; the others ask its points.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "parallel.hpp"

namespace py = pybind11;

namespace rops {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Point = std::array<double, 3>;

// Cells held at most; wide targets get larger ones.
constexpr std::size_t kMost = std::size_t{1} << 25;
// Cells are judged with this margin, in radii: the place of a point in them is rounded.
constexpr double kMargin = 1e-6;

enum Near : std::uint8_t { kFar, kAsk, kNear };

class Places {
 public:
  Places(const double* points, std::size_t count, double radius)
      : edge_(radius / 2 * (1 + kMargin)), square_(radius * radius) {
    Point high{};
    for (int a = 0; a < 3; ++a) {
      double low = points[a], top = points[a];
      for (std::size_t i = 1; i < count; ++i) {
        low = std::min(low, points[3 * i + a]);
        top = std::max(top, points[3 * i + a]);
      }
      low_[a] = low - 2 * radius, high[a] = top + 2 * radius;
    }
    while (cells(high) > static_cast<double>(kMost)) edge_ *= 1.5;
    for (int a = 0; a < 3; ++a)
      size_[a] = static_cast<std::int64_t>((high[a] - low_[a]) / edge_) + 1;
    for (int a = 0; a < 3; ++a) wide_[a] = size_[a] / 2 + 1;
    scale_ = 1.0 / edge_;
    near_.assign(size_[0] * size_[1] * size_[2], kFar);
    sort(points, count);
    for (const Point& p : points_) mark(p, radius);
  }

  // Whether p is nearer than the radius to a point of the target.
  bool holds(const Point& p) const {
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) {
      const double cell = (p[a] - low_[a]) * scale_;
      if (!(cell >= 0 && cell < static_cast<double>(size_[a]))) return false;
      at[a] = static_cast<std::int64_t>(cell);
    }
    const std::uint8_t near = near_[(at[0] * size_[1] + at[1]) * size_[2] + at[2]];
    return near == kAsk ? asked(p, at) : near == kNear;
  }

 private:
  double cells(const Point& high) const {
    double product = 1;
    for (int a = 0; a < 3; ++a) product *= std::floor((high[a] - low_[a]) / edge_) + 1;
    return product;
  }

  // The points by wide cells of two small ones, over a radius: neighbours are next to each
  // other there.
  void sort(const double* points, std::size_t count) {
    std::vector<std::size_t> owner(count);
    first_.assign(wide_[0] * wide_[1] * wide_[2] + 1, 0);
    for (std::size_t i = 0; i < count; ++i) {
      std::int64_t at[3];
      for (int a = 0; a < 3; ++a)
        at[a] = static_cast<std::int64_t>((points[3 * i + a] - low_[a]) / edge_) / 2;
      owner[i] = (at[0] * wide_[1] + at[1]) * wide_[2] + at[2];
      ++first_[owner[i] + 1];
    }
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    points_.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      points_[next[owner[i]]++] = {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
  }

  void mark(const Point& p, double radius) {
    const double least = radius * (1 - kMargin), most = radius * (1 + kMargin);
    std::int64_t from[3], to[3];
    for (int a = 0; a < 3; ++a) {
      from[a] = static_cast<std::int64_t>((p[a] - most - low_[a]) / edge_);
      to[a] = static_cast<std::int64_t>((p[a] + most - low_[a]) / edge_);
    }
    for (std::int64_t x = from[0]; x <= to[0]; ++x)
      for (std::int64_t y = from[1]; y <= to[1]; ++y)
        for (std::int64_t z = from[2]; z <= to[2]; ++z) {
          const std::int64_t at[3] = {x, y, z};
          double nearest = 0, farthest = 0;
          for (int a = 0; a < 3; ++a) {
            const double below = low_[a] + at[a] * edge_ - p[a], above = below + edge_;
            const double gap = std::max({0.0, below, -above});
            const double reach = std::max(-below, above);
            nearest += gap * gap, farthest += reach * reach;
          }
          std::uint8_t& near = near_[(x * size_[1] + y) * size_[2] + z];
          if (farthest < least * least)
            near = kNear;
          else if (nearest < most * most && near == kFar)
            near = kAsk;
        }
  }

  bool asked(const Point& p, const std::int64_t* at) const {
    const std::int64_t x = at[0] / 2, y = at[1] / 2, z = at[2] / 2;
    const std::int64_t front = std::max<std::int64_t>(z - 1, 0);
    const std::int64_t back = std::min(z + 2, wide_[2]);
    for (std::int64_t i = std::max<std::int64_t>(x - 1, 0); i < std::min(x + 2, wide_[0]); ++i)
      for (std::int64_t j = std::max<std::int64_t>(y - 1, 0); j < std::min(y + 2, wide_[1]); ++j) {
        const std::size_t row = (i * wide_[1] + j) * wide_[2];
        for (std::uint32_t k = first_[row + front]; k < first_[row + back]; ++k) {
          const double dx = points_[k][0] - p[0], dy = points_[k][1] - p[1],
                       dz = points_[k][2] - p[2];
          if (dx * dx + dy * dy + dz * dz < square_) return true;
        }
      }
    return false;
  }

  double edge_, scale_, square_;
  Point low_{};
  std::int64_t size_[3], wide_[3];
  std::vector<std::uint8_t> near_;
  std::vector<std::uint32_t> first_;
  std::vector<Point> points_;
};

std::int32_t count_one(const Places& places, const double* T, const double* points,
                       std::size_t count) {
  std::int32_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double* p = points + 3 * i;
    Point moved;
    for (int a = 0; a < 3; ++a)
      moved[a] = T[4 * a] * p[0] + T[4 * a + 1] * p[1] + T[4 * a + 2] * p[2] + T[4 * a + 3];
    found += places.holds(moved);
  }
  return found;
}

py::array_t<std::int32_t> count_near(const Doubles& source, const Doubles& target,
                                     const Doubles& transforms, double radius, int threads) {
  py::array_t<std::int32_t> counts(transforms.shape(0));
  const double *from = source.data(), *T = transforms.data();
  std::int32_t* to = counts.mutable_data();
  const std::size_t many = source.shape(0), poses = transforms.shape(0);
  py::gil_scoped_release release;
  const Places places(target.data(), target.shape(0), radius);
  parallel(poses, threads, [&](std::size_t k) {
    to[k] = count_one(places, T + 16 * k, from, many);
  });
  return counts;
}

}  // namespace

void bind_inliers(py::module_& m) { m.def("_count_near", &count_near); }

}  // namespace rops

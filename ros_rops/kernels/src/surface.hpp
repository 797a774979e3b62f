// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
//
// A view for fine registration: its points by cell, a plane fitted at each, and its rim.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cell_hash.hpp"

namespace rops::fine {

// Eigenvector of the smallest eigenvalue of a symmetric 3x3 matrix (xx xy xz yy yz zz).
inline Vec3 smallest_direction(const std::array<double, 6>& m, double* value) {
  const double q = (m[0] + m[3] + m[5]) / 3.0;
  const double off = m[1] * m[1] + m[2] * m[2] + m[4] * m[4];
  const double p2 =
      (m[0] - q) * (m[0] - q) + (m[3] - q) * (m[3] - q) + (m[5] - q) * (m[5] - q) + 2.0 * off;
  const double p = std::sqrt(p2 / 6.0);
  *value = q;
  if (!(p > 1e-12 * std::abs(q))) return {0.0, 0.0, 0.0};
  const Vec3 a = {m[0] - q, m[1], m[2]}, b = {m[1], m[3] - q, m[4]}, c = {m[2], m[4], m[5] - q};
  const double r = std::min(1.0, std::max(-1.0, dot(a, cross(b, c)) / (2.0 * p * p * p)));
  *value = q + 2.0 * p * std::cos(std::acos(r) / 3.0 + 2.0943951023931953);
  const Vec3 x = {m[0] - *value, m[1], m[2]}, y = {m[1], m[3] - *value, m[4]},
             z = {m[2], m[4], m[5] - *value};
  Vec3 best = {0.0, 0.0, 0.0};
  double length = 0.0;
  for (const Vec3& v : {cross(x, y), cross(y, z), cross(z, x)})
    if (dot(v, v) > length) {
      length = dot(v, v);
      best = v;
    }
  for (double& e : best) e /= std::sqrt(length > 0.0 ? length : 1.0);
  return best;
}

// On the rim of a surface the weighted mean of the neighbours lies 0.34 support to the side; a
// flagged vertex whose neighbours surround it is a small hole, or noise that cost it its faces.
constexpr double kRimOffset = 0.15;

// One view: points by cell; `normals` and `usable` follow that order.
struct Surface {
  CellHash hash;
  std::vector<Vec3> normals;
  std::vector<char> usable;
  std::vector<double> thickness;
  std::vector<std::int32_t> rank;  // original index -> sorted index

  Surface(const double* xyz, std::size_t n, double cell)
      : hash(xyz, n, cell), normals(n), usable(n), thickness(n), rank(n) {
    for (std::size_t k = 0; k < n; ++k) rank[hash.original(k)] = static_cast<std::int32_t>(k);
  }

  // Plane fitted to the neighbours within `support` of each point of cell c, weights falling to
  // zero there; turned to the side of the normal handed in. All points of a cell share one
  // gathering of neighbours.
  void fit_cell(std::size_t c, double support, const double* given, const bool* boundary) {
    const auto begin = hash.cell_begin(c), end = hash.cell_begin(c + 1);
    const auto home = hash.cell_of(hash.point(begin));
    const std::int64_t reach = static_cast<std::int64_t>(std::ceil(support / hash.cell_size()));
    std::vector<std::int32_t> near;
    for (std::int64_t x = -reach; x <= reach; ++x)
      for (std::int64_t y = -reach; y <= reach; ++y)
        for (std::int64_t z = -reach; z <= reach; ++z) {
          const auto [from, to] = hash.range({home[0] + x, home[1] + y, home[2] + z});
          for (auto k = from; k < to; ++k) near.push_back(k);
        }
    for (auto k = begin; k < end; ++k) fit_point(k, near, support, given, boundary);
  }

  void fit_point(std::int32_t k, const std::vector<std::int32_t>& near, double support,
                 const double* given, const bool* boundary) {
    const Vec3& p = hash.point(k);
    const std::size_t i = hash.original(k);
    const Vec3 side = {given[3 * i], given[3 * i + 1], given[3 * i + 2]};
    double sum = 0.0;
    int count = 0;
    Vec3 mean = {0.0, 0.0, 0.0};
    std::array<double, 6> m{};
    for (const auto o : near) {
      const Vec3 d = minus(hash.point(o), p);
      const double part = 1.0 - dot(d, d) / (support * support);
      if (part <= 0.0) continue;
      ++count;
      sum += part;
      int e = 0;
      for (int a = 0; a < 3; ++a) {
        mean[a] += part * d[a];
        for (int b = a; b < 3; ++b) m[e++] += part * d[a] * d[b];
      }
    }
    int e = 0;
    for (int a = 0; a < 3; ++a) mean[a] /= sum;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b, ++e) m[e] = m[e] / sum - mean[a] * mean[b];
    double value = 0.0;
    Vec3 normal = smallest_direction(m, &value);
    const double along = dot(normal, side);
    if (along < 0.0) normal = {-normal[0], -normal[1], -normal[2]};
    normals[k] = normal;
    thickness[k] = std::sqrt(std::max(value, 0.0));
    const double rise = dot(mean, normal);
    const double aside = std::sqrt(std::max(0.0, dot(mean, mean) - rise * rise));
    const bool rim = boundary[i] && aside > kRimOffset * support;
    usable[k] = count >= 6 && along != 0.0 && !rim;
  }
};

}  // namespace rops::fine

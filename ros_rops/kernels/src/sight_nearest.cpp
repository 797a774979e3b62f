// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Views of an unknown sensor have no lines of sight: the nearest point of the surface stands in.
#include <algorithm>

#include "sight.hpp"

namespace rops::sight {

namespace {

// Cosine: beside a rim, what is not above or below of it is not of this surface.
constexpr double kAbove = 0.95;
// As of the pixels of a view that has rays.
constexpr double kMostCells = 1024;
constexpr std::size_t kMostLarge = 16, kMostEntries = 24;

// Barycentric coordinates of the point of a triangle nearest to p (Ericson 2005, 5.1.5).
Vec3 nearest_parts(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp),
               d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

}  // namespace

void View::find_rim() {
  normals_.assign(vertices_.size(), {0, 0, 0});
  rim_vertices_.assign(vertices_.size(), 0);
  rim_edges_.assign(faces_.size(), 0);
  struct Side {
    std::uint64_t edge;
    std::uint32_t face, corner;
  };
  std::vector<Side> sides;
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    const Vec3 a = position(vertices_[face[0]]);
    const Vec3 n = cross(position(vertices_[face[1]]) - a, position(vertices_[face[2]]) - a);
    for (std::uint32_t k = 0; k < 3; ++k) {
      for (int e = 0; e < 3; ++e) normals_[face[k]][e] += n[e];
      const std::uint64_t p = face[(k + 1) % 3], q = face[(k + 2) % 3];
      sides.push_back({std::min(p, q) << 32 | std::max(p, q), f, k});
    }
  }
  for (Vec3& n : normals_) {
    const double length = std::sqrt(dot(n, n));
    if (length > 0) n = n * (1 / length);
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.face < b.face;
  });
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool twin = (i > 0 && sides[i - 1].edge == sides[i].edge) ||
                      (i + 1 < sides.size() && sides[i + 1].edge == sides[i].edge);
    if (twin) continue;
    rim_edges_[sides[i].face] |= 1u << sides[i].corner;
    rim_vertices_[sides[i].edge >> 32] = rim_vertices_[sides[i].edge & 0xffffffffu] = 1;
  }
}

void View::list_by_cell() {
  std::vector<std::array<Vec3, 2>> boxes;
  std::vector<double> lengths;
  for (const Face& f : faces_) {
    Vec3 low = position(vertices_[f[0]]), high = low;
    for (int k = 1; k < 3; ++k)
      for (int e = 0; e < 3; ++e) {
        const double x = position(vertices_[f[k]])[e];
        low[e] = std::min(low[e], x), high[e] = std::max(high[e], x);
      }
    boxes.push_back({low, high});
    lengths.push_back(std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}));
  }
  if (faces_.empty()) return;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  double cell = *middle > 0 ? 2 * *middle : 1;
  const auto cells = [&](const std::array<Vec3, 2>& b) {
    double n = 1;
    for (int e = 0; e < 3; ++e) n *= (b[1][e] - b[0][e]) / cell + 1;
    return n;
  };
  for (;; cell *= 2) {
    double entries = 0;
    large_.clear();
    for (std::size_t f = 0; f < boxes.size(); ++f) {
      const double n = cells(boxes[f]);
      if (n > kMostCells) large_.push_back(static_cast<std::uint32_t>(f));
      else entries += n;
    }
    if (large_.size() <= kMostLarge && entries <= kMostEntries * boxes.size()) break;
  }
  per_cell_ = 1 / cell;
  lists_ = SparseLists(faces_.size(), [&](std::size_t f, auto&& emit) {
    if (cells(boxes[f]) > kMostCells) return;
    std::array<std::int64_t, 3> low, high;
    for (int e = 0; e < 3; ++e) {
      low[e] = cell_index(boxes[f][0][e] * per_cell_);
      high[e] = cell_index(boxes[f][1][e] * per_cell_);
    }
    for (auto x = low[0]; x <= high[0]; ++x)
      for (auto y = low[1]; y <= high[1]; ++y)
        for (auto z = low[2]; z <= high[2]; ++z) emit(cell_key(x, y, z));
  });
}

bool View::on_rim(std::uint32_t face, const Vec3& parts) const {
  int zeros = 0, last = 0, corner = 0;
  for (int k = 0; k < 3; ++k) {
    if (parts[k] == 0) ++zeros, last = k;
    else corner = k;
  }
  if (zeros == 0) return false;
  return zeros == 1 ? (rim_edges_[face] >> last & 1) != 0
                    : rim_vertices_[faces_[face][corner]] != 0;
}

Glance View::nearest(const Vec3& s, double reach) const {
  double best = reach * reach;
  bool found = false;
  std::uint32_t hit = 0;
  Vec3 parts{}, offset{};
  const auto try_face = [&](std::uint32_t f) {
    const Face& face = faces_[f];
    const Vec3 a = position(vertices_[face[0]]), b = position(vertices_[face[1]]),
               c = position(vertices_[face[2]]);
    const Vec3 q = nearest_parts(s, a, b, c);
    Vec3 d;
    for (int e = 0; e < 3; ++e) d[e] = s[e] - (q[0] * a[e] + q[1] * b[e] + q[2] * c[e]);
    const double squared = dot(d, d);
    if (squared < best || (squared == best && !found))
      best = squared, hit = f, parts = q, offset = d, found = true;
  };
  std::array<std::int64_t, 3> home;
  for (int e = 0; e < 3; ++e) home[e] = cell_index(s[e] * per_cell_);
  const auto shells = static_cast<std::int64_t>(std::ceil(reach * per_cell_));
  for (std::int64_t r = 0; r <= shells; ++r) {
    // Faces of farther cells are at least this far.
    const double least = std::max<double>(0, r - 1) / per_cell_;
    if (found && least * least > best) break;
    for (auto x = -r; x <= r; ++x)
      for (auto y = -r; y <= r; ++y) {
        const bool side = std::max(std::abs(x), std::abs(y)) == r;
        for (auto z = -r; z <= r; z += side || r == 0 ? 1 : 2 * r) {
          const auto [begin, end] = lists_.at(cell_key(home[0] + x, home[1] + y, home[2] + z));
          for (auto f = begin; f != end; ++f) try_face(*f);
        }
      }
  }
  for (const auto f : large_) try_face(f);
  if (!found) return {};
  Vec3 normal{0, 0, 0};
  float weight = 0;
  for (int k = 0; k < 3; ++k) {
    const std::int32_t v = faces_[hit][k];
    weight += static_cast<float>(parts[k]) * vertices_[v].weight;
    for (int e = 0; e < 3; ++e) normal[e] += parts[k] * normals_[v][e];
  }
  const double length = std::sqrt(dot(normal, normal)), far = std::sqrt(best);
  if (!(length > 0)) return {};
  const double along = dot(offset, normal) / length;
  if (on_rim(hit, parts) && std::fabs(along) < kAbove * far) return {};
  return {static_cast<float>(along < 0 ? -far : far), weight, 1};
}

}  // namespace rops::sight

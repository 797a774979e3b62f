// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

#include <algorithm>
#include <cmath>

namespace rops {
namespace {

std::vector<std::int32_t> members(std::size_t vertices, const std::int32_t* faces,
                                  std::size_t count, bool loose) {
  std::vector<char> used(vertices, loose);
  for (std::size_t i = 0; i < 3 * count; ++i) used[faces[i]] = 1;
  std::vector<std::int32_t> chosen;
  chosen.reserve(vertices);
  for (std::size_t v = 0; v < vertices; ++v)
    if (used[v]) chosen.push_back(static_cast<std::int32_t>(v));
  return chosen;
}

// Area, centroid and spread of face f, whose corners are known.
void measure(SortedMesh& mesh, std::size_t f) {
  Vec3 p[3];
  for (int c = 0; c < 3; ++c) {
    const std::int32_t v = mesh.faces[f][c];
    p[c] = {mesh.x[v], mesh.y[v], mesh.z[v]};
  }
  Vec3 a, b, centroid;
  for (int k = 0; k < 3; ++k) {
    a[k] = p[1][k] - p[0][k];
    b[k] = p[2][k] - p[0][k];
    centroid[k] = p[0][k] + (a[k] + b[k]) / 3;
    mesh.measures[SortedMesh::kCentroid + k][f] = centroid[k];
  }
  const Vec3 normal = cross(a, b);
  mesh.measures[SortedMesh::kArea][f] = std::sqrt(dot(normal, normal));
  int row = SortedMesh::kSpread;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++row) {
      double sum = 0;
      for (const Vec3& q : p) sum += (q[i] - centroid[i]) * (q[j] - centroid[j]);
      mesh.measures[row][f] = sum / 12;
    }
}

// A face counts once: with `touching` under its first corner inside, else under its only owner.
bool counts(const SortedMesh::Corners& face, const char* inside, bool touching) {
  const bool first = inside[face[0]], second = inside[face[1]], third = inside[face[2]];
  if (!touching) return first & second & third;
  return first & (!second | (face[0] < face[1])) & (!third | (face[0] < face[2]));
}

// Add the weighted covariance and moment of the faces begin .. end, whole vectors.
ROPS_CLONES void accumulate(const SortedMesh& mesh, std::size_t begin, std::size_t end,
                            const double* areas, const double* point, double radius,
                            Lanes* sums) {
  const Lanes* row[SortedMesh::kRows];
  for (int k = 0; k < SortedMesh::kRows; ++k)
    row[k] = reinterpret_cast<const Lanes*>(mesh.measures[k]);
  const Lanes* kept = reinterpret_cast<const Lanes*>(areas);
  const Lanes *const *centroid = row + SortedMesh::kCentroid, *const *spread =
                                                                  row + SortedMesh::kSpread;
  Lanes total[9];
  std::copy(sums, sums + 9, total);
  for (std::size_t f = begin / kLanes; f < end / kLanes; ++f) {
    const Lanes dx = centroid[0][f] - point[0], dy = centroid[1][f] - point[1],
                dz = centroid[2][f] - point[2];
    Lanes distance = dx * dx + dy * dy + dz * dz;
    for (std::size_t k = 0; k < kLanes; ++k) distance[k] = std::sqrt(distance[k]);
    const Lanes inward = radius - distance, weight = kept[f] * inward * inward;
    // C_i of METHOD 3 = d d^T + spread, with d from the keypoint to the centroid.
    const Lanes wx = weight * dx, wy = weight * dy, wz = weight * dz;
    total[0] += wx * dx + weight * spread[0][f];
    total[1] += wx * dy + weight * spread[1][f];
    total[2] += wx * dz + weight * spread[2][f];
    total[3] += wy * dy + weight * spread[3][f];
    total[4] += wy * dz + weight * spread[4][f];
    total[5] += wz * dz + weight * spread[5][f];
    total[6] += wx, total[7] += wy, total[8] += wz;
  }
  std::copy(total, total + 9, sums);
}

}  // namespace

SortedMesh::SortedMesh(const double* points, std::size_t vertices, const std::int32_t* triangles,
                       std::size_t count, double cell, bool every_corner_owns, bool loose)
    : cells(points, members(vertices, triangles, count, loose), cell), rank(vertices, -1),
      measures(kRows, count * (every_corner_owns ? 3 : 1)) {
  const std::size_t n = cells.order.size();
  for (auto* axis : {&x, &y, &z}) axis->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* p = points + 3 * static_cast<std::size_t>(cells.order[i]);
    x[i] = p[0], y[i] = p[1], z[i] = p[2];
    rank[cells.order[i]] = static_cast<std::int32_t>(i);
  }
  const int owners = every_corner_owns ? 3 : 1;
  first.assign(n + 1, 0);
  for (std::size_t f = 0; f < count; ++f)
    for (int c = 0; c < owners; ++c) ++first[rank[triangles[3 * f + c]] + 1];
  for (std::size_t i = 0; i < n; ++i) first[i + 1] += first[i];
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  faces.resize(owners * count);
  for (std::size_t f = 0; f < count; ++f)
    for (int c = 0; c < owners; ++c) {
      const std::size_t place = next[rank[triangles[3 * f + c]]]++;
      for (int k = 0; k < 3; ++k) faces[place][k] = rank[triangles[3 * f + (c + k) % 3]];
      measure(*this, place);
    }
  for (int row = 0; row < kRows; ++row)  // the last vector is read whole
    std::fill_n(measures[row] + faces.size(), kLanes, 0.0);
}

void gather(const SortedMesh& mesh, const double* point, double radius, Support& support) {
  const double limit = radius * radius, px = point[0], py = point[1], pz = point[2];
  const double *x = mesh.x.data(), *y = mesh.y.data(), *z = mesh.z.data();
  double *dx = support.offsets[0], *dy = support.offsets[1], *dz = support.offsets[2];
  std::int32_t* members = support.members.data();
  for (std::size_t i = 0; i < support.size; ++i) support.inside[members[i]] = 0;
  std::size_t n = 0;
  support.runs.clear();
  mesh.cells.for_each_run(point, radius, [&](std::size_t begin, std::size_t end) {
    support.runs.push_back({begin, end});
    for (std::size_t i = begin; i < end; ++i) {
      const double a = x[i] - px, b = y[i] - py, c = z[i] - pz;
      // Written always, kept or not: cheaper than a branch that is wrong half the time.
      dx[n] = a, dy[n] = b, dz[n] = c;
      members[n] = static_cast<std::int32_t>(i);
      n += a * a + b * b + c * c <= limit;
    }
  });
  support.size = n;
  for (std::size_t i = 0; i < n; ++i) support.inside[members[i]] = 1;
}

Covariance covariance(const SortedMesh& mesh, const double* point, double radius, bool touching,
                      Support& support) {
  Lanes sums[9] = {};
  double* areas = support.areas[0];
  const double* all_areas = mesh.measures[SortedMesh::kArea];
  const char* inside = support.inside.data();
  std::size_t done = 0;  // runs rise, and whole vectors may reach into the next
  for (const auto& run : support.runs) {
    const std::size_t begin = std::max(mesh.first[run[0]] / kLanes * kLanes, done);
    const std::size_t stop = mesh.first[run[1]], last = mesh.faces.size();
    const std::size_t end = (stop + kLanes - 1) / kLanes * kLanes;
    for (std::size_t f = begin; f < std::min(end, last); ++f)
      areas[f] = counts(mesh.faces[f], inside, touching) ? all_areas[f] : 0.0;
    for (std::size_t f = last; f < end; ++f) areas[f] = 0.0;
    if (begin < end) accumulate(mesh, begin, end, areas, point, radius, sums);
    done = std::max(done, end);
  }
  Covariance sum;
  for (std::size_t k = 0; k < 9; ++k) {
    const double total = (sums[k][0] + sums[k][1]) + (sums[k][2] + sums[k][3]);
    (k < 6 ? sum.matrix[k] : sum.moment[k - 6]) = total;
  }
  return sum;
}

bool normal_frame(Support& support, double radius, double normal_radius, const Vec3& side,
                  Mat3& frame) {
  const double *dx = support.offsets[0], *dy = support.offsets[1], *dz = support.offsets[2];
  const double limit = normal_radius * normal_radius;
  double count = 0;
  Vec3 mean{};
  Sym3 second{};
  for (std::size_t i = 0; i < support.size; ++i) {
    const double x = dx[i], y = dy[i], zz = dz[i];
    if (x * x + y * y + zz * zz > limit) continue;
    count += 1;
    mean[0] += x, mean[1] += y, mean[2] += zz;
    const double outer[6] = {x * x, x * y, x * zz, y * y, y * zz, zz * zz};
    for (int k = 0; k < 6; ++k) second[k] += outer[k];
  }
  if (count < 3) return false;
  int n = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) second[n++] -= mean[i] * mean[j] / count;
  const Vec3 z = turned_towards(eigen(second).vectors[2], side);
  Vec3 weighted{};
  for (std::size_t i = 0; i < support.size; ++i) {
    const double height = dx[i] * z[0] + dy[i] * z[1] + dz[i] * z[2];
    const double inward =
        radius - std::sqrt(dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]);
    const double weight = inward * inward * height * height;
    weighted[0] += weight * dx[i], weighted[1] += weight * dy[i], weighted[2] += weight * dz[i];
  }
  return projection_frame(z, weighted, frame);
}

}  // namespace rops

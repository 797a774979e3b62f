// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

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

// Area, centroid and spread of a face whose corners are known.
void measure(SortedMesh::Face& face, const SortedMesh& mesh) {
  Vec3 p[3];
  for (int c = 0; c < 3; ++c) {
    const std::int32_t v = face.corner[c];
    p[c] = {mesh.x[v], mesh.y[v], mesh.z[v]};
  }
  Vec3 a, b;
  for (int k = 0; k < 3; ++k) {
    a[k] = p[1][k] - p[0][k];
    b[k] = p[2][k] - p[0][k];
    face.centroid[k] = p[0][k] + (a[k] + b[k]) / 3;
  }
  const Vec3 normal = cross(a, b);
  face.area = std::sqrt(dot(normal, normal));
  std::fill(face.spread, face.spread + 6, 0.0);
  for (const Vec3& q : p) {
    int n = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j)
        face.spread[n++] += (q[i] - face.centroid[i]) * (q[j] - face.centroid[j]) / 12;
  }
}

// A face counts once: under its first corner that is inside.
bool owned_here(const SortedMesh::Face& face, const Support& support, bool touching) {
  const bool second = support.stamp[face.corner[1]] == support.serial;
  const bool third = support.stamp[face.corner[2]] == support.serial;
  if (!touching) return second && third;
  return (!second || face.corner[0] < face.corner[1]) &&
         (!third || face.corner[0] < face.corner[2]);
}

}  // namespace

SortedMesh::SortedMesh(const double* points, std::size_t vertices, const std::int32_t* triangles,
                       std::size_t count, double cell, bool every_corner_owns, bool loose)
    : cells(points, members(vertices, triangles, count, loose), cell), rank(vertices, -1) {
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
      const std::int32_t owner = rank[triangles[3 * f + c]];
      Face& face = faces[next[owner]++];
      for (int k = 0; k < 3; ++k) face.corner[k] = rank[triangles[3 * f + (c + k) % 3]];
      measure(face, *this);
    }
}

void gather(const SortedMesh& mesh, const double* point, double radius, Support& support) {
  const double limit = radius * radius;
  double *dx = support.offsets[0], *dy = support.offsets[1], *dz = support.offsets[2];
  std::size_t n = 0;
  ++support.serial;
  mesh.cells.for_each_run(point, radius, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      dx[n] = mesh.x[i] - point[0];
      dy[n] = mesh.y[i] - point[1];
      dz[n] = mesh.z[i] - point[2];
      support.members[n] = static_cast<std::int32_t>(i);
      // Written always, kept or not: cheaper than a branch that is wrong half the time.
      n += dx[n] * dx[n] + dy[n] * dy[n] + dz[n] * dz[n] <= limit;
    }
  });
  support.size = n;
  for (std::size_t i = 0; i < n; ++i) support.stamp[support.members[i]] = support.serial;
}

Covariance covariance(const SortedMesh& mesh, const double* point, double radius, bool touching,
                      Support& support) {
  Covariance sum;
  for (std::size_t i = 0; i < support.size; ++i) {
    const std::int32_t v = support.members[i];
    for (std::size_t f = mesh.first[v]; f < mesh.first[v + 1]; ++f) {
      const SortedMesh::Face& face = mesh.faces[f];
      if (!owned_here(face, support, touching)) continue;
      const double dx = face.centroid[0] - point[0], dy = face.centroid[1] - point[1],
                   dz = face.centroid[2] - point[2];
      const double inward = radius - std::sqrt(dx * dx + dy * dy + dz * dz);
      const double weight = face.area * inward * inward;
      // C_i of METHOD 3 = d d^T + spread, with d from the keypoint to the centroid.
      const double wx = weight * dx, wy = weight * dy, wz = weight * dz;
      const double outer[6] = {wx * dx, wx * dy, wx * dz, wy * dy, wy * dz, wz * dz};
      for (int k = 0; k < 6; ++k) sum.matrix[k] += outer[k] + weight * face.spread[k];
      sum.moment[0] += wx, sum.moment[1] += wy, sum.moment[2] += wz;
    }
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

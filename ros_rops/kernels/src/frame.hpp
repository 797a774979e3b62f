// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Eigenvectors of a symmetric 3 x 3 matrix and the local reference frames made of them.
#pragma once

#include <array>
#include <cmath>
#include <utility>

namespace rops {

using Vec3 = std::array<double, 3>;
using Mat3 = std::array<Vec3, 3>;  // rows
using Sym3 = std::array<double, 6>;  // xx xy xz yy yz zz

inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Eigen3 {
  Vec3 values;  // falling
  Mat3 vectors;  // rows
};

// Cyclic Jacobi rotations: accurate for any conditioning, and a 3 x 3 needs few.
inline Eigen3 eigen(const Sym3& s) {
  double a[3][3] = {{s[0], s[1], s[2]}, {s[1], s[3], s[4]}, {s[2], s[4], s[5]}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  constexpr int kSweeps = 30;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double off = std::abs(a[0][1]) + std::abs(a[0][2]) + std::abs(a[1][2]);
    const double size = std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]);
    if (off <= 1e-17 * size) break;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), sn = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - sn * kq;
          a[k][q] = sn * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k], qk = a[q][k], vp = v[p][k], vq = v[q][k];
          a[p][k] = c * pk - sn * qk;
          a[q][k] = sn * pk + c * qk;
          v[p][k] = c * vp - sn * vq;
          v[q][k] = sn * vp + c * vq;
        }
      }
  }
  int order[3] = {0, 1, 2};
  if (a[order[0]][order[0]] < a[order[1]][order[1]]) std::swap(order[0], order[1]);
  if (a[order[0]][order[0]] < a[order[2]][order[2]]) std::swap(order[0], order[2]);
  if (a[order[1]][order[1]] < a[order[2]][order[2]]) std::swap(order[1], order[2]);
  Eigen3 result;
  for (int k = 0; k < 3; ++k) {
    result.values[k] = a[order[k]][order[k]];
    result.vectors[k] = {v[order[k]][0], v[order[k]][1], v[order[k]][2]};
  }
  return result;
}

inline Vec3 turned_towards(Vec3 axis, const Vec3& side) {
  if (dot(axis, side) < 0)
    for (double& value : axis) value = -value;
  return axis;
}

// IJCV 2013: v1 and v3 towards the heavier side `moment`, v2 = v3 x v1.
inline Mat3 covariance_frame(const Eigen3& axes, const Vec3& moment) {
  const Vec3 x = turned_towards(axes.vectors[0], moment);
  const Vec3 z = turned_towards(axes.vectors[2], moment);
  return {x, cross(z, x), z};
}

// TOLDI: x is `weighted` made perpendicular to z; false where nothing is left of it.
inline bool projection_frame(const Vec3& z, const Vec3& weighted, Mat3& frame) {
  const double along = dot(weighted, z);
  Vec3 x = {weighted[0] - along * z[0], weighted[1] - along * z[1], weighted[2] - along * z[2]};
  const double size = std::sqrt(dot(x, x));
  if (!(size > 0)) return false;
  for (double& value : x) value /= size;
  frame = {x, cross(z, x), z};
  return true;
}

}  // namespace rops

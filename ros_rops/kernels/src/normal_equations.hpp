// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// The point-to-plane problem in six unknowns.
#pragma once
#include <cmath>

#include "rigid.hpp"

namespace rops {

// Unknown: a small turn and shift of the source, in the target frame.
struct NormalEquations {
  double a[21] = {}, b[6] = {}, absolute = 0, weight = 0;
  int count = 0;
  void add(Float3 p, Float3 n, float e, float w) {
    const Float3 m = cross(p, n);
    const double j[6] = {m.x, m.y, m.z, n.x, n.y, n.z};
    int k = 0;
    for (int r = 0; r < 6; ++r) {
      const double wj = w * j[r];
      b[r] -= wj * e;
      for (int c = r; c < 6; ++c) a[k++] += wj * j[c];
    }
    absolute += static_cast<double>(w) * std::fabs(e);
    weight += w;
    ++count;
  }
  void add(const NormalEquations& other) {
    for (int i = 0; i < 21; ++i) a[i] += other.a[i];
    for (int i = 0; i < 6; ++i) b[i] += other.b[i];
    absolute += other.absolute, weight += other.weight, count += other.count;
  }
};

// Cholesky with damping relative to the diagonal; false if the problem is singular.
inline bool solve(const NormalEquations& n, double damping, double* x) {
  double m[6][6];
  int k = 0;
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) m[r][c] = m[c][r] = n.a[k++];
  for (int r = 0; r < 6; ++r) m[r][r] += damping * m[r][r] + 1e-12;
  double l[6][6] = {};
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c <= r; ++c) {
      double sum = m[r][c];
      for (int i = 0; i < c; ++i) sum -= l[r][i] * l[c][i];
      if (r == c) {
        if (sum <= 0) return false;
        l[r][r] = std::sqrt(sum);
      } else {
        l[r][c] = sum / l[c][c];
      }
    }
  double y[6];
  for (int r = 0; r < 6; ++r) {
    y[r] = n.b[r];
    for (int i = 0; i < r; ++i) y[r] -= l[r][i] * y[i];
    y[r] /= l[r][r];
  }
  for (int r = 5; r >= 0; --r) {
    x[r] = y[r];
    for (int i = r + 1; i < 6; ++i) x[r] -= l[i][r] * x[i];
    x[r] /= l[r][r];
  }
  return true;
}

}  // namespace rops

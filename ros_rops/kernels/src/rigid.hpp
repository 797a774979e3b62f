// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Single-precision points and rigid motions; the motion that is refined is kept in double.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

namespace rops {

struct Float3 {
  float x, y, z;
};
inline Float3 operator+(Float3 a, Float3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Float3 operator-(Float3 a, Float3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Float3 operator*(Float3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Float3 cross(Float3 a, Float3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Float3 normalized(Float3 a) {
  const float length = std::sqrt(dot(a, a));
  return length > 0 ? a * (1 / length) : a;
}

// p_target = r p_source + t
struct Rigid {
  std::array<float, 9> r;
  Float3 t;
  Float3 rotate(Float3 p) const {
    return {r[0] * p.x + r[1] * p.y + r[2] * p.z, r[3] * p.x + r[4] * p.y + r[5] * p.z,
            r[6] * p.x + r[7] * p.y + r[8] * p.z};
  }
  Float3 apply(Float3 p) const { return rotate(p) + t; }
  Rigid inverse() const {
    Rigid out{{r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}, {0, 0, 0}};
    out.t = out.rotate(t) * -1.0f;
    return out;
  }
};

inline Rigid operator*(const Rigid& a, const Rigid& b) {
  Rigid out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      out.r[3 * r + c] = a.r[3 * r] * b.r[c] + a.r[3 * r + 1] * b.r[3 + c] +
                         a.r[3 * r + 2] * b.r[6 + c];
  out.t = a.apply(b.t);
  return out;
}

// The upper three rows of a 4x4 matrix in row-major order.
inline Rigid to_rigid(const double* m) {
  Rigid out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.r[3 * r + c] = static_cast<float>(m[4 * r + c]);
  out.t = {static_cast<float>(m[3]), static_cast<float>(m[7]), static_cast<float>(m[11])};
  return out;
}

// A point and the unit normal of the surface there.
struct Oriented {
  Float3 point, normal;
};

// A pose that is refined: the upper three rows of the 4x4 matrix, row by row.
struct Pose {
  double m[12];
  Rigid rigid() const { return to_rigid(m); }
  // exp(x) on the left; Rodrigues.
  void advance(const double* x) {
    const double angle = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (angle > 1e-12) {
      const double a = x[0] / angle, b = x[1] / angle, c = x[2] / angle;
      const double s = std::sin(angle), v = 1 - std::cos(angle), k = std::cos(angle);
      const double Q[9] = {k + a * a * v,     a * b * v - c * s, a * c * v + b * s,
                           a * b * v + c * s, k + b * b * v,     b * c * v - a * s,
                           a * c * v - b * s, b * c * v + a * s, k + c * c * v};
      std::copy(Q, Q + 9, R);
    }
    double n[12];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) {
        n[4 * r + c] = R[3 * r] * m[c] + R[3 * r + 1] * m[4 + c] + R[3 * r + 2] * m[8 + c];
        if (c == 3) n[4 * r + c] += x[3 + r];
      }
    std::copy(n, n + 12, m);
  }
};

}  // namespace rops

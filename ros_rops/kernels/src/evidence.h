// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// What one view (or a grown shape) testifies about a surface: a closest-cell field, a thinned
// sample of oriented points, and a depth raster for each sensor pose that saw it.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace rops {

struct Vec3 {
  float x, y, z;
};
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3 normalized(Vec3 a) {
  const float length = std::sqrt(dot(a, a));
  return length > 0 ? a * (1 / length) : a;
}

// p_target = r p_source + t
struct Rigid {
  std::array<float, 9> r;
  Vec3 t;
  Vec3 rotate(Vec3 p) const {
    return {r[0] * p.x + r[1] * p.y + r[2] * p.z, r[3] * p.x + r[4] * p.y + r[5] * p.z,
            r[6] * p.x + r[7] * p.y + r[8] * p.z};
  }
  Vec3 apply(Vec3 p) const { return rotate(p) + t; }
  Rigid inverse() const {
    Rigid out{{r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}, {0, 0, 0}};
    out.t = out.rotate(t) * -1.0f;
    return out;
  }
};

// A point and the unit normal of the surface there.
struct Oriented {
  Vec3 point, normal;
};

// Cells of a regular grid, each knowing the nearest surface cell within `reach` cells, so that
// a nearest neighbour costs one look-up.
struct Field {
  float cell = 0;
  Vec3 origin{0, 0, 0};
  int nx = 0, ny = 0, nz = 0;
  std::vector<std::int32_t> nearest;  // per grid cell: index of a surface cell, -1 beyond reach
  std::vector<Oriented> surface;      // per surface cell: mean point and normal
  std::vector<std::uint8_t> border;   // per surface cell: holds a vertex of the mesh's boundary
  std::vector<std::int32_t> home;     // per surface cell: its grid cell
  std::vector<std::int32_t> first;    // per surface cell: its vertices, first[c]..first[c+1]
  std::vector<Oriented> vertices;     // sorted by surface cell
  std::vector<std::uint8_t> rim;      // per vertex: on the boundary

  std::int32_t locate(Vec3 p) const {
    const float fx = (p.x - origin.x) / cell, fy = (p.y - origin.y) / cell,
                fz = (p.z - origin.z) / cell;
    if (!(fx >= 0 && fy >= 0 && fz >= 0 && fx < nx && fy < ny && fz < nz)) return -1;
    return (static_cast<std::int32_t>(fz) * ny + static_cast<std::int32_t>(fy)) * nx +
           static_cast<std::int32_t>(fx);
  }
  std::int32_t closest(Vec3 p) const {
    const std::int32_t at = locate(p);
    return at < 0 ? -1 : nearest[at];
  }
  // Index of the nearest vertex within one cell's length, -1 if there is none.
  std::int32_t closest_vertex(Vec3 p) const;
};

// What a ray through a point says of it.
enum class Sight { kNone, kSeen, kInFront, kEmpty };

// Depth along the rays of one sensor pose, over pixels of about a cell.
struct Raster {
  bool pinhole = false;
  Rigid sensor_from_frame;  // z along the viewing direction, pinhole: origin at the centre
  float pixel = 0, u0 = 0, v0 = 0;
  int nu = 0, nv = 0;
  std::vector<float> nearest;       // least depth of the 3x3 pixels around, infinity where none
  std::vector<std::uint8_t> clear;  // nothing was seen in the 5x5 pixels around

  Sight look(Vec3 p, Vec3 normal, float tolerance, float facing) const;
};

struct Evidence {
  Field field;
  std::vector<Oriented> samples;       // surface cells in a fixed random order
  std::vector<std::uint8_t> on_border;  // per sample
  std::vector<Raster> rasters;
};

Field build_field(const std::vector<Oriented>& vertices, const std::vector<std::uint8_t>& rim,
                  float cell, int reach);
Raster build_raster(const std::vector<Oriented>& vertices, bool pinhole, Vec3 origin,
                    Vec3 direction, float pixel);
void draw_samples(Evidence& evidence);

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// What a view says of a point of space: how far along the line of sight its surface lies.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "frame.hpp"
#include "sparse_lists.hpp"

namespace rops::sight {

enum class Kind { kUnknown = 0, kOrthographic = 1, kPinhole = 2 };
using Face = std::array<std::int32_t, 3>;

inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 operator*(const Vec3& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }

// distance: to the surface along the line of sight, positive on the sensor's side; infinite where
// the ray is known to pass by, NaN where the view knows nothing.
struct Glance {
  float distance = NAN, weight = 0, cosine = 0;
};

// What came of the rays that pass by: the nearest depth at which one ended, by pixel.
struct Passed {
  double u0 = 0, v0 = 0, per_pixel = 0;
  std::int64_t nu = 0, nv = 0;
  std::vector<float> depth;  // NaN where nothing is known

  // Depth up to which the ray of an image point was free, NaN where that is not known.
  float operator()(double u, double v) const {
    const double i = (u - u0) * per_pixel, j = (v - v0) * per_pixel;
    if (!(i >= 0 && j >= 0 && i < nu && j < nv)) return NAN;
    return depth[static_cast<std::int64_t>(j) * nu + static_cast<std::int64_t>(i)];
  }
};

struct Scan {
  const double* vertices;
  std::size_t vertex_count;
  const std::int32_t* faces;
  std::size_t face_count;
  const float* weights;
  Kind kind;
  Vec3 origin, direction;
  const double* T_object_view;
  const float* beyond;
  std::size_t beyond_count;
};

class View {
 public:
  explicit View(const Scan& scan);
  // Of a point in the object's frame. `reach`: how far an unknown sensor's surface is looked for.
  Glance look(const Vec3& point, double reach) const;

 private:
  // A vertex in the sensor's frame: image point and depth; unknown sensors: x, y, z.
  struct Vertex {
    double u, v, z;
    float weight;
  };
  Vec3 in_sensor(const Vec3& p) const;
  Vec3 position(const Vertex& vertex) const;
  void place(const Scan& scan);
  void list_by_pixel();
  void list_by_cell();
  void find_rim();
  void look_beyond(const Scan& scan);
  Glance along_ray(const Vec3& s) const;
  Glance nearest(const Vec3& s, double reach) const;
  bool on_rim(std::uint32_t face, const Vec3& parts) const;

  Kind kind_;
  std::array<Vec3, 3> axes_;  // of the sensor's frame, in the object's
  Vec3 eye_;                  // its origin there
  std::vector<Vertex> vertices_;
  std::vector<Face> faces_;
  double per_cell_ = 1;
  SparseLists lists_;
  std::vector<std::uint32_t> large_;  // faces over very many pixels: looked at always
  Passed passed_;
  std::vector<Vec3> normals_;               // per vertex; unknown sensors only
  std::vector<std::uint8_t> rim_vertices_;  // likewise
  std::vector<std::uint8_t> rim_edges_;     // per face, bit k: the edge opposite of its vertex k
};

}  // namespace rops::sight

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// The depth raster of a sensor, and what its rays say of a point.
#include <algorithm>

#include "evidence.hpp"

namespace rops {

namespace {

// Beside the object as far as the object is large: that is where another pose would put it.
constexpr float kMargin = 1.0f;

// Where nothing of the object was seen, rays that ended beyond it tell that space is empty.
void look_beyond(Raster& raster, const std::vector<Float3>& beyond) {
  std::vector<Float3> seen;
  for (const Float3& point : beyond) {
    const Float3 s = raster.sensor_from_frame.apply(point);
    if (raster.pinhole && s.z <= 0) continue;
    const float inverse = raster.pinhole ? 1 / s.z : 1;
    const float i = (s.x * inverse - raster.u0) * raster.per_pixel;
    const float j = (s.y * inverse - raster.v0) * raster.per_pixel;
    if (i >= 0 && j >= 0 && i < raster.nu && j < raster.nv) seen.push_back({i, j, s.z});
  }
  if (seen.empty()) return;
  // The rays are thinned: each stands for the pixels up to half way to its neighbours.
  const float apart = std::sqrt(static_cast<float>(raster.pixels()) / seen.size());
  const int reach = std::min(static_cast<int>(apart / 2 + 0.5f), 4);
  std::vector<float> depths(raster.pixels(), INFINITY);
  for (const Float3& s : seen)
    for (int j = std::max(static_cast<int>(s.y) - reach, 0);
         j <= std::min(static_cast<int>(s.y) + reach, raster.nv - 1); ++j)
      for (int i = std::max(static_cast<int>(s.x) - reach, 0);
           i <= std::min(static_cast<int>(s.x) + reach, raster.nu - 1); ++i) {
        float& d = depths[static_cast<std::size_t>(j) * raster.nu + i];
        d = std::min(d, s.z);
      }
  for (std::size_t k = 0; k < depths.size(); ++k)
    if (raster.nearest[k] == INFINITY) raster.nearest[k] = depths[k];
}

}  // namespace

Raster build_raster(const std::vector<Oriented>& vertices, const std::vector<Float3>& beyond,
                    bool pinhole, Float3 origin, Float3 direction, float pixel) {
  Raster raster;
  raster.pinhole = pinhole;
  const Float3 w = normalized(direction);
  const Float3 helper = std::fabs(w.x) < 0.8f ? Float3{1, 0, 0} : Float3{0, 1, 0};
  const Float3 u = normalized(cross(helper, w)), v = cross(w, u);
  raster.sensor_from_frame = {{u.x, u.y, u.z, v.x, v.y, v.z, w.x, w.y, w.z}, {0, 0, 0}};
  if (pinhole) raster.sensor_from_frame.t = raster.sensor_from_frame.rotate(origin) * -1.0f;
  std::vector<Float3> seen;
  float depth = 0;
  for (const Oriented& p : vertices) {
    const Float3 s = raster.sensor_from_frame.apply(p.point);
    if (pinhole && s.z <= 0) continue;
    seen.push_back(pinhole ? Float3{s.x / s.z, s.y / s.z, s.z} : s);
    depth += s.z;
  }
  if (seen.empty()) return raster;
  raster.pixel = pinhole ? pixel / (depth / seen.size()) : pixel;
  raster.per_pixel = 1 / raster.pixel;
  float u1 = -INFINITY, v1 = -INFINITY;
  raster.u0 = raster.v0 = INFINITY;
  for (const Float3& s : seen) {
    raster.u0 = std::min(raster.u0, s.x), raster.v0 = std::min(raster.v0, s.y);
    u1 = std::max(u1, s.x), v1 = std::max(v1, s.y);
  }
  if (!beyond.empty()) {
    const float du = kMargin * (u1 - raster.u0), dv = kMargin * (v1 - raster.v0);
    raster.u0 -= du, raster.v0 -= dv, u1 += du, v1 += dv;
  }
  raster.u0 -= 3 * raster.pixel, raster.v0 -= 3 * raster.pixel;
  raster.nu = static_cast<int>((u1 - raster.u0) / raster.pixel) + 4;
  raster.nv = static_cast<int>((v1 - raster.v0) / raster.pixel) + 4;
  std::vector<float> depths(raster.pixels(), INFINITY);
  for (const Float3& s : seen) {
    const int i = static_cast<int>((s.x - raster.u0) / raster.pixel);
    const int j = static_cast<int>((s.y - raster.v0) / raster.pixel);
    float& d = depths[static_cast<std::size_t>(j) * raster.nu + i];
    d = std::min(d, s.z);
  }
  raster.nearest.reset(new float[raster.pixels()]);
  raster.clear.reset(new std::uint8_t[raster.pixels()]);
  std::fill_n(raster.nearest.get(), raster.pixels(), INFINITY);
  std::fill_n(raster.clear.get(), raster.pixels(), std::uint8_t{1});
  for (int j = 0; j < raster.nv; ++j)
    for (int i = 0; i < raster.nu; ++i) {
      float& d = raster.nearest[static_cast<std::size_t>(j) * raster.nu + i];
      std::uint8_t& empty = raster.clear[static_cast<std::size_t>(j) * raster.nu + i];
      for (int b = std::max(j - 2, 0); b <= std::min(j + 2, raster.nv - 1); ++b)
        for (int a = std::max(i - 2, 0); a <= std::min(i + 2, raster.nu - 1); ++a) {
          const float at = depths[static_cast<std::size_t>(b) * raster.nu + a];
          if (at == INFINITY) continue;
          empty = 0;
          if (std::abs(a - i) < 2 && std::abs(b - j) < 2) d = std::min(d, at);
        }
    }
  look_beyond(raster, beyond);
  return raster;
}

Sight Raster::look(Float3 p, Float3 normal, float tolerance, float facing) const {
  if (nu == 0) return Sight::kNone;
  const Float3 s = sensor_from_frame.apply(p);
  float u = s.x, v = s.y;
  if (pinhole) {
    if (s.z <= 0) return Sight::kNone;
    const float inverse = 1 / s.z;
    u *= inverse, v *= inverse;
  }
  const float fi = (u - u0) * per_pixel, fj = (v - v0) * per_pixel;
  bool outside = !(fi >= 0 && fj >= 0 && fi < nu && fj < nv);
  if (!outside) {
    const std::size_t at = static_cast<std::size_t>(static_cast<int>(fj)) * nu +
                           static_cast<int>(fi);
    if (nearest[at] != INFINITY)
      return s.z < nearest[at] - tolerance ? Sight::kInFront : Sight::kSeen;
    if (!clear[at]) return Sight::kNone;
  }
  const Float3 n = sensor_from_frame.rotate(normal);
  const float towards = pinhole ? -dot(n, normalized(s)) : -n.z;
  return towards > facing ? Sight::kEmpty : Sight::kNone;
}

}  // namespace rops

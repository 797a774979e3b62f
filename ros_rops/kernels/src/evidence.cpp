// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Samples of a surface, and growing it by what another view saw.
#include <algorithm>
#include <numeric>

#include "evidence.hpp"

namespace rops {

void draw_samples(Evidence& evidence) {
  const Field& field = evidence.field;
  std::vector<std::int32_t> order(field.surface.size());
  std::iota(order.begin(), order.end(), 0);
  std::uint64_t state = 0x9E3779B97F4A7C15ull;  // fixed: the same view gives the same samples
  for (std::size_t k = order.size(); k > 1; --k) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    std::swap(order[k - 1], order[(state >> 33) % k]);
  }
  evidence.samples.clear();
  evidence.on_border.clear();
  for (const std::int32_t c : order) {
    if (dot(field.surface[c].normal, field.surface[c].normal) < 0.5f) continue;
    evidence.samples.push_back(field.surface[c]);
    evidence.on_border.push_back(field.border[c]);
  }
}

Evidence grow(const Evidence& shape, const Evidence& view, const Rigid& T_shape_view, float near,
              int reach) {
  const Rigid back = T_shape_view.inverse();
  std::vector<Oriented> vertices;
  std::vector<std::uint8_t> rim;
  const float near2 = near * near;
  const auto within = [near2](const Field& field, std::int32_t k, Float3 p) {
    if (k < 0) return false;
    const Float3 gap = field.vertices[k].point - p;
    return dot(gap, gap) < near2;
  };
  const Field &old = shape.field, &fresh = view.field;
  for (std::size_t k = 0; k < old.vertices.size(); ++k) {
    if (old.rim[k]) {
      const Float3 p = back.apply(old.vertices[k].point);
      const std::int32_t other = fresh.closest_vertex(p);
      if (within(fresh, other, p) && !fresh.rim[other]) continue;
    }
    vertices.push_back(old.vertices[k]);
    rim.push_back(old.rim[k]);
  }
  for (std::size_t k = 0; k < fresh.vertices.size(); ++k) {
    const Oriented moved{T_shape_view.apply(fresh.vertices[k].point),
                         T_shape_view.rotate(fresh.vertices[k].normal)};
    const std::int32_t other = old.closest_vertex(moved.point);
    if (within(old, other, moved.point) && (fresh.rim[k] || !old.rim[other])) continue;
    vertices.push_back(moved);
    rim.push_back(fresh.rim[k]);
  }
  Evidence grown;
  grown.field = build_field(vertices, rim, old.cell, reach);
  grown.rasters = shape.rasters;
  for (Raster raster : view.rasters) {
    raster.sensor_from_frame = raster.sensor_from_frame * back;
    grown.rasters.push_back(std::move(raster));
  }
  draw_samples(grown);
  return grown;
}

}  // namespace rops

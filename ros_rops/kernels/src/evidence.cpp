// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Samples of a surface, and growing it by what another view saw.
#include "evidence.hpp"

#include <algorithm>
#include <numeric>

#include "parallel.hpp"

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
  evidence.samples.reserve(order.size());
  for (const std::int32_t c : order) {
    if (dot(field.surface[c].normal, field.surface[c].normal) < 0.5f) continue;
    evidence.samples.push_back(field.surface[c]);
  }
}

namespace {

bool within(const Field& field, std::int32_t vertex, Float3 p, float near) {
  if (vertex < 0) return false;
  const Float3 gap = field.vertices[vertex].point - p;
  return dot(gap, gap) < near * near;
}

// What `mine` keeps of its vertices beside `other`; as the newcomer it brings only what is new.
std::vector<std::uint8_t> kept_vertices(const Field& mine, const Field& other, const Rigid& move,
                                        bool newcomer, float near, int threads) {
  std::vector<std::uint8_t> keep(mine.vertices.size(), 1);
  constexpr std::size_t kChunk = 1024;
  parallel((keep.size() + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
    const std::size_t last = std::min(keep.size(), (chunk + 1) * kChunk);
    for (std::size_t k = chunk * kChunk; k < last; ++k) {
      if (!newcomer && !mine.rim[k]) continue;
      const Float3 p = move.apply(mine.vertices[k].point);
      const std::int32_t v = other.closest_vertex(p);
      if (!within(other, v, p, near)) continue;
      keep[k] = newcomer ? !mine.rim[k] && other.rim[v] : other.rim[v] != 0;
    }
  });
  return keep;
}

}  // namespace

Evidence grow(const Evidence& shape, const Evidence& view, const Rigid& T_shape_view, float near,
              int reach, int threads) {
  const Rigid back = T_shape_view.inverse();
  const Field &old = shape.field, &fresh = view.field;
  const auto stay = kept_vertices(old, fresh, back, false, near, threads);
  const auto join = kept_vertices(fresh, old, T_shape_view, true, near, threads);
  std::vector<Oriented> vertices;
  std::vector<std::uint8_t> rim;
  for (std::size_t k = 0; k < stay.size(); ++k) {
    if (!stay[k]) continue;
    vertices.push_back(old.vertices[k]);
    rim.push_back(old.rim[k]);
  }
  for (std::size_t k = 0; k < join.size(); ++k) {
    if (!join[k]) continue;
    vertices.push_back({T_shape_view.apply(fresh.vertices[k].point),
                        T_shape_view.rotate(fresh.vertices[k].normal)});
    rim.push_back(fresh.rim[k]);
  }
  Evidence grown;
  grown.field = build_field(vertices, rim, old.cell, reach, false);
  grown.rasters.reserve(shape.rasters.size() + view.rasters.size());
  grown.rasters = shape.rasters;
  for (Raster raster : view.rasters) {
    raster.sensor_from_frame = raster.sensor_from_frame * back;
    grown.rasters.push_back(std::move(raster));
  }
  draw_samples(grown);
  return grown;
}

}  // namespace rops

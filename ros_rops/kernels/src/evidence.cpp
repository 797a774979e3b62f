// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include "evidence.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace rops {
namespace {

void frame_grid(Field& field, const std::vector<Oriented>& vertices, int reach) {
  Float3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  for (const Oriented& v : vertices) {
    low = {std::min(low.x, v.point.x), std::min(low.y, v.point.y), std::min(low.z, v.point.z)};
    high = {std::max(high.x, v.point.x), std::max(high.y, v.point.y),
            std::max(high.z, v.point.z)};
  }
  const float pad = (reach + 1) * field.cell;
  field.origin = low - Float3{pad, pad, pad};
  const Float3 size = high - low;
  const double nx = std::floor((size.x + 2.0 * pad) / field.cell) + 1,
               ny = std::floor((size.y + 2.0 * pad) / field.cell) + 1,
               nz = std::floor((size.z + 2.0 * pad) / field.cell) + 1;
  if (!(nx * ny * nz <= kMostCells)) throw std::length_error("too many cells");
  field.nx = static_cast<int>(nx), field.ny = static_cast<int>(ny);
  field.nz = static_cast<int>(nz);
}

void fill_surface(Field& field, const std::vector<Oriented>& vertices,
                  const std::vector<std::uint8_t>& rim) {
  std::vector<std::int32_t> at(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) at[i] = field.locate(vertices[i].point);
  std::vector<std::int32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return at[a] < at[b]; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::int32_t i = order[k];
    if (k == 0 || at[i] != at[order[k - 1]]) {
      field.nearest[at[i]] = static_cast<std::int32_t>(field.surface.size());
      field.first.push_back(static_cast<std::int32_t>(k));
      field.surface.push_back({{0, 0, 0}, {0, 0, 0}});
      field.border.push_back(0);
      field.home.push_back(at[i]);
    }
    Oriented& cell = field.surface.back();
    cell.point = cell.point + vertices[i].point;
    cell.normal = cell.normal + vertices[i].normal;
    field.border.back() |= rim[i];
    field.vertices.push_back(vertices[i]);
    field.rim.push_back(rim[i]);
  }
  field.first.push_back(static_cast<std::int32_t>(order.size()));
  for (std::size_t c = 0; c < field.surface.size(); ++c) {
    const float count = static_cast<float>(field.first[c + 1] - field.first[c]);
    field.surface[c].point = field.surface[c].point * (1 / count);
    field.surface[c].normal = normalized(field.surface[c].normal);
  }
}

// Grow layer by layer from the surface cells; a cell takes the nearest of what its neighbours
// know. The result is the exact nearest cell but for rare ties, which do not matter here.
void spread(Field& field, int reach) {
  std::vector<std::int32_t> front, next;
  std::vector<float> distance(field.nearest.size(), INFINITY);
  for (std::size_t g = 0; g < field.nearest.size(); ++g) {
    if (field.nearest[g] >= 0) {
      front.push_back(static_cast<std::int32_t>(g));
      distance[g] = 0;
    }
  }
  for (int layer = 0; layer < reach; ++layer) {
    next.clear();
    for (const std::int32_t g : front) {
      const int x = g % field.nx, y = g / field.nx % field.ny, z = g / field.nx / field.ny;
      const std::int32_t mine = field.nearest[g];
      const Float3 p = field.surface[mine].point;
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const int X = x + dx, Y = y + dy, Z = z + dz;
            if (X < 0 || Y < 0 || Z < 0 || X >= field.nx || Y >= field.ny || Z >= field.nz)
              continue;
            const std::int32_t to = (Z * field.ny + Y) * field.nx + X;
            const Float3 centre{field.origin.x + (X + 0.5f) * field.cell,
                              field.origin.y + (Y + 0.5f) * field.cell,
                              field.origin.z + (Z + 0.5f) * field.cell};
            const float d = dot(centre - p, centre - p);
            if (d >= distance[to]) continue;
            if (distance[to] == INFINITY) next.push_back(to);
            distance[to] = d;
            field.nearest[to] = mine;
          }
    }
    front.swap(next);
  }
}

// Normals from the 27 cells around: a support of about 6 mr evens out the noise of single faces.
void smooth_normals(Field& field) {
  std::vector<Float3> sums(field.surface.size());
  for (std::size_t c = 0; c < sums.size(); ++c)
    sums[c] = field.surface[c].normal * static_cast<float>(field.first[c + 1] - field.first[c]);
  for (std::size_t c = 0; c < sums.size(); ++c) {
    Float3 total{0, 0, 0};
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::int32_t g = field.home[c] + (dz * field.ny + dy) * field.nx + dx;
          const std::int32_t o = field.nearest[g];
          if (o >= 0 && field.home[o] == g && dot(field.surface[o].normal,
                                                  field.surface[c].normal) > 0)
            total = total + sums[o];
        }
    const Float3 n = normalized(total);
    for (std::int32_t k = field.first[c]; k < field.first[c + 1]; ++k)
      field.vertices[k].normal = n;
  }
}

// Spread of the vertices of a cell about the plane of their surroundings.
float estimate_noise(const Field& field) {
  constexpr std::int32_t kFewest = 3;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t c = 0; c < field.surface.size(); ++c) {
    const std::int32_t n = field.first[c + 1] - field.first[c];
    if (n < kFewest || field.border[c]) continue;
    double squares = 0;
    for (std::int32_t k = field.first[c]; k < field.first[c + 1]; ++k) {
      const double e = dot(field.vertices[k].point - field.surface[c].point,
                           field.vertices[k].normal);
      squares += e * e;
    }
    sum += std::sqrt(squares / (n - 1));
    ++count;
  }
  return count ? static_cast<float>(sum / count) : 0.0f;
}

}  // namespace

std::int32_t Field::closest_vertex(Float3 p) const {
  const std::int32_t at = locate(p);
  if (at < 0 || nearest[at] < 0) return -1;
  const int x = at % nx, y = at / nx % ny, z = at / nx / ny;
  std::int32_t best = -1;
  float least = cell * cell;
  for (int Z = std::max(z - 1, 0); Z <= std::min(z + 1, nz - 1); ++Z)
    for (int Y = std::max(y - 1, 0); Y <= std::min(y + 1, ny - 1); ++Y)
      for (int X = std::max(x - 1, 0); X <= std::min(x + 1, nx - 1); ++X) {
        const std::int32_t g = (Z * ny + Y) * nx + X, c = nearest[g];
        if (c < 0 || home[c] != g) continue;
        for (std::int32_t k = first[c]; k < first[c + 1]; ++k) {
          const Float3 gap = vertices[k].point - p;
          const float d = dot(gap, gap);
          if (d < least) least = d, best = k;
        }
      }
  return best;
}

Field build_field(const std::vector<Oriented>& vertices, const std::vector<std::uint8_t>& rim,
                  float cell, int reach) {
  Field field;
  field.cell = cell;
  frame_grid(field, vertices, reach);
  field.nearest.assign(static_cast<std::size_t>(field.nx) * field.ny * field.nz, -1);
  fill_surface(field, vertices, rim);
  spread(field, reach);
  smooth_normals(field);
  field.noise = estimate_noise(field);
  return field;
}

Raster build_raster(const std::vector<Oriented>& vertices, bool pinhole, Float3 origin,
                    Float3 direction, float pixel) {
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
  float u1 = -INFINITY, v1 = -INFINITY;
  raster.u0 = raster.v0 = INFINITY;
  for (const Float3& s : seen) {
    raster.u0 = std::min(raster.u0, s.x), raster.v0 = std::min(raster.v0, s.y);
    u1 = std::max(u1, s.x), v1 = std::max(v1, s.y);
  }
  raster.u0 -= 3 * raster.pixel, raster.v0 -= 3 * raster.pixel;
  raster.nu = static_cast<int>((u1 - raster.u0) / raster.pixel) + 4;
  raster.nv = static_cast<int>((v1 - raster.v0) / raster.pixel) + 4;
  const std::size_t pixels = static_cast<std::size_t>(raster.nu) * raster.nv;
  std::vector<float> depths(pixels, INFINITY);
  for (const Float3& s : seen) {
    const int i = static_cast<int>((s.x - raster.u0) / raster.pixel);
    const int j = static_cast<int>((s.y - raster.v0) / raster.pixel);
    float& d = depths[static_cast<std::size_t>(j) * raster.nu + i];
    d = std::min(d, s.z);
  }
  raster.nearest.assign(pixels, INFINITY);
  raster.clear.assign(pixels, 1);
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
  return raster;
}

Sight Raster::look(Float3 p, Float3 normal, float tolerance, float facing) const {
  if (nu == 0) return Sight::kNone;
  const Float3 s = sensor_from_frame.apply(p);
  float u = s.x, v = s.y;
  if (pinhole) {
    if (s.z <= 0) return Sight::kNone;
    u /= s.z, v /= s.z;
  }
  const float fi = (u - u0) / pixel, fj = (v - v0) / pixel;
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

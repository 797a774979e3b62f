// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// The closest-cell field of a surface.
#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "evidence.hpp"

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

// All cells of the grid, x fastest, while the field is built.
struct Grid {
  std::vector<std::int32_t> nearest;  // per cell: index of a surface cell, -1 beyond reach
  std::vector<std::int32_t> home;     // per surface cell: its cell
};

// Indices of the keys (0 or more, each less than `end`) in rising order of key, ties as they stand.
std::vector<std::int32_t> sorted_by(const std::vector<std::int32_t>& keys, std::size_t end) {
  constexpr int kBits = 11;
  constexpr std::size_t kDigits = std::size_t{1} << kBits;
  std::vector<std::int32_t> order(keys.size()), next(keys.size());
  std::iota(order.begin(), order.end(), 0);
  for (int shift = 0; shift == 0 || (end - 1) >> shift; shift += kBits) {
    std::vector<std::int32_t> starts(kDigits + 1, 0);
    for (const std::int32_t key : keys) ++starts[((key >> shift) & (kDigits - 1)) + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    for (const std::int32_t i : order) next[starts[(keys[i] >> shift) & (kDigits - 1)]++] = i;
    order.swap(next);
  }
  return order;
}

void fill_surface(Field& field, Grid& grid, const std::vector<Oriented>& vertices,
                  const std::vector<std::uint8_t>& rim) {
  std::vector<std::int32_t> at(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    int x = 0, y = 0, z = 0;
    field.cell_of(vertices[i].point, x, y, z);
    at[i] = (z * field.ny + y) * field.nx + x;
  }
  const std::vector<std::int32_t> order = sorted_by(at, grid.nearest.size());
  field.vertices.reserve(order.size());
  field.rim.reserve(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::int32_t i = order[k];
    if (k == 0 || at[i] != at[order[k - 1]]) {
      grid.nearest[at[i]] = static_cast<std::int32_t>(field.surface.size());
      field.first.push_back(static_cast<std::int32_t>(k));
      field.surface.push_back({{0, 0, 0}, {0, 0, 0}});
      field.border.push_back(0);
      grid.home.push_back(at[i]);
    }
    Oriented& cell = field.surface.back();
    cell.point = cell.point + vertices[i].point;
    cell.normal = cell.normal + vertices[i].normal;
    field.border.back() |= rim[i];
    field.vertices.push_back(vertices[i]);
    field.rim.push_back(rim[i]);
  }
  field.first.push_back(static_cast<std::int32_t>(order.size()));
  // It is kept as long as the view is.
  field.first.shrink_to_fit(), field.surface.shrink_to_fit(), field.border.shrink_to_fit();
  for (std::size_t c = 0; c < field.surface.size(); ++c) {
    const float count = static_cast<float>(field.first[c + 1] - field.first[c]);
    field.surface[c].point = field.surface[c].point * (1 / count);
    field.surface[c].normal = normalized(field.surface[c].normal);
  }
}

// Grow layer by layer from the surface cells; a cell takes the nearest of what its neighbours
// know: the nearest in nine of ten, elsewhere one a few per cent farther. A surface cell knows
// itself.
void spread(const Field& field, Grid& grid, int reach) {
  std::vector<std::int32_t> front, next;
  std::vector<float> distance(grid.nearest.size(), INFINITY);
  for (std::size_t g = 0; g < grid.nearest.size(); ++g) {
    if (grid.nearest[g] >= 0) {
      front.push_back(static_cast<std::int32_t>(g));
      distance[g] = 0;
    }
  }
  for (int layer = 0; layer < reach; ++layer) {
    next.clear();
    for (const std::int32_t g : front) {
      const int x = g % field.nx, y = g / field.nx % field.ny, z = g / field.nx / field.ny;
      const std::int32_t mine = grid.nearest[g];
      const Float3 p = field.surface[mine].point;
      // Squared distances along each axis of the three cells there.
      float ex[3], ey[3], ez[3];
      for (int k = 0; k < 3; ++k) {
        ex[k] = field.origin.x + (x + k - 1 + 0.5f) * field.cell - p.x, ex[k] *= ex[k];
        ey[k] = field.origin.y + (y + k - 1 + 0.5f) * field.cell - p.y, ey[k] *= ey[k];
        ez[k] = field.origin.z + (z + k - 1 + 0.5f) * field.cell - p.z, ez[k] *= ez[k];
      }
      const int x0 = x > 0 ? -1 : 0, x1 = x + 1 < field.nx ? 1 : 0;
      const int y0 = y > 0 ? -1 : 0, y1 = y + 1 < field.ny ? 1 : 0;
      const int z0 = z > 0 ? -1 : 0, z1 = z + 1 < field.nz ? 1 : 0;
      for (int dz = z0; dz <= z1; ++dz)
        for (int dy = y0; dy <= y1; ++dy)
          for (int dx = x0; dx <= x1; ++dx) {
            const std::int32_t to = g + (dz * field.ny + dy) * field.nx + dx;
            const float d = ex[dx + 1] + ey[dy + 1] + ez[dz + 1];
            if (d >= distance[to]) continue;
            if (distance[to] == INFINITY) next.push_back(to);
            distance[to] = d;
            grid.nearest[to] = mine;
          }
    }
    front.swap(next);
  }
}

// Normals from the 27 cells around: a support of about 6 mr evens out the noise of single faces.
void smooth_normals(Field& field, const Grid& grid) {
  std::vector<Float3> sums(field.surface.size());
  for (std::size_t c = 0; c < sums.size(); ++c)
    sums[c] = field.surface[c].normal * static_cast<float>(field.first[c + 1] - field.first[c]);
  for (std::size_t c = 0; c < sums.size(); ++c) {
    Float3 total{0, 0, 0};
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::int32_t g = grid.home[c] + (dz * field.ny + dy) * field.nx + dx;
          const std::int32_t o = grid.nearest[g];
          if (o >= 0 && grid.home[o] == g && dot(field.surface[o].normal,
                                                  field.surface[c].normal) > 0)
            total = total + sums[o];
        }
    const Float3 n = normalized(total);
    for (std::int32_t k = field.first[c]; k < field.first[c + 1]; ++k)
      field.vertices[k].normal = n;
  }
}

// Residual of a plane fitted, by least squares along n, to offsets from a point on it; negative
// if there are too few. A plane of its own, as a mean normal is itself noisy.
double plane_spread(const std::vector<Float3>& offsets, Float3 n) {
  constexpr std::size_t kFewest = 6, kUnknowns = 3;
  if (offsets.size() < kFewest) return -1;
  const Float3 helper = std::fabs(n.x) < 0.8f ? Float3{1, 0, 0} : Float3{0, 1, 0};
  const Float3 u = normalized(cross(helper, n)), v = cross(n, u);
  double c = 0, x = 0, y = 0, e = 0;
  for (const Float3& o : offsets) c += 1, x += dot(o, u), y += dot(o, v), e += dot(o, n);
  x /= c, y /= c, e /= c;
  double xx = 0, xy = 0, yy = 0, xe = 0, ye = 0, ee = 0;
  for (const Float3& o : offsets) {
    const double a = dot(o, u) - x, b = dot(o, v) - y, d = dot(o, n) - e;
    xx += a * a, xy += a * b, yy += b * b, xe += a * d, ye += b * d, ee += d * d;
  }
  const double det = xx * yy - xy * xy;
  if (det <= 1e-6 * xx * yy) return -1;
  const double p = (xe * yy - ye * xy) / det, q = (ye * xx - xe * xy) / det;
  return std::sqrt(std::max(ee - p * xe - q * ye, 0.0) / (offsets.size() - kUnknowns));
}

// Spread of the vertices across their surface: of the columns along the normal, one cell's
// length in radius, around at most kColumns surface cells.
float estimate_noise(const Field& field, const Grid& grid) {
  constexpr std::size_t kColumns = 2000;
  const std::size_t stride = std::max<std::size_t>(1, field.surface.size() / kColumns);
  double sum = 0;
  std::size_t count = 0;
  std::vector<Float3> offsets;
  for (std::size_t c = 0; c < field.surface.size(); c += stride) {
    if (field.border[c]) continue;
    const Float3 n = field.vertices[field.first[c]].normal, middle = field.surface[c].point;
    offsets.clear();
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::int32_t g = grid.home[c] + (dz * field.ny + dy) * field.nx + dx;
          const std::int32_t o = grid.nearest[g];
          if (o < 0 || grid.home[o] != g) continue;
          for (std::int32_t k = field.first[o]; k < field.first[o + 1]; ++k) {
            const Float3 gap = field.vertices[k].point - middle;
            const float height = dot(gap, n);
            if (dot(gap, gap) - height * height < field.cell * field.cell &&
                dot(field.vertices[k].normal, n) > 0)
              offsets.push_back(gap);
          }
        }
    const double spread = plane_spread(offsets, n);
    if (spread < 0) continue;
    sum += spread;
    ++count;
  }
  return count ? static_cast<float>(sum / count) : 0.0f;
}

// Keep the bricks of the grid that hold something.
void lay_bricks(Field& field, const Grid& grid) {
  constexpr int kEdge = 4, kCells = kEdge * kEdge * kEdge;
  const auto count = [](int cells) { return (cells + kEdge - 1) / kEdge; };
  field.bricks_x = count(field.nx), field.bricks_y = count(field.ny);
  field.bricks.assign(
      static_cast<std::size_t>(field.bricks_x) * field.bricks_y * count(field.nz), -1);
  const auto brick_of = [&](int x, int y, int z) -> std::int32_t& {
    return field.bricks[(z / kEdge * field.bricks_y + y / kEdge) * field.bricks_x + x / kEdge];
  };
  const auto each_cell = [&](auto visit) {
    std::size_t g = 0;
    for (int z = 0; z < field.nz; ++z)
      for (int y = 0; y < field.ny; ++y)
        for (int x = 0; x < field.nx; ++x, ++g)
          if (grid.nearest[g] >= 0) visit(x, y, z, grid.nearest[g]);
  };
  std::int32_t slots = 0;
  each_cell([&](int x, int y, int z, std::int32_t) {
    std::int32_t& first = brick_of(x, y, z);
    if (first < 0) first = slots, slots += kCells;
  });
  field.nearest.assign(slots, -1);
  each_cell([&](int x, int y, int z, std::int32_t surface) {
    field.nearest[field.slot(x, y, z)] = surface;
  });
  field.home.resize(grid.home.size());
  for (std::size_t c = 0; c < grid.home.size(); ++c) {
    const std::int32_t g = grid.home[c];
    field.home[c] =
        field.slot(g % field.nx, g / field.nx % field.ny, g / field.nx / field.ny);
  }
}

}  // namespace

std::int32_t Field::closest_vertex(Float3 p) const {
  int x, y, z;
  if (!cell_of(p, x, y, z)) return -1;
  const std::int32_t at = slot(x, y, z);
  if (at < 0 || nearest[at] < 0) return -1;
  std::int32_t best = -1;
  float least = cell * cell;
  for (int Z = std::max(z - 1, 0); Z <= std::min(z + 1, nz - 1); ++Z)
    for (int Y = std::max(y - 1, 0); Y <= std::min(y + 1, ny - 1); ++Y)
      for (int X = std::max(x - 1, 0); X <= std::min(x + 1, nx - 1); ++X) {
        const std::int32_t there = slot(X, Y, Z), c = there < 0 ? -1 : nearest[there];
        if (c < 0 || home[c] != there) continue;
        for (std::int32_t k = first[c]; k < first[c + 1]; ++k) {
          const Float3 gap = vertices[k].point - p;
          const float d = dot(gap, gap);
          if (d < least) least = d, best = k;
        }
      }
  return best;
}

Field build_field(const std::vector<Oriented>& vertices, const std::vector<std::uint8_t>& rim,
                  float cell, int reach, bool even_normals) {
  Field field;
  field.cell = cell;
  field.per_cell = 1 / cell;
  frame_grid(field, vertices, reach);
  Grid grid;
  grid.nearest.assign(static_cast<std::size_t>(field.nx) * field.ny * field.nz, -1);
  fill_surface(field, grid, vertices, rim);
  spread(field, grid, reach);
  if (even_normals) smooth_normals(field, grid);
  field.noise = estimate_noise(field, grid);
  lay_bricks(field, grid);
  return field;
}

}  // namespace rops

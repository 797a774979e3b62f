// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// What one view (or a grown shape) testifies about a surface: a closest-cell field, a thinned
// sample of oriented points, and a depth raster for each sensor pose that saw it.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "rigid.hpp"

namespace rops {

// Cells of a regular grid, each knowing the nearest surface cell within `reach` cells, so that
// a nearest neighbour costs one look-up. Most of the grid is empty space: it is kept in bricks of
// 4 x 4 x 4 cells, and of these only those near the surface.
struct Field {
  float cell = 0, per_cell = 0;  // edge of a cell and its inverse
  Float3 origin{0, 0, 0};
  int nx = 0, ny = 0, nz = 0;
  int bricks_x = 0, bricks_y = 0;
  std::vector<std::int32_t> bricks;   // per brick: slot of its first cell, -1 where none is near
  std::vector<std::int32_t> nearest;  // per slot: index of a surface cell, -1 beyond reach
  std::vector<Oriented> surface;      // per surface cell: mean point and normal
  std::vector<std::uint8_t> border;   // per surface cell: holds a vertex of the mesh's boundary
  std::vector<std::int32_t> home;     // per surface cell: its slot
  std::vector<std::int32_t> first;    // per surface cell: its vertices, first[c]..first[c+1]
  std::vector<Oriented> vertices;     // sorted by surface cell
  std::vector<std::uint8_t> rim;      // per vertex: on the boundary
  float noise = 0;                    // standard deviation of vertices across the surface

  // The cell that holds `p`; false outside of the grid.
  bool cell_of(Float3 p, int& x, int& y, int& z) const {
    const float fx = (p.x - origin.x) * per_cell, fy = (p.y - origin.y) * per_cell,
                fz = (p.z - origin.z) * per_cell;
    if (!(fx >= 0 && fy >= 0 && fz >= 0 && fx < nx && fy < ny && fz < nz)) return false;
    x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
    return true;
  }
  // Where a cell of the grid is kept, -1 where nothing is near.
  std::int32_t slot(int x, int y, int z) const {
    const std::int32_t first_slot = bricks[((z >> 2) * bricks_y + (y >> 2)) * bricks_x + (x >> 2)];
    return first_slot < 0 ? -1 : first_slot + ((z & 3) << 4 | (y & 3) << 2 | (x & 3));
  }
  std::int32_t locate(Float3 p) const {
    int x, y, z;
    return cell_of(p, x, y, z) ? slot(x, y, z) : -1;
  }
  // Index of the nearest vertex within one cell's length, -1 if there is none.
  std::int32_t closest_vertex(Float3 p) const;
};

// What a ray through a point says of it.
enum class Sight { kNone, kSeen, kInFront, kEmpty };

// Depth along the rays of one sensor pose, over pixels of about a cell.
struct Raster {
  bool pinhole = false;
  Rigid sensor_from_frame;  // z along the viewing direction, pinhole: origin at the centre
  float pixel = 0, per_pixel = 0, u0 = 0, v0 = 0;
  int nu = 0, nv = 0;
  // Not written once built: a view and the shapes that it joined have them in common.
  std::shared_ptr<float[]> nearest;       // least depth of the 3x3 pixels around, or infinity
  std::shared_ptr<std::uint8_t[]> clear;  // nothing was seen in the 5x5 pixels around

  std::size_t pixels() const { return static_cast<std::size_t>(nu) * nv; }
  // An unmatched point with this normal: is it in front of what was seen by more than
  // `tolerance`, or would it have been seen where nothing was (cosine to the ray > `facing`)?
  Sight look(Float3 p, Float3 normal, float tolerance, float facing) const;
};

struct Evidence {
  Field field;
  std::vector<Oriented> samples;  // surface cells in a fixed random order
  std::vector<Raster> rasters;
};

// Enough for an object of 3000 resolutions a side; beyond it the view holds stray points.
constexpr std::size_t kMostCells = 64u << 20;

// Throws std::length_error if the extent takes more than kMostCells cells. Normals are evened out
// among neighbours at most once: every time more would carry them farther along the surface.
Field build_field(const std::vector<Oriented>& vertices, const std::vector<std::uint8_t>& rim,
                  float cell, int reach, bool even_normals);
// `beyond`: where rays ended that pass by the object.
Raster build_raster(const std::vector<Oriented>& vertices, const std::vector<Float3>& beyond,
                    bool pinhole, Float3 origin, Float3 direction, float pixel);
void draw_samples(Evidence& evidence);

// Grow `shape` by `view` (IV-A): its vertices farther than `near` from the shape are added, and
// those that show the inside of a surface where the shape knows only a rim, which they replace.
Evidence grow(const Evidence& shape, const Evidence& view, const Rigid& T_shape_view, float near,
              int reach, int threads);

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace rops {

// Delaunay triangulation of `count` points in the plane (uv, interleaved): counter-clockwise
// triangles. Points that coincide on a raster of 2^-30 of the extent count once, the first;
// points on one line of the raster give none.
std::vector<std::array<std::int32_t, 3>> delaunay(const double* uv, std::size_t count);

}  // namespace rops

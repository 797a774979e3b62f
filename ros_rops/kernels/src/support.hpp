// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// A mesh sorted for support queries, and what one keypoint's support says of its frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cells.hpp"
#include "frame.hpp"
#include "lanes.hpp"

namespace rops {

// Vertices (`loose`: those without a face too) in cell order, and per vertex the faces it owns.
struct SortedMesh {
  SortedMesh(const double* points, std::size_t vertices, const std::int32_t* faces,
             std::size_t count, double cell, bool every_corner_owns, bool loose);

  using Corners = std::array<std::int32_t, 3>;  // sorted vertices, the owner first
  // Rows of `measures`; the spread (six rows) is 1/12 of the sum over the corners of
  // (p - centroid)(p - centroid)^T, the area is doubled.
  enum Row { kArea, kCentroid, kSpread = kCentroid + 3, kRows = kSpread + 6 };

  Cells cells;
  std::vector<double> x, y, z;
  std::vector<std::size_t> first;  // faces of sorted vertex i: first[i] .. first[i + 1]
  std::vector<Corners> faces;
  std::vector<std::int32_t> rank;  // vertex -> sorted vertex, -1 where left out
  Rows measures;
};

// Scratch of one thread. Coordinates are relative to the keypoint.
struct Support {
  Support(std::size_t vertices, std::size_t faces)
      : offsets(3, vertices), local(3, vertices), turned(2, vertices), areas(1, faces),
        members(vertices + kLanes), inside(vertices, 0), fixed_bins(vertices + kLanes),
        bins(vertices + kLanes) {}

  Rows offsets, local, turned, areas;
  std::vector<std::int32_t> members;
  std::vector<char> inside;  // 1 for members
  std::vector<std::array<std::size_t, 2>> runs;  // of sorted vertices, what may be inside
  std::vector<std::int32_t> fixed_bins, bins;
  std::vector<std::uint32_t> table;
  std::size_t size = 0;
};

struct Covariance {
  Sym3 matrix{};
  Vec3 moment{};
};

// Collect the vertices within `radius` of `point`.
void gather(const SortedMesh& mesh, const double* point, double radius, Support& support);

// Weighted covariance of the support's triangles (METHOD 3); `touching`: every triangle with a
// vertex inside counts (PCL), else only those with all three (the author's toolbox).
Covariance covariance(const SortedMesh& mesh, const double* point, double radius, bool touching,
                      Support& support);

// Frame with the normal of a smaller support as z and x by weighted projection (TOLDI).
bool normal_frame(Support& support, double radius, double normal_radius, const Vec3& side,
                  Mat3& frame);

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Signed distances to the surface that all views together saw, kept near it only.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sight.hpp"

namespace rops {

// Voxels in bricks of 8 x 8 x 8, of which only those near a triangle of some view are kept.
class Volume {
 public:
  static constexpr int kSide = 8, kVoxels = kSide * kSide * kSide;
  using Brick = std::array<std::int32_t, 3>;

  // `band`: distance from the surface within which voxels count.
  Volume(const Vec3& origin, double voxel, double band)
      : origin_(origin), voxel_(voxel), band_(band) {}

  // Keep the bricks near these triangles (edges up to `longest`); false once there are more than
  // `most`, and then the volume is of no use.
  bool touch(const double* vertices, const std::int32_t* faces, std::size_t face_count,
             double longest, std::size_t most);
  // Weigh in what a view says (Curless and Levoy 1996, 3).
  void integrate(const sight::View& view, int threads);
  // Distances in voxels, NaN where nothing is known; bricks in the order of `bricks()`.
  void distances(float* values, int threads) const;
  const std::vector<Brick>& bricks() const { return bricks_; }

 private:
  struct Sum {
    float weight = 0, distance = 0;
  };
  float mean(std::size_t slot) const;
  // Neighbouring brick of each offset -1..1, KeySlots::kNone where there is none.
  std::array<std::uint32_t, 27> around(const Brick& brick) const;

  Vec3 origin_;
  double voxel_, band_;
  KeySlots slots_;
  std::vector<Brick> bricks_;
  std::vector<Sum> sums_;
};

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// RoPS: statistics of the support's rotated projections (Guo et al. 2014, eqs. 1-4).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "frame.hpp"
#include "support.hpp"

namespace rops {

struct Rotation {
  int axis;  // 0 x, 1 y, 2 z
  double cosine, sine;  // first' = c first + s second, second' = -s first + c second
};

struct Convention {
  std::vector<Rotation> rotations;  // those about one axis follow each other
  int bins;
  double log_unit;  // entropy = natural entropy times this
  bool skip_keypoint, absolute_norm;
  std::size_t length() const { return rotations.size() * 15; }
};

// Write the descriptor (convention.length() floats) of the support gathered, in `frame`.
void describe(const Convention& convention, const Mat3& frame, Support& support, float* out);

}  // namespace rops

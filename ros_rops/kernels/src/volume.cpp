// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Integration of views into a volume of bricks.
#include "volume.hpp"

#include <algorithm>

#include "parallel.hpp"

namespace rops {

namespace {

// Of a brick's number along an axis, both ways: what a key holds of it.
constexpr double kFarthest = (1 << 20) - 2;
// Weight of a ray that is known to end beyond the object: less than of a surface well seen.
constexpr float kFreeWeight = 0.5f;
// Distances so near to zero, in voxels, are moved away: vertices of the surface then lie between
// two voxels, never on one, and tell by their place which ones.
constexpr float kLeast = 1e-3f;

// What was seen goes on along the surface, where distances change little from voxel to voxel, and
// from where they are not cut off at the band.
constexpr float kSteepest = 0.5f;
constexpr float kInner = 0.9f;

// Behind its surface a view knows ever less: another one may follow. Up to this share of the band
// behind, which noise reaches, its word holds; up to twice that where no other view has one.
constexpr float kSure = 0.4f;
constexpr float kGuess = 0.01f;

// Weight of a voxel `along` the ray and `across` the surface, in lengths of which a view is sure.
// Grazing rays leave a thin part soon: along the ray says that, and across how far cubes need it.
float trust_in(float along, float across) {
  if (!(across > -2)) return 0;
  const float left = std::min(1 + across / 2, 1.0f);
  return std::min(std::max(2 + along, kGuess * left * left), 1.0f);
}

}  // namespace

bool Volume::touch(const double* vertices, const std::int32_t* faces, std::size_t face_count,
                   double longest, std::size_t most) {
  const double per_brick = 1 / (kSide * voxel_);
  for (std::size_t f = 0; f < face_count; ++f) {
    Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
    for (int k = 0; k < 3; ++k)
      for (int e = 0; e < 3; ++e) {
        const double x = vertices[3 * static_cast<std::size_t>(faces[3 * f + k]) + e] - origin_[e];
        low[e] = std::min(low[e], x), high[e] = std::max(high[e], x);
      }
    bool usable = true;
    for (int e = 0; e < 3; ++e) {
      usable &= high[e] - low[e] <= longest;
      low[e] = (low[e] - band_) * per_brick, high[e] = (high[e] + band_) * per_brick;
      usable &= low[e] > -kFarthest && high[e] < kFarthest;
    }
    if (!usable) continue;
    for (auto x = cell_index(low[0]); x <= cell_index(high[0]); ++x)
      for (auto y = cell_index(low[1]); y <= cell_index(high[1]); ++y)
        for (auto z = cell_index(low[2]); z <= cell_index(high[2]); ++z) {
          if (slots_.insert(cell_key(x, y, z)) < bricks_.size()) continue;
          bricks_.push_back({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                             static_cast<std::int32_t>(z)});
          if (bricks_.size() > most) return false;
        }
  }
  return true;
}

void Volume::integrate(const sight::View& view, int threads) {
  sums_.resize(bricks_.size() * kVoxels);
  const float band = static_cast<float>(band_), sure = kSure * band;
  parallel_with(bricks_.size(), 16, threads, [&] {
    return [&](std::size_t b) {
      Sum* sum = sums_.data() + b * kVoxels;
      Vec3 p;
      for (int x = 0; x < kSide; ++x) {
        p[0] = origin_[0] + voxel_ * (kSide * bricks_[b][0] + x);
        for (int y = 0; y < kSide; ++y) {
          p[1] = origin_[1] + voxel_ * (kSide * bricks_[b][1] + y);
          for (int z = 0; z < kSide; ++z, ++sum) {
            p[2] = origin_[2] + voxel_ * (kSide * bricks_[b][2] + z);
            const sight::Glance glance = view.look(p, band_);
            if (std::isnan(glance.distance)) continue;
            if (std::isinf(glance.distance)) {
              sum->weight += kFreeWeight, sum->distance += kFreeWeight * band;
              continue;
            }
            // Across the surface rather than along the ray: that is what views have in common.
            const float d = glance.distance * glance.cosine;
            const float trust = trust_in(glance.distance / sure, d / sure);
            if (!(trust > 0)) continue;
            const float weight = glance.weight * trust;
            sum->weight += weight, sum->distance += weight * std::min(d, band);
          }
        }
      }
    };
  });
}

float Volume::mean(std::size_t slot) const {
  const Sum& sum = sums_[slot];
  return sum.weight > 0 ? sum.distance / sum.weight / static_cast<float>(voxel_) : NAN;
}

std::array<std::uint32_t, 27> Volume::around(const Brick& brick) const {
  std::array<std::uint32_t, 27> found;
  std::size_t k = 0;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        found[k++] = slots_.find(cell_key(static_cast<std::int64_t>(brick[0]) + x,
                                          static_cast<std::int64_t>(brick[1]) + y,
                                          static_cast<std::int64_t>(brick[2]) + z));
  return found;
}

void Volume::distances(float* values, int threads) const {
  const float band = static_cast<float>(band_ / voxel_);
  parallel_with(sums_.size() / kVoxels, 16, threads, [&] {
    return [&](std::size_t b) {
      const auto bricks = around(bricks_[b]);
      const auto at = [&](int x, int y, int z) {
        const int bx = (x + kSide) / kSide, by = (y + kSide) / kSide, bz = (z + kSide) / kSide;
        const std::uint32_t brick = bricks[9 * bx + 3 * by + bz];
        if (brick == KeySlots::kNone) return NAN;
        return mean(static_cast<std::size_t>(brick) * kVoxels +
                    ((x & 7) * kSide + (y & 7)) * kSide + (z & 7));
      };
      // A cube needs all of its corners: without this the surface would end up to two voxels
      // before the border of what was seen. What is known in a row of two goes on for one more.
      const auto continued = [&](int x, int y, int z) {
        float sum = 0, count = 0;
        for (int k = 0; k < 27; ++k) {
          const int i = k / 9 - 1, j = k / 3 % 3 - 1, l = k % 3 - 1;
          const float next = at(x + i, y + j, z + l);
          if (std::isnan(next)) continue;
          const float slope = next - at(x + 2 * i, y + 2 * j, z + 2 * l);
          const float step = std::sqrt(static_cast<float>(i * i + j * j + l * l));
          if (!(std::fabs(slope) <= kSteepest * step && std::fabs(next) < kInner * band)) continue;
          sum += next + slope, count += 1;
        }
        return count > 0 ? sum / count : NAN;
      };
      float* out = values + b * kVoxels;
      for (int x = 0; x < kSide; ++x)
        for (int y = 0; y < kSide; ++y)
          for (int z = 0; z < kSide; ++z, ++out) {
            float value = mean(b * kVoxels + (x * kSide + y) * kSide + z);
            if (std::isnan(value)) value = continued(x, y, z);
            if (std::fabs(value) < kLeast) value = value < 0 ? -kLeast : kLeast;
            *out = value;
          }
    };
  });
}

}  // namespace rops

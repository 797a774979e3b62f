// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "batch.hpp"
#include "verification.hpp"

namespace rops {
namespace {

void score_overlap(const Oriented& at, Float3 p, Float3 n, float tau2, Score& sum) {
  const Float3 gap = p - at.point;
  const float d2 = dot(gap, gap);
  if (d2 >= tau2) return;
  const float near = (1 - d2 / tau2) * (1 - d2 / tau2), agree = dot(n, at.normal);
  if (agree > 0) sum.overlap += near * agree;
  if (agree < 0.5f) sum.disagree += near;
}

}  // namespace

Score score_one_way(const Evidence& from, const Evidence& to, const Rigid& T,
                    const ScoreSettings& s) {
  Score sum;
  const float tau2 = s.tau * s.tau;
  const std::size_t count = std::min<std::size_t>(s.samples, from.samples.size());
  const std::size_t sensors = to.rasters.size();
  Batch batch;
  for (std::size_t first = 0; first < count; first += kBatch) {
    look_up(from, to.field, T, first, count, batch);
    for (std::size_t k = 0; k < batch.size; ++k) {
      const Float3 p = batch.points[k], n = T.rotate(from.samples[first + k].normal);
      if (batch.cells[k] >= 0)
        score_overlap(to.field.surface[batch.cells[k]], p, n, tau2, sum);
      if (!sensors) continue;
      // One raster a sample: of many views each gets its share, at the cost of one.
      const Raster& raster = to.rasters[sensors == 1 ? 0 : (first + k) % sensors];
      const Sight sight = raster.look(p, n, s.front, s.facing);
      sum.front += sight == Sight::kInFront;
      sum.empty += sight == Sight::kEmpty;
    }
  }
  const double share = count ? 1.0 / count : 0.0;
  return {sum.overlap * share, sum.front * share, sum.empty * share, sum.disagree * share};
}

}  // namespace rops

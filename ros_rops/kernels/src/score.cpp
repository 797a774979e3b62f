// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "verification.hpp"

namespace rops {

Score score_one_way(const Evidence& from, const Evidence& to, const Rigid& T,
                    const ScoreSettings& s) {
  Score sum;
  const float tau2 = s.tau * s.tau;
  const std::size_t count = std::min<std::size_t>(s.samples, from.samples.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Float3 p = T.apply(from.samples[k].point), n = T.rotate(from.samples[k].normal);
    const std::int32_t c = to.field.closest(p);
    if (c >= 0) {
      const Oriented& q = to.field.surface[c];
      const Float3 gap = p - q.point;
      const float d2 = dot(gap, gap);
      if (d2 < tau2) {
        const float near = (1 - d2 / tau2) * (1 - d2 / tau2), agree = dot(n, q.normal);
        if (agree > 0) sum.overlap += near * agree;
        if (agree < 0.5f) sum.disagree += near;
      }
    }
    if (to.rasters.empty()) continue;
    // One raster a sample: of many views each gets its share, at the cost of one.
    const Sight sight = to.rasters[k % to.rasters.size()].look(p, n, s.front, s.facing);
    sum.front += sight == Sight::kInFront;
    sum.empty += sight == Sight::kEmpty;
  }
  const double share = count ? 1.0 / count : 0.0;
  return {sum.overlap * share, sum.front * share, sum.empty * share, sum.disagree * share};
}

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "batch.hpp"
#include "verification.hpp"

namespace rops {
namespace {

constexpr int kFewestMatches = 10;
constexpr double kDamping = 1e-4;

void match_forward(const Evidence& from, const Evidence& to, const Rigid& T, std::size_t samples,
                   float radius, float agree, NormalEquations& eq) {
  samples = std::min(samples, from.samples.size());
  const float radius2 = radius * radius;
  Batch batch;
  for (std::size_t first = 0; first < samples; first += kBatch) {
    look_up(from, to.field, T, first, samples, batch);
    for (std::size_t k = 0; k < batch.size; ++k) {
      const std::int32_t c = batch.cells[k];
      if (c < 0) continue;
      const Oriented& q = to.field.surface[c];
      const Float3 p = batch.points[k], gap = p - q.point;
      const float d2 = dot(gap, gap);
      if (d2 > radius2 || to.field.border[c]) continue;
      if (dot(T.rotate(from.samples[first + k].normal), q.normal) < agree) continue;
      eq.add(p, q.normal, dot(gap, q.normal), 1 - d2 / radius2);
    }
  }
}

// The same with the sides changed; the unknown motion is still that of the source.
void match_backward(const Evidence& source, const Evidence& target, const Rigid& T,
                    std::size_t samples, float radius, float agree, NormalEquations& eq) {
  const Rigid back = T.inverse();
  samples = std::min(samples, target.samples.size());
  const float radius2 = radius * radius;
  Batch batch;
  for (std::size_t first = 0; first < samples; first += kBatch) {
    look_up(target, source.field, back, first, samples, batch);
    for (std::size_t k = 0; k < batch.size; ++k) {
      const std::int32_t c = batch.cells[k];
      if (c < 0) continue;
      const Oriented& s = source.field.surface[c];
      const Float3 gap = s.point - batch.points[k];
      const float d2 = dot(gap, gap);
      if (d2 > radius2 || source.field.border[c]) continue;
      const Float3 n = T.rotate(s.normal);
      if (dot(n, target.samples[first + k].normal) < agree) continue;
      eq.add(T.apply(s.point), n, dot(gap, s.normal), 1 - d2 / radius2);
    }
  }
}

}  // namespace

int refine_pose(const Evidence& source, const Evidence& target, Pose& pose, const double* radii,
                std::size_t rounds, const RefineSettings& s) {
  int matches = 0;
  for (std::size_t k = 0; k < rounds; ++k) {
    const Rigid T = pose.rigid();
    const float radius = static_cast<float>(radii[k]);
    NormalEquations equations;
    match_forward(source, target, T, s.samples, radius, s.agree, equations);
    match_backward(source, target, T, s.samples, radius, s.agree, equations);
    matches = equations.count;
    double x[6];
    if (matches < kFewestMatches || !solve(equations, kDamping, x)) break;
    pose.advance(x);
  }
  return matches;
}

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "verification.hpp"

namespace rops {
namespace {

constexpr int kFewestMatches = 10;
constexpr double kDamping = 1e-4;

void match_forward(const Evidence& from, const Evidence& to, const Rigid& T, std::size_t samples,
                   float radius, float agree, NormalEquations& eq) {
  samples = std::min(samples, from.samples.size());
  for (std::size_t k = 0; k < samples; ++k) {
    const Float3 p = T.apply(from.samples[k].point);
    const std::int32_t c = to.field.closest(p);
    if (c < 0 || to.field.border[c]) continue;
    const Oriented& q = to.field.surface[c];
    const Float3 gap = p - q.point;
    const float d2 = dot(gap, gap);
    if (d2 > radius * radius || dot(T.rotate(from.samples[k].normal), q.normal) < agree) continue;
    const float w = 1 - d2 / (radius * radius);
    eq.add(p, q.normal, dot(gap, q.normal), w);
  }
}

void match_backward(const Evidence& source, const Evidence& target, const Rigid& T,
                    std::size_t samples, float radius, float agree, NormalEquations& eq) {
  const Rigid back = T.inverse();
  samples = std::min(samples, target.samples.size());
  for (std::size_t k = 0; k < samples; ++k) {
    const Float3 x = back.apply(target.samples[k].point);
    const std::int32_t c = source.field.closest(x);
    if (c < 0 || source.field.border[c]) continue;
    const Oriented& s = source.field.surface[c];
    const Float3 gap = s.point - x;
    const float d2 = dot(gap, gap);
    if (d2 > radius * radius) continue;
    const Float3 n = T.rotate(s.normal);
    if (dot(n, target.samples[k].normal) < agree) continue;
    const float w = 1 - d2 / (radius * radius);
    eq.add(T.apply(s.point), n, dot(gap, s.normal), w);
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

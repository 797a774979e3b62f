// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "verification.hpp"

namespace rops {
namespace {

constexpr int kFewestMatches = 10;
constexpr double kDamping = 1e-6;
// Surfaces agree within 60 degrees.
constexpr float kAgree = 0.5f;

// What the rays say of a point that met no surface; of several sensors the worst word counts.
void ask_rasters(const Evidence& to, Float3 p, Float3 n, const ExamSettings& s, Exam& out) {
  bool front = false, empty = false;
  for (const Raster& raster : to.rasters) {
    const Sight sight = raster.look(p, n, s.front, s.facing);
    front |= sight == Sight::kInFront;
    empty |= sight == Sight::kEmpty;
  }
  out.front += front;
  out.empty += empty && !front;
}

void examine_one_way(const Evidence& from, const Evidence& to, const Rigid& T, bool forward,
                     bool rays, const ExamSettings& s, Exam& out) {
  const std::size_t total = from.field.vertices.size();
  const std::size_t stride = std::max<std::size_t>(1, total / std::max(s.samples, 1));
  const Rigid go = forward ? T : T.inverse();
  for (std::size_t k = 0; k < total; k += stride) {
    const Oriented& v = from.field.vertices[k];
    const Float3 p = go.apply(v.point), n = go.rotate(v.normal);
    out.count += 1;
    const std::int32_t c = to.field.closest_vertex(p);
    const Float3 gap = c < 0 ? Float3{0, 0, 0} : p - to.field.vertices[c].point;
    if (c < 0 || dot(gap, gap) > s.radius * s.radius) {
      if (rays) ask_rasters(to, p, n, s, out);
      continue;
    }
    const Oriented& q = to.field.vertices[c];
    if (dot(n, q.normal) < kAgree) {
      out.disagree += 1;
      continue;
    }
    if (to.field.rim[c]) continue;
    out.matched += 1;
    if (forward) {
      out.equations.add(p, q.normal, dot(gap, q.normal), 1);
    } else {
      out.equations.add(T.apply(q.point), T.rotate(q.normal), -dot(gap, q.normal), 1);
    }
  }
}

}  // namespace

void examine_pose(const Evidence& source, const Evidence& target, Pose& pose, int rounds,
                  const ExamSettings& settings, Exam& forward, Exam& backward) {
  const auto measure = [&](bool rays) {
    forward = Exam(), backward = Exam();
    const Rigid T = pose.rigid();
    examine_one_way(source, target, T, true, rays, settings, forward);
    examine_one_way(target, source, T, false, rays, settings, backward);
  };
  // What the rays say moves nothing: it is asked of the last pose only.
  for (int k = 0; k < rounds; ++k) {
    measure(false);
    NormalEquations both = forward.equations;
    both.add(backward.equations);
    double x[6];
    if (both.count < kFewestMatches || !solve(both, kDamping, x)) break;
    pose.advance(x);
  }
  measure(true);
}

}  // namespace rops

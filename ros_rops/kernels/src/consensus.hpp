// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// What the points of all views around a place agree on: a height, a normal, a colour.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cell_hash.hpp"

namespace rops::consensus {

using fine::cross;
using fine::dot;
using fine::minus;
using fine::Vec3;

// A measured point, in the frame of the object.
struct Sample {
  std::array<float, 3> normal;
  float weight;
  std::int32_t view;
  std::array<std::uint8_t, 4> color;
};

struct Reach {
  double radius;  // across the normal
  double depth;   // along the normal
  double near;    // across: what counts as the same place
  double paint;   // across: what colours mix
};

// Points count less the farther they are and the more their normals differ.
constexpr double kLeastCosine = 0.2, kFullCosine = 0.7;
// Of the heights' slope, relative to the radius: a one-sided neighbourhood must not tilt freely.
constexpr double kRidge = 0.01;
constexpr double kMostSlope = 1.0;
constexpr int kRounds = 3;

inline double bell(double squared, double radius) {
  const double left = 1 - squared / (radius * radius);
  return left > 0 ? left * left : 0.0;
}
inline Vec3 normalized(const Vec3& v) {
  const double length = std::sqrt(dot(v, v));
  if (!(length > 0)) return v;
  return {v[0] / length, v[1] / length, v[2] / length};
}

struct Answer {
  Vec3 point, normal;
  double weight = 0;
  std::int32_t view = -1, directions = 0, support = 0;
  std::array<std::uint8_t, 3> color{};
};

class Field {
 public:
  Field(const double* points, std::size_t n, std::vector<Sample> samples, int views, Reach reach)
      : hash_(points, n, std::max(reach.radius, reach.depth)), views_(views), reach_(reach) {
    samples_.reserve(n);
    for (std::size_t k = 0; k < n; ++k) samples_.push_back(samples[hash_.original(k)]);
  }

  const fine::CellHash& hash() const { return hash_; }
  int views() const { return views_; }

  // Scratch of a thread: what each view says at a place.
  struct Tally {
    double weight = 0, share = 0;
    bool near = false;
  };

  Answer ask(Vec3 p, Vec3 n, std::vector<Tally>& tallies) const {
    Answer answer;
    n = smooth(p, n);
    for (int round = 0; round + 1 < kRounds; ++round) step(p, n);
    answer.point = p;
    answer.normal = n;
    count(p, n, tallies, answer);
    return answer;
  }
  // The same without moving the point.
  Answer stay(const Vec3& p, const Vec3& n, std::vector<Tally>& tallies) const {
    Answer answer;
    answer.point = p;
    answer.normal = n;
    count(p, n, tallies, answer);
    return answer;
  }

 private:
  struct Seen {
    Vec3 offset, normal;
    double along, across;  // the latter squared
    double cosine, weight;
  };

  // Call visit(seen, sample) for the points around p on the same side of the surface.
  template <class Visit>
  void around(const Vec3& p, const Vec3& n, Visit&& visit) const {
    const double far = std::max(reach_.radius, reach_.depth);
    const auto low = hash_.cell_of({p[0] - far, p[1] - far, p[2] - far});
    const auto high = hash_.cell_of({p[0] + far, p[1] + far, p[2] + far});
    const double most = reach_.radius * reach_.radius;
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const auto [begin, end] = hash_.range({x, y, z});
          for (std::int32_t k = begin; k < end; ++k) {
            Seen seen;
            seen.offset = minus(hash_.point(k), p);
            seen.along = dot(seen.offset, n);
            if (std::abs(seen.along) >= reach_.depth) continue;
            seen.across = dot(seen.offset, seen.offset) - seen.along * seen.along;
            if (seen.across >= most) continue;
            const Sample& s = samples_[k];
            seen.normal = {s.normal[0], s.normal[1], s.normal[2]};
            seen.cosine = dot(seen.normal, n);
            if (seen.cosine <= kLeastCosine) continue;
            const double like = std::min(
                (seen.cosine - kLeastCosine) / (kFullCosine - kLeastCosine), 1.0);
            seen.weight = like * bell(seen.across, reach_.radius) *
                          bell(seen.along * seen.along, reach_.depth);
            visit(seen, s);
          }
        }
  }

  // The mean of the normals around: that of one point is as noisy as its triangles.
  Vec3 smooth(const Vec3& p, const Vec3& n) const {
    Vec3 sum = {0, 0, 0};
    around(p, n, [&](const Seen& seen, const Sample& s) {
      for (int a = 0; a < 3; ++a) sum[a] += s.weight * seen.weight * seen.normal[a];
    });
    return dot(sum, sum) > 0 ? normalized(sum) : n;
  }

  // Move p along n to the height that the points around agree on, and turn n to their slope.
  void step(Vec3& p, Vec3& n) const {
    const Vec3 helper = std::abs(n[0]) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 e = normalized(cross(helper, n)), f = cross(n, e);
    double w = 0, wu = 0, wv = 0, wuu = 0, wuv = 0, wvv = 0;
    double t = 0, tu = 0, tv = 0, h = 0, hu = 0, hv = 0;
    around(p, n, [&](const Seen& seen, const Sample& s) {
      const double weight = s.weight * seen.weight;
      const double u = dot(seen.offset, e), v = dot(seen.offset, f);
      // Two points of a circle differ at right angles to the sum of their normals, so that a
      // curved surface neither shrinks nor swells.
      const double height =
          (seen.along + dot(seen.offset, seen.normal)) / (1 + seen.cosine);
      w += weight, wu += weight * u, wv += weight * v;
      wuu += weight * u * u, wuv += weight * u * v, wvv += weight * v * v;
      t += weight * height, tu += weight * height * u, tv += weight * height * v;
      h += weight * seen.along, hu += weight * seen.along * u, hv += weight * seen.along * v;
    });
    if (!(w > 0)) return;
    const double ridge = kRidge * w * reach_.radius * reach_.radius;
    const double cuu = wuu - wu * wu / w + ridge, cvv = wvv - wv * wv / w + ridge;
    const double cuv = wuv - wu * wv / w, det = cuu * cvv - cuv * cuv;
    const auto slope = [&](double z, double zu, double zv) {
      const double a = zu - wu * z / w, b = zv - wv * z / w;
      return std::array<double, 2>{(cvv * a - cuv * b) / det, (cuu * b - cuv * a) / det};
    };
    const auto lean = slope(t, tu, tv);
    const auto tilt = slope(h, hu, hv);
    const double rise = (t - lean[0] * wu - lean[1] * wv) / w;
    const double most = std::max(std::abs(tilt[0]), std::abs(tilt[1]));
    if (!(std::abs(rise) < reach_.depth) || !(most < kMostSlope)) return;
    for (int a = 0; a < 3; ++a) p[a] += rise * n[a];
    n = normalized({n[0] - tilt[0] * e[0] - tilt[1] * f[0], n[1] - tilt[0] * e[1] - tilt[1] * f[1],
                    n[2] - tilt[0] * e[2] - tilt[1] * f[2]});
  }

  // Who saw the place, how well, and in what colour.
  void count(const Vec3& p, const Vec3& n, std::vector<Tally>& tallies, Answer& answer) const {
    std::fill(tallies.begin(), tallies.end(), Tally{});
    std::array<double, 4> fine_paint{}, wide_paint{};
    around(p, n, [&](const Seen& seen, const Sample& s) {
      Tally& tally = tallies[s.view];
      tally.weight += seen.weight * s.weight;
      tally.share += seen.weight;
      tally.near |= seen.across < reach_.near * reach_.near;
      ++answer.support;
      if (!s.color[3]) return;
      const double wide = seen.weight * s.weight;
      const double narrow = wide * bell(seen.across, reach_.paint);
      for (int a = 0; a < 3; ++a) {
        wide_paint[a] += wide * s.color[a];
        fine_paint[a] += narrow * s.color[a];
      }
      wide_paint[3] += wide;
      fine_paint[3] += narrow;
    });
    double best = 0;
    for (int view = 0; view < views_; ++view) {
      const Tally& tally = tallies[view];
      if (!(tally.share > 0)) continue;
      answer.weight += tally.weight / tally.share;
      answer.directions += tally.near;
      if (tally.weight > best) best = tally.weight, answer.view = view;
    }
    const auto& paint = fine_paint[3] > 0 ? fine_paint : wide_paint;
    for (int a = 0; a < 3 && paint[3] > 0; ++a)
      answer.color[a] = static_cast<std::uint8_t>(
          std::clamp(std::nearbyint(paint[a] / paint[3]), 0.0, 255.0));
  }

  fine::CellHash hash_;
  std::vector<Sample> samples_;
  int views_;
  Reach reach_;
};

}  // namespace rops::consensus

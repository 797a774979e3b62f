// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// What the points of all views around a place agree on.
#include "consensus.hpp"
#include "lanes.hpp"

namespace rops::consensus {

namespace {

typedef float Wide __attribute__((vector_size(kWide * sizeof(float)), aligned(4)));

inline void load(const std::vector<float>& row, std::size_t k, Wide& out) {
  out = *reinterpret_cast<const Wide*>(row.data() + k);
}
inline void inner(const Wide* a, const float* b, Wide& out) {
  out = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline void clip(Wide& a) { a = a > 0 ? a : Wide{}; }
inline double total(const Wide& a) {
  double sum = 0;
  for (std::size_t k = 0; k < kWide; ++k) sum += a[k];
  return sum;
}

// Eight points as a target sees them.
struct Eight {
  Wide offset[3], normal[3];
  Wide along, across, cosine, weight;  // across: squared; the weight without the points' own
};

inline __attribute__((always_inline)) void look(const Around& around, const Place& place,
                                                std::size_t k, Eight& e) {
  for (int a = 0; a < 3; ++a) {
    load(around.rows[a], k, e.offset[a]);
    load(around.rows[3 + a], k, e.normal[a]);
    e.offset[a] -= place.shift[a];
  }
  const float inverse = 1 / (place.radius * place.radius);
  inner(e.offset, place.normal, e.along);
  inner(e.normal, place.normal, e.cosine);
  const Wide up = e.along * e.along;
  e.across = e.offset[0] * e.offset[0] + e.offset[1] * e.offset[1] + e.offset[2] * e.offset[2] - up;
  Wide flat = 1 - e.across * inverse, high = 1 - up * inverse;
  Wide like = (e.cosine - kLeastCosine) * (1 / (kFullCosine - kLeastCosine));
  clip(flat), clip(high), clip(like);
  e.weight = flat * flat * high * high * (like < 1 ? like : Wide{} + 1);
}

Vec3 plus(const Vec3& a, const float* b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

void turn(const Vec3& normal, Place& place) {
  const Vec3 n = normalized(normal);
  const Vec3 helper = std::abs(n[0]) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 e = normalized(cross(helper, n)), f = cross(n, e);
  for (int a = 0; a < 3; ++a) {
    place.normal[a] = static_cast<float>(n[a]);
    place.e[a] = static_cast<float>(e[a]);
    place.f[a] = static_cast<float>(f[a]);
  }
}

// Move along the normal to the height that the points around agree on, and turn to their slope.
void step(const double* s, Place& place) {
  const double w = s[0];
  if (!(w > 0)) return;
  const double ridge = kRidge * w * place.radius * place.radius;
  const double uu = s[3] - s[1] * s[1] / w + ridge, vv = s[5] - s[2] * s[2] / w + ridge;
  const double uv = s[4] - s[1] * s[2] / w, det = uu * vv - uv * uv;
  const auto slope = [&](const double* z) {
    const double a = z[1] - s[1] * z[0] / w, b = z[2] - s[2] * z[0] / w;
    return std::array<double, 2>{(vv * a - uv * b) / det, (uu * b - uv * a) / det};
  };
  const auto lean = slope(s + 6), tilt = slope(s + 9);
  const double rise = (s[6] - lean[0] * s[1] - lean[1] * s[2]) / w;
  if (!(std::abs(rise) < place.radius) ||
      !(std::max(std::abs(tilt[0]), std::abs(tilt[1])) < kMostSlope))
    return;
  Vec3 n;
  for (int a = 0; a < 3; ++a) {
    n[a] = place.normal[a] - tilt[0] * place.e[a] - tilt[1] * place.f[a];
    place.shift[a] += static_cast<float>(rise * place.normal[a]);
  }
  turn(n, place);
}

}  // namespace

ROPS_CLONES
void add_up(const Around& around, const Place& place, double* sums) {
  Wide sum[kSums] = {};
  for (std::size_t k = 0; k < around.count; k += kWide) {
    Eight e;
    look(around, place, k, e);
    Wide w, u, v;
    load(around.rows[6], k, w);
    w *= e.weight;
    inner(e.offset, place.e, u);
    inner(e.offset, place.f, v);
    const Wide own = e.offset[0] * e.normal[0] + e.offset[1] * e.normal[1] +
                     e.offset[2] * e.normal[2];
    // Two points of a circle differ at right angles to the sum of their normals, so that a
    // curved surface neither shrinks nor swells.
    const Wide below = 1 + e.cosine;
    const Wide t = w * ((e.along + own) / (below > 1 ? below : Wide{} + 1)), h = w * e.along;
    const Wide wu = w * u, wv = w * v;
    const Wide terms[kSums] = {w,     wu,    wv,    wu * u, wu * v,          wv * v,
                               t,     t * u, t * v, h,      h * u,           h * v,
                               w * e.normal[0],     w * e.normal[1],         w * e.normal[2]};
    for (int i = 0; i < kSums; ++i) sum[i] += terms[i];
  }
  for (int i = 0; i < kSums; ++i) sums[i] = total(sum[i]);
}

ROPS_CLONES
void weigh(const Around& around, const Place& place, float* weights, float* across) {
  for (std::size_t k = 0; k < around.count; k += kWide) {
    Eight e;
    look(around, place, k, e);
    *reinterpret_cast<Wide*>(weights + k) = e.weight;
    *reinterpret_cast<Wide*>(across + k) = e.across;
  }
}

Answer Field::ask(const Vec3& p, const Vec3& n, bool move, Scratch& scratch) const {
  Place place{};
  place.radius = static_cast<float>(reach_.radius);
  turn(n, place);
  collect(p, n, scratch.around);
  double sums[kSums];
  if (move) {
    // The mean of the normals around first: that of one point is as noisy as its triangles.
    add_up(scratch.around, place, sums);
    if (sums[0] > 0) turn({sums[12], sums[13], sums[14]}, place);
    for (int round = 0; round < kSteps; ++round) {
      add_up(scratch.around, place, sums);
      step(sums, place);
    }
  }
  Answer answer;
  answer.point = plus(p, place.shift);
  answer.normal = {place.normal[0], place.normal[1], place.normal[2]};
  count(place, scratch, answer);
  return answer;
}

void Field::collect(const Vec3& p, const Vec3& n, Around& around) const {
  around.clear();
  const double far = kSlack * reach_.radius;
  const auto low = hash_.cell_of({p[0] - far, p[1] - far, p[2] - far});
  const auto high = hash_.cell_of({p[0] + far, p[1] + far, p[2] + far});
  for (std::int64_t x = low[0]; x <= high[0]; ++x)
    for (std::int64_t y = low[1]; y <= high[1]; ++y)
      for (std::int64_t z = low[2]; z <= high[2]; ++z) {
        const auto [begin, end] = hash_.range({x, y, z});
        for (std::int32_t k = begin; k < end; ++k) {
          const Vec3 offset = minus(hash_.point(k), p);
          if (!(dot(offset, offset) < far * far)) continue;
          const auto& m = samples_[k].normal;
          if (m[0] * n[0] + m[1] * n[1] + m[2] * n[2] > 0) around.add(offset, samples_[k], k);
        }
      }
  around.pad();
}

// Who saw the place, how well, and in what colour.
void Field::count(const Place& place, Scratch& scratch, Answer& answer) const {
  const Around& around = scratch.around;
  scratch.weights.resize(around.rows[0].size());
  scratch.across.resize(around.rows[0].size());
  weigh(around, place, scratch.weights.data(), scratch.across.data());
  scratch.present.clear();
  std::array<double, 4> narrow{}, wide{};
  for (std::size_t k = 0; k < around.count; ++k) {
    const double share = scratch.weights[k], across = scratch.across[k];
    if (!(share > 0)) continue;
    const Sample& s = samples_[around.which[k]];
    Tally& tally = scratch.tallies[s.view];
    if (tally.share == 0) scratch.present.push_back(s.view);
    tally.weight += share * s.weight;
    tally.share += share;
    tally.near |= across < reach_.near * reach_.near;
    ++answer.support;
    if (!s.color[3]) continue;
    const double left = std::max(1 - across / (reach_.paint * reach_.paint), 0.0);
    const double weight = share * s.weight;
    for (int a = 0; a < 3; ++a) {
      wide[a] += weight * s.color[a];
      narrow[a] += weight * left * left * s.color[a];
    }
    wide[3] += weight;
    narrow[3] += weight * left * left;
  }
  std::sort(scratch.present.begin(), scratch.present.end());
  double best = 0;
  for (const std::int32_t view : scratch.present) {
    Tally& tally = scratch.tallies[view];
    answer.weight += tally.weight / tally.share;
    answer.directions += tally.near;
    if (tally.weight > best) best = tally.weight, answer.view = view;
    tally = Tally{};
  }
  const auto& paint = narrow[3] > 0 ? narrow : wide;
  for (int a = 0; a < 3 && paint[3] > 0; ++a)
    answer.color[a] =
        static_cast<std::uint8_t>(std::clamp(std::nearbyint(paint[a] / paint[3]), 0.0, 255.0));
}

}  // namespace rops::consensus

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Sweep by distance from the middle, with Lawson's flips, in exact integer arithmetic: a point
// at least as far out as all before it is a corner of their hull, so it always sees an edge.
#include "delaunay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace rops {
namespace {

__extension__ typedef __int128 Wide;

constexpr double kRaster = 1 << 30;  // determinants stay below 2^127
constexpr std::int32_t kNone = -1;

struct Point {
  std::int64_t x, y, distance;  // squared, from the middle
  std::int32_t index;
};

// Twice the area of a b c; positive when counter-clockwise.
std::int64_t orient(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

template <typename T>
struct Lifted {
  T x, y, lift;
  Lifted(const Point& p, const Point& d)
      : x(static_cast<T>(p.x - d.x)), y(static_cast<T>(p.y - d.y)), lift(x * x + y * y) {}
};

// Whether d lies strictly inside the circle through the counter-clockwise a b c.
bool in_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Lifted<double> p(a, d), q(b, d), r(c, d);
  const double det = p.lift * (q.x * r.y - q.y * r.x) + q.lift * (r.x * p.y - r.y * p.x) +
                     r.lift * (p.x * q.y - p.y * q.x);
  const double size = p.lift * (std::abs(q.x * r.y) + std::abs(q.y * r.x)) +
                      q.lift * (std::abs(r.x * p.y) + std::abs(r.y * p.x)) +
                      r.lift * (std::abs(p.x * q.y) + std::abs(p.y * q.x));
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  if (std::abs(det) > kRounding * size) return det > 0;
  const Lifted<Wide> u(a, d), v(b, d), w(c, d);
  return u.lift * (v.x * w.y - v.y * w.x) + v.lift * (w.x * u.y - w.y * u.x) +
             w.lift * (u.x * v.y - u.y * v.x) > 0;
}

std::vector<Point> rastered(const double* uv, std::size_t count) {
  double low[2] = {uv[0], uv[1]}, high[2] = {uv[0], uv[1]};
  for (std::size_t i = 0; i < 2 * count; ++i) {
    low[i % 2] = std::min(low[i % 2], uv[i]);
    high[i % 2] = std::max(high[i % 2], uv[i]);
  }
  const double extent = std::max(high[0] - low[0], high[1] - low[1]);
  const double scale = extent > 0 ? kRaster / extent : 0.0;
  std::vector<Point> points(count);
  double mean[2] = {0, 0};
  for (std::size_t i = 0; i < count; ++i) {
    points[i] = {std::llround((uv[2 * i] - low[0]) * scale),
                 std::llround((uv[2 * i + 1] - low[1]) * scale), 0,
                 static_cast<std::int32_t>(i)};
    mean[0] += static_cast<double>(points[i].x) / count;
    mean[1] += static_cast<double>(points[i].y) / count;
  }
  for (Point& p : points) {  // the middle becomes the origin
    p.x -= std::llround(mean[0]);
    p.y -= std::llround(mean[1]);
    p.distance = p.x * p.x + p.y * p.y;
  }
  return points;
}

std::vector<Point> sweep_order(const double* uv, std::size_t count) {
  std::vector<Point> points = rastered(uv, count);
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    if (a.distance != b.distance) return a.distance < b.distance;
    if (a.x != b.x) return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.index < b.index;
  });
  const auto same = [](const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; };
  points.erase(std::unique(points.begin(), points.end(), same), points.end());
  return points;
}

std::int32_t after(std::int32_t edge) { return edge % 3 == 2 ? edge - 2 : edge + 1; }
std::int32_t before(std::int32_t edge) { return edge % 3 == 0 ? edge + 2 : edge - 1; }

// Half-edge e of triangle e / 3 runs from origin[e] to origin[after(e)]; twin[e] runs back.
class Sweep {
 public:
  explicit Sweep(std::vector<Point> points)
      : points_(std::move(points)), next_(points_.size(), kNone), previous_(points_.size(), kNone),
        hull_edge_(points_.size(), kNone),
        hash_(static_cast<std::size_t>(std::sqrt(points_.size())) + 1, kNone) {
    origin_.reserve(6 * points_.size());
    twin_.reserve(6 * points_.size());
  }

  std::vector<std::array<std::int32_t, 3>> run() {
    const std::size_t line = leading_line();
    if (line < points_.size()) {
      start(line);
      for (std::size_t i = line + 1; i < points_.size(); ++i) insert(static_cast<int>(i));
    }
    std::vector<std::array<std::int32_t, 3>> triangles(origin_.size() / 3);
    for (std::size_t e = 0; e < origin_.size(); ++e)
      triangles[e / 3][e % 3] = points_[origin_[e]].index;
    return triangles;
  }

 private:
  // How many points of the order lie on the line of the first two.
  std::size_t leading_line() const {
    std::size_t n = std::min<std::size_t>(2, points_.size());
    while (n < points_.size() && orient(points_[0], points_[1], points_[n]) == 0) ++n;
    return n;
  }

  // Fan from the first point off the line to the points on it.
  void start(std::size_t line) {
    std::vector<std::int32_t> chain(line);
    for (std::size_t i = 0; i < line; ++i) chain[i] = static_cast<std::int32_t>(i);
    std::sort(chain.begin(), chain.end(), [this](std::int32_t a, std::int32_t b) {
      return std::make_pair(points_[a].x, points_[a].y) <
             std::make_pair(points_[b].x, points_[b].y);
    });
    const std::int32_t tip = static_cast<std::int32_t>(line);
    // The hull of a line is the line there and back; the tip sees one of the two.
    if (orient(points_[chain[0]], points_[chain[1]], points_[tip]) > 0)
      std::reverse(chain.begin(), chain.end());
    attach(chain, tip);
    // The far side of the line is the hull's, too.
    for (std::size_t i = 0; i + 1 < line; ++i) join(chain[i + 1], chain[i]);
    join(chain[0], tip);
    join(tip, chain[line - 1]);
    for (const std::int32_t v : chain) remember(v);
    remember(tip);
    settle(tip);
  }

  void join(std::int32_t a, std::int32_t b) { next_[a] = b, previous_[b] = a; }

  void link(std::int32_t a, std::int32_t b) {
    twin_[a] = b;
    if (b == kNone)
      hull_edge_[origin_[a]] = a;
    else
      twin_[b] = a;
  }

  std::size_t slot(std::int32_t v) const {
    const double x = static_cast<double>(points_[v].x), y = static_cast<double>(points_[v].y);
    const double size = std::abs(x) + std::abs(y);
    const double turn = size > 0 ? (y < 0 ? 3 + x / size : 1 - x / size) / 4 : 0.0;
    return std::min(static_cast<std::size_t>(turn * hash_.size()), hash_.size() - 1);
  }

  void remember(std::int32_t v) { hash_[slot(v)] = v; }

  bool on_hull(std::int32_t v) const { return v != kNone && next_[v] != kNone; }

  bool sees(std::int32_t tip, std::int32_t a) const {
    return orient(points_[a], points_[next_[a]], points_[tip]) < 0;
  }

  // Triangles from `tip` to the edges of a visible chain of the hull, which they hide.
  void attach(const std::vector<std::int32_t>& chain, std::int32_t tip) {
    std::int32_t open = kNone;
    for (std::size_t i = chain.size() - 1; i-- > 0;) {
      const std::int32_t edge = static_cast<std::int32_t>(origin_.size());
      origin_.insert(origin_.end(), {chain[i + 1], chain[i], tip});
      twin_.insert(twin_.end(), 3, kNone);
      link(edge, hull_edge_[chain[i]]);
      link(edge + 2, open);
      open = edge + 1;
      pending_.push_back(edge);
    }
    link(open, kNone);
  }

  void insert(std::int32_t tip) {
    std::size_t at = slot(tip);
    while (!on_hull(hash_[at])) at = (at + 1) % hash_.size();
    std::int32_t first = previous_[hash_[at]];
    while (!sees(tip, first)) first = next_[first];
    while (sees(tip, previous_[first])) first = previous_[first];
    chain_.assign(1, first);
    std::int32_t last = first;
    do {
      last = next_[last];
      chain_.push_back(last);
    } while (sees(tip, last));
    attach(chain_, tip);
    for (std::size_t i = 1; i + 1 < chain_.size(); ++i) next_[chain_[i]] = kNone;
    join(first, tip);
    join(tip, last);
    remember(tip);
    remember(first);
    settle(tip);
  }

  // Flip the edges opposite to `tip` until every circle is empty.
  void settle(std::int32_t tip) {
    while (!pending_.empty()) {
      const std::int32_t e = pending_.back(), t = twin_[e];
      pending_.pop_back();
      if (t == kNone) continue;
      const std::int32_t far_edge = before(t);
      const std::int32_t a = origin_[e], b = origin_[t], d = origin_[far_edge];
      if (!in_circle(points_[a], points_[b], points_[tip], points_[d])) continue;
      const std::int32_t e_next = after(e), t_next = after(t);
      const std::int32_t beyond = twin_[t_next], side = twin_[e_next];
      origin_[e_next] = d;
      origin_[t_next] = tip;
      link(e, beyond);
      link(t, side);
      link(e_next, t_next);
      pending_.push_back(e);
      pending_.push_back(far_edge);
    }
  }

  std::vector<Point> points_;
  std::vector<std::int32_t> origin_, twin_;
  std::vector<std::int32_t> next_, previous_, hull_edge_;  // of the hull's vertices
  std::vector<std::int32_t> hash_;  // hull vertices by direction from the middle
  std::vector<std::int32_t> pending_, chain_;
};

}  // namespace

std::vector<std::array<std::int32_t, 3>> delaunay(const double* uv, std::size_t count) {
  return count == 0 ? std::vector<std::array<std::int32_t, 3>>()
                    : Sweep(sweep_order(uv, count)).run();
}

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// How often a triangle mesh, open or closed, goes round a point (Barill et al. 2018).
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "cell_hash.hpp"
#include "parallel.hpp"

namespace py = pybind11;

namespace {

using rops::fine::cross;
using rops::fine::dot;
using rops::fine::minus;
using rops::fine::Vec3;
template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

constexpr double kPi = 3.14159265358979323846;
// From so many of its radii on a cluster of triangles is a few moments.
constexpr double kFar = 3.0;
constexpr std::int32_t kLeaf = 8;

// Triangles in a tree of clusters; of each the sum of its areas' vectors, seen from afar.
class Winding {
 public:
  Winding(const double* vertices, const std::int32_t* faces, std::size_t count)
      : corners_(count) {
    std::vector<std::int32_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::vector<std::array<Vec3, 3>> given(count);
    for (std::size_t f = 0; f < count; ++f)
      for (int k = 0; k < 3; ++k)
        for (int e = 0; e < 3; ++e)
          given[f][k][e] = vertices[3 * static_cast<std::size_t>(faces[3 * f + k]) + e];
    nodes_.reserve(count / 2 + 1);
    if (count) build(given, order, 0, static_cast<std::int32_t>(count));
    for (std::size_t f = 0; f < count; ++f) corners_[f] = given[order[f]];
  }

  double at(const Vec3& point) const {
    if (nodes_.empty()) return 0;
    double angle = 0;
    std::array<std::int32_t, 128> waiting;
    int depth = 0;
    waiting[depth++] = 0;
    while (depth) {
      const Node& node = nodes_[waiting[--depth]];
      const Vec3 away = minus(node.centre, point);
      const double squared = dot(away, away);
      if (squared > kFar * kFar * node.radius * node.radius) {
        angle += seen_from_afar(node, away, squared);
      } else if (node.right < 0) {
        for (std::int32_t f = node.begin; f < node.end; ++f) angle += solid(corners_[f], point);
      } else {
        waiting[depth++] = node.right;
        waiting[depth++] = static_cast<std::int32_t>(&node - nodes_.data()) + 1;
      }
    }
    return angle / (4 * kPi);
  }

 private:
  struct Node {
    Vec3 centre, normal;
    std::array<Vec3, 3> lean;    // sum of area vectors times places about the centre
    std::array<Vec3, 3> extent;  // mean square of these places
    double radius;
    std::int32_t begin, end, right;  // the left child follows its parent
  };

  static Vec3 times(const std::array<Vec3, 3>& m, const Vec3& v) {
    return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
  }

  // Taylor series about the centre: three terms, the third as if the cluster were flat.
  static double seen_from_afar(const Node& node, const Vec3& away, double squared) {
    const double cubed = squared * std::sqrt(squared);
    const double front = dot(node.normal, away);
    const double lean = node.lean[0][0] + node.lean[1][1] + node.lean[2][2] -
                        3 * dot(away, times(node.lean, away)) / squared;
    const double trace = node.extent[0][0] + node.extent[1][1] + node.extent[2][2];
    const Vec3 stretched = times(node.extent, away);
    const double bend = 7.5 * front * dot(away, stretched) / (squared * squared) -
                        1.5 * (2 * dot(node.normal, stretched) + trace * front) / squared;
    return (front + lean + bend) / cubed;
  }

  static Vec3 middle(const std::array<Vec3, 3>& t) {
    return {(t[0][0] + t[1][0] + t[2][0]) / 3, (t[0][1] + t[1][1] + t[2][1]) / 3,
            (t[0][2] + t[1][2] + t[2][2]) / 3};
  }

  // Solid angle of a triangle, positive seen from its inner side (Van Oosterom, Strackee 1983).
  static double solid(const std::array<Vec3, 3>& t, const Vec3& point) {
    const Vec3 a = minus(t[0], point), b = minus(t[1], point), c = minus(t[2], point);
    const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
    return 2 * std::atan2(dot(a, cross(b, c)),
                          la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }

  std::int32_t build(const std::vector<std::array<Vec3, 3>>& given,
                     std::vector<std::int32_t>& order, std::int32_t begin, std::int32_t end) {
    const auto number = static_cast<std::int32_t>(nodes_.size());
    nodes_.push_back(cluster(given, order, begin, end));
    if (end - begin <= kLeaf) return number;
    Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
    for (std::int32_t i = begin; i < end; ++i) {
      const Vec3 m = middle(given[order[i]]);
      for (int e = 0; e < 3; ++e)
        low[e] = std::min(low[e], m[e]), high[e] = std::max(high[e], m[e]);
    }
    const Vec3 extent = minus(high, low);
    const auto axis = std::max_element(extent.begin(), extent.end()) - extent.begin();
    const std::int32_t half = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + half, order.begin() + end,
                     [&](std::int32_t i, std::int32_t j) {
                       const double a = middle(given[i])[axis], b = middle(given[j])[axis];
                       return a < b || (a == b && i < j);
                     });
    build(given, order, begin, half);
    const std::int32_t right = build(given, order, half, end);
    nodes_[number].right = right;
    return number;
  }

  static Node cluster(const std::vector<std::array<Vec3, 3>>& given,
                      const std::vector<std::int32_t>& order, std::int32_t begin,
                      std::int32_t end) {
    Node node{{0, 0, 0}, {0, 0, 0}, {}, {}, 0, begin, end, -1};
    double total = 0;
    for (std::int32_t i = begin; i < end; ++i) {
      const Vec3 vector = area(given[order[i]]), m = middle(given[order[i]]);
      const double size = std::sqrt(dot(vector, vector));
      total += size;
      for (int e = 0; e < 3; ++e) node.centre[e] += size * m[e], node.normal[e] += vector[e];
    }
    // Without an area it is seen from nowhere.
    for (double& e : node.centre) e /= total > 0 ? total : 1;
    for (std::int32_t i = begin; i < end; ++i) add_moments(given[order[i]], &node);
    for (Vec3& row : node.extent)
      for (double& e : row) e /= total > 0 ? total : 1;
    return node;
  }

  static Vec3 area(const std::array<Vec3, 3>& t) {
    const Vec3 twice = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    return {twice[0] / 2, twice[1] / 2, twice[2] / 2};
  }

  static void add_moments(const std::array<Vec3, 3>& t, Node* node) {
    const Vec3 vector = area(t), off = minus(middle(t), node->centre);
    const double size = std::sqrt(dot(vector, vector));
    const std::array<Vec3, 3> d = {minus(t[0], node->centre), minus(t[1], node->centre),
                                   minus(t[2], node->centre)};
    for (int e = 0; e < 3; ++e)
      for (int o = 0; o < 3; ++o) {
        node->lean[e][o] += vector[e] * off[o];
        node->extent[e][o] += size / 12 * (d[0][e] * d[0][o] + d[1][e] * d[1][o] +
                                           d[2][e] * d[2][o] + 9 * off[e] * off[o]);
      }
    for (const Vec3& corner : d)
      node->radius = std::max(node->radius, std::sqrt(dot(corner, corner)));
  }

  std::vector<std::array<Vec3, 3>> corners_;
  std::vector<Node> nodes_;
};

std::unique_ptr<Winding> make(const Array<double>& vertices, const Array<std::int32_t>& faces) {
  const double* v = vertices.data();
  const std::int32_t* f = faces.data();
  const std::size_t count = faces.shape(0);
  py::gil_scoped_release release;
  return std::make_unique<Winding>(v, f, count);
}

Array<double> at(const Winding& winding, const Array<double>& points, int threads) {
  const py::ssize_t count = points.shape(0);
  Array<double> turns(count);
  const double* p = points.data();
  double* out = turns.mutable_data();
  py::gil_scoped_release release;
  rops::parallel_with(count, 64, threads, [&] {
    return [&](std::size_t i) { out[i] = winding.at({p[3 * i], p[3 * i + 1], p[3 * i + 2]}); };
  });
  return turns;
}

}  // namespace

namespace rops {
void bind_winding(py::module_& m) {
  py::class_<Winding>(m, "_Winding").def(py::init(&make)).def("at", &at);
}
}  // namespace rops

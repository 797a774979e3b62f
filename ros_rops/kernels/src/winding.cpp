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
// From so many of its radii on a cluster of triangles is one dipole.
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
        angle += dot(node.normal, away) / (squared * std::sqrt(squared));
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
    double radius;
    std::int32_t begin, end, right;  // the left child follows its parent
  };

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
    Node node{{0, 0, 0}, {0, 0, 0}, 0, begin, end, -1};
    double total = 0;
    for (std::int32_t i = begin; i < end; ++i) {
      const auto& t = given[order[i]];
      const Vec3 twice = cross(minus(t[1], t[0]), minus(t[2], t[0])), m = middle(t);
      const double area = std::sqrt(dot(twice, twice)) / 2;
      total += area;
      for (int e = 0; e < 3; ++e)
        node.centre[e] += area * m[e], node.normal[e] += twice[e] / 2;
    }
    if (total > 0)
      for (double& e : node.centre) e /= total;
    else
      node.centre = given[order[begin]][0];
    for (std::int32_t i = begin; i < end; ++i)
      for (const Vec3& corner : given[order[i]]) {
        const Vec3 d = minus(corner, node.centre);
        node.radius = std::max(node.radius, std::sqrt(dot(d, d)));
      }
    return node;
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

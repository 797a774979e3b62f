// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
//
// Matches between the views of one shape and the normal equations of their joint registration
// (Guo et al. 2014, IV-B). Each ordered pair of views is one task with its own sums, so the
// result does not depend on the number of threads.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <vector>

#include "parallel.hpp"
#include "surface.hpp"

namespace py = pybind11;

namespace rops {
namespace fine {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;
using Flags = py::array_t<bool, py::array::c_style | py::array::forcecast>;

struct Pose {
  std::array<double, 9> r;
  Vec3 t;
  static Pose from(const double* m) {
    return {{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}, {m[3], m[7], m[11]}};
  }
  Vec3 turn(const Vec3& v) const {
    return {r[0] * v[0] + r[1] * v[1] + r[2] * v[2], r[3] * v[0] + r[4] * v[1] + r[5] * v[2],
            r[6] * v[0] + r[7] * v[1] + r[8] * v[2]};
  }
  Vec3 apply(const Vec3& v) const {
    const Vec3 u = turn(v);
    return {u[0] + t[0], u[1] + t[1], u[2] + t[2]};
  }
  Vec3 undo(const Vec3& v) const {
    const Vec3 u = minus(v, t);
    return {r[0] * u[0] + r[3] * u[1] + r[6] * u[2], r[1] * u[0] + r[4] * u[1] + r[7] * u[2],
            r[2] * u[0] + r[5] * u[1] + r[8] * u[2]};
  }
};

struct Rule {
  double radius;
  double min_cos;
};

// What one ordered pair of views adds: 6x6 (upper triangle), 6, and the statistics.
struct Sums {
  std::array<double, 21> a{};
  std::array<double, 6> b{};
  std::array<double, 5> s{};  // tried, within the radius, used, sum of |r|, sum of weights
};

class Surfaces {
 public:
  Surfaces(const std::vector<Doubles>& points, const std::vector<Doubles>& normals,
           const std::vector<Flags>& boundary, double cell, double support, int threads) {
    views_.resize(points.size());
    std::vector<const double*> xyz, given;
    std::vector<const bool*> rim;
    std::vector<std::size_t> sizes;
    for (std::size_t v = 0; v < points.size(); ++v) {
      xyz.push_back(points[v].data());
      given.push_back(normals[v].data());
      rim.push_back(boundary[v].data());
      sizes.push_back(points[v].shape(0));
    }
    py::gil_scoped_release release;
    parallel(views_.size(), threads, [&](std::size_t v) {
      views_[v] = std::make_unique<Surface>(xyz[v], sizes[v], cell);
    });
    constexpr std::size_t kBlock = 256;
    std::vector<std::pair<std::size_t, std::size_t>> blocks;
    for (std::size_t v = 0; v < views_.size(); ++v)
      for (std::size_t c = 0; c < views_[v]->hash.cell_count(); c += kBlock) blocks.push_back({v, c});
    parallel(blocks.size(), threads, [&](std::size_t t) {
      const auto [v, first] = blocks[t];
      const std::size_t last = std::min(first + kBlock, views_[v]->hash.cell_count());
      for (std::size_t c = first; c < last; ++c)
        views_[v]->fit_cell(c, support, given[v], rim[v]);
    });
  }

  py::tuple planes(std::size_t v) const {
    const Surface& s = *views_.at(v);
    const py::ssize_t n = s.hash.size();
    Doubles normals({n, py::ssize_t(3)}), thickness(n);
    Flags usable(n);
    for (py::ssize_t i = 0; i < n; ++i) {
      const auto k = s.rank[i];
      for (int a = 0; a < 3; ++a) normals.mutable_at(i, a) = s.normals[k][a];
      thickness.mutable_at(i) = s.thickness[k];
      usable.mutable_at(i) = s.usable[k];
    }
    return py::make_tuple(normals, thickness, usable);
  }

  // Indices of the samples of view i that are matched, and of their partners in view j.
  py::tuple match(std::size_t i, std::size_t j, const Indices& samples, const Doubles& pose_i,
                  const Doubles& pose_j, double radius, double min_cos) const {
    const Pose ti = Pose::from(pose_i.data()), tj = Pose::from(pose_j.data());
    std::vector<std::int32_t> from, to;
    const Surface &s = *views_.at(i), &t = *views_.at(j);
    for (py::ssize_t n = 0; n < samples.size(); ++n) {
      const auto k = s.rank[samples.data()[n]];
      bool near = false;
      const auto found = partner(s, t, k, ti, tj, {radius, min_cos}, &near);
      if (found < 0) continue;
      from.push_back(samples.data()[n]);
      to.push_back(t.hash.original(found));
    }
    return py::make_tuple(Indices(from.size(), from.data()), Indices(to.size(), to.data()));
  }

  py::tuple normal_equations(const Indices& pairs, const std::vector<Indices>& samples,
                             const Doubles& poses, const Doubles& centre, double radius,
                             double min_cos, double soft, int threads) const {
    const py::ssize_t count = pairs.shape(0);
    std::vector<Pose> placed;
    for (std::size_t v = 0; v < views_.size(); ++v)
      placed.push_back(Pose::from(poses.data() + 16 * v));
    std::vector<std::pair<const std::int32_t*, std::size_t>> chosen;
    for (const auto& s : samples) chosen.push_back({s.data(), s.size()});
    const Vec3 middle = {centre.data()[0], centre.data()[1], centre.data()[2]};
    std::vector<Sums> sums(count);
    {
      py::gil_scoped_release release;
      parallel(count, threads, [&](std::size_t p) {
        const std::size_t i = pairs.data()[2 * p], j = pairs.data()[2 * p + 1];
        sums[p] = add_pair(i, j, chosen[i], placed[i], placed[j], middle, {radius, min_cos}, soft);
      });
    }
    Doubles a({count, py::ssize_t(6), py::ssize_t(6)}), b({count, py::ssize_t(6)}),
        s({count, py::ssize_t(5)});
    for (py::ssize_t p = 0; p < count; ++p) {
      int e = 0;
      for (int x = 0; x < 6; ++x)
        for (int y = x; y < 6; ++y, ++e)
          a.mutable_at(p, x, y) = a.mutable_at(p, y, x) = sums[p].a[e];
      for (int x = 0; x < 6; ++x) b.mutable_at(p, x) = sums[p].b[x];
      for (int x = 0; x < 5; ++x) s.mutable_at(p, x) = sums[p].s[x];
    }
    return py::make_tuple(a, b, s);
  }

 private:
  static std::int32_t partner(const Surface& s, const Surface& t, std::int32_t k, const Pose& ti,
                              const Pose& tj, const Rule& rule, bool* near) {
    const auto [found, squared] = t.hash.nearest(tj.undo(ti.apply(s.hash.point(k))), rule.radius);
    *near = found >= 0;
    if (found < 0 || !t.usable[found]) return -1;
    const double cosine = dot(ti.turn(s.normals[k]), tj.turn(t.normals[found]));
    return cosine >= rule.min_cos ? found : -1;
  }

  // Symmetric point-to-plane distance r = n.(x - y), n between the two normals (Rusinkiewicz
  // 2019): unlike the plane of one side it is exact to second order on a curved surface. A
  // motion (w, v) of view i about the middle changes r by [(m - middle) x n, n].(w, v), m the
  // midpoint of x and y; the same motion of view j by the negative.
  Sums add_pair(std::size_t i, std::size_t j, const std::pair<const std::int32_t*, std::size_t>& chosen,
                const Pose& ti, const Pose& tj, const Vec3& middle, const Rule& rule,
                double soft) const {
    Sums sums;
    const Surface &s = *views_[i], &t = *views_[j];
    for (std::size_t n = 0; n < chosen.second; ++n) {
      const auto k = s.rank[chosen.first[n]];
      sums.s[0] += 1.0;
      bool near = false;
      const auto found = partner(s, t, k, ti, tj, rule, &near);
      sums.s[1] += near;
      if (found < 0) continue;
      const Vec3 x = ti.apply(s.hash.point(k)), y = tj.apply(t.hash.point(found));
      const Vec3 u = ti.turn(s.normals[k]), v = tj.turn(t.normals[found]);
      Vec3 normal = {u[0] + v[0], u[1] + v[1], u[2] + v[2]};
      const double length = std::sqrt(dot(normal, normal));
      for (double& e : normal) e /= length;
      const Vec3 d = minus(x, y);
      const double r = dot(normal, d);
      const double taper = std::max(0.0, 1.0 - dot(d, d) / (rule.radius * rule.radius));
      const double weight = taper * taper * soft / std::sqrt(r * r + soft * soft);
      const Vec3 arm = {0.5 * (x[0] + y[0]) - middle[0], 0.5 * (x[1] + y[1]) - middle[1],
                        0.5 * (x[2] + y[2]) - middle[2]};
      const Vec3 w = cross(arm, normal);
      const std::array<double, 6> row = {w[0], w[1], w[2], normal[0], normal[1], normal[2]};
      int e = 0;
      for (int a = 0; a < 6; ++a) {
        sums.b[a] += weight * r * row[a];
        for (int b = a; b < 6; ++b) sums.a[e++] += weight * row[a] * row[b];
      }
      sums.s[2] += 1.0;
      sums.s[3] += std::abs(r);
      sums.s[4] += weight;
    }
    return sums;
  }

  std::vector<std::unique_ptr<Surface>> views_;
};

}  // namespace
}  // namespace fine

void bind_fine(py::module_& m) {
  using fine::Doubles, fine::Flags, fine::Surfaces;
  py::class_<Surfaces>(m, "Surfaces")
      .def(py::init<const std::vector<Doubles>&, const std::vector<Doubles>&,
                    const std::vector<Flags>&, double, double, int>())
      .def("planes", &Surfaces::planes)
      .def("match", &Surfaces::match)
      .def("normal_equations", &Surfaces::normal_equations);
}

}  // namespace rops

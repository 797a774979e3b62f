// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Noise of an image of points evened out: every value from a plane fitted around its place.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "cells.hpp"
#include "parallel.hpp"

namespace py = pybind11;

namespace {
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

constexpr double kSteepest = 3.0;  // depth per distance across that still is one surface
constexpr double kSlack = 0.5;     // depth by which a surface may leave its plane
constexpr double kSigmas = 3.0;    // of the noise, likewise
constexpr double kCut = 2.0;       // radius of the support, in standard deviations of the weights
constexpr double kLeast = 1e-3;    // least determinant of a support that spans a plane
constexpr std::size_t kFewest = 6;

// Weighted moments of places about one of them: 1, u, v and their products.
struct Moments {
  double n = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;

  void add(double w, double du, double dv) {
    n += w, u += w * du, v += w * dv;
    uu += w * du * du, uv += w * du * dv, vv += w * dv * dv;
  }
  // Coefficients of the value at the place itself and of the two slopes; false without a plane.
  bool invert(std::array<double, 6>& inverse) const {
    const double a = uu * vv - uv * uv, b = uv * v - u * vv, c = u * uv - uu * v;
    const double det = n * a + u * b + v * c;
    if (!(det > kLeast * n * n * n)) return false;
    inverse = {a / det, b / det, c / det, (n * vv - v * v) / det, (u * v - n * uv) / det,
               (n * uu - u * u) / det};
    return true;
  }
};

struct Near {
  std::size_t index;
  double weight, du, dv;
};

// Fits around one place after another; keeps its lists between them.
class Smoother {
 public:
  Smoother(const double* places, const double* values, int columns, const rops::Cells& cells,
           double sigma, double noise)
      : places_(places), values_(values), columns_(columns), cells_(cells), sigma_(sigma),
        noise_(noise) {}

  // Values (columns) at place i; as they are where too little is around.
  void operator()(std::size_t i, double* out) {
    const double* own = values_ + columns_ * i;
    std::copy(own, own + columns_, out);
    gather(i);
    std::array<double, 3> plane;
    if (!fit(columns_ - 1, plane)) return;
    // Who lies off the plane belongs to another surface, or is a stray point.
    const double most = kSigmas * noise_ * std::sqrt(1 + plane[1] * plane[1] + plane[2] * plane[2])
                        + kSlack;
    near_.erase(std::remove_if(near_.begin(), near_.end(), [&](const Near& one) {
      return std::abs(values_[columns_ * one.index + columns_ - 1] - plane[0] -
                      plane[1] * one.du - plane[2] * one.dv) > most;
    }), near_.end());
    const bool stays = std::any_of(near_.begin(), near_.end(),
                                   [i](const Near& one) { return one.index == i; });
    if (!stays) return;
    for (int column = 0; column < columns_; ++column)
      if (fit(column, plane)) out[column] = plane[0];
  }

 private:
  void gather(std::size_t i) {
    near_.clear();
    const double* place = places_ + 3 * i;
    const double depth = values_[columns_ * i + columns_ - 1], radius = kCut * sigma_;
    cells_.for_each_run(place, radius, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const auto j = static_cast<std::size_t>(cells_.order[k]);
        const double du = places_[3 * j] - place[0], dv = places_[3 * j + 1] - place[1];
        const double square = du * du + dv * dv;
        if (square > radius * radius) continue;
        const double step = std::abs(values_[columns_ * j + columns_ - 1] - depth);
        if (step > kSteepest * std::sqrt(square) + kSigmas * std::sqrt(2.0) * noise_ + kSlack)
          continue;
        near_.push_back({j, std::exp(-0.5 * square / (sigma_ * sigma_)), du, dv});
      }
    });
  }

  bool fit(int column, std::array<double, 3>& plane) const {
    if (near_.size() < kFewest) return false;
    Moments moments;
    double c = 0, cu = 0, cv = 0;
    for (const Near& one : near_) {
      moments.add(one.weight, one.du, one.dv);
      const double value = one.weight * values_[columns_ * one.index + column];
      c += value, cu += value * one.du, cv += value * one.dv;
    }
    std::array<double, 6> m;
    if (!moments.invert(m)) return false;
    plane = {m[0] * c + m[1] * cu + m[2] * cv, m[1] * c + m[3] * cu + m[4] * cv,
             m[2] * c + m[4] * cu + m[5] * cv};
    return true;
  }

  const double *places_, *values_;
  int columns_;
  const rops::Cells& cells_;
  double sigma_, noise_;
  std::vector<Near> near_;
};

Doubles smooth(const Doubles& places, const Doubles& values, double sigma, double noise,
               int threads) {
  const auto n = static_cast<std::size_t>(values.shape(0));
  const int columns = static_cast<int>(values.shape(1));
  Doubles result({values.shape(0), values.shape(1)});
  const double *place = places.data(), *value = values.data();
  double* out = result.mutable_data();
  {
    py::gil_scoped_release release;
    std::vector<double> flat(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
      flat[3 * i] = place[2 * i];
      flat[3 * i + 1] = place[2 * i + 1];
    }
    std::vector<std::int32_t> all(n);
    std::iota(all.begin(), all.end(), 0);
    const rops::Cells cells(flat.data(), all, sigma);
    rops::parallel_with(n, 256, threads, [&] {
      return [&, smoother = Smoother(flat.data(), value, columns, cells, sigma, noise)](
                 std::size_t i) mutable { smoother(i, out + columns * i); };
    });
  }
  return result;
}
}  // namespace

namespace rops {
void bind_smoothing(py::module_& m) { m.def("smooth", &smooth); }
}  // namespace rops

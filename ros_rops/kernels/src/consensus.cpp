// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Overlapping views made one sheet: each point moves to where all agree; then some are chosen.
#include "consensus.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <numeric>

#include "cell_numbers.hpp"
#include "parallel.hpp"

namespace py = pybind11;

namespace {
using rops::consensus::Answer;
using rops::consensus::Field;
using rops::consensus::Sample;
using rops::consensus::Vec3;
template <class T>
using Array = py::array_t<T, py::array::c_style>;

constexpr std::size_t kChunk = 256;

std::vector<Sample> samples_of(const Array<float>& normals, const Array<float>& weights,
                               const Array<std::int32_t>& views,
                               const Array<std::uint8_t>& colors) {
  const auto n = static_cast<std::size_t>(weights.shape(0));
  std::vector<Sample> samples(n);
  const std::uint8_t* c = colors.shape(0) ? colors.data() : nullptr;
  for (std::size_t i = 0; i < n; ++i) {
    const float* normal = normals.data() + 3 * i;
    samples[i] = {{normal[0], normal[1], normal[2]}, weights.data()[i], views.data()[i], {}};
    for (int a = 0; c && a < 4; ++a) samples[i].color[a] = c[4 * i + a];
  }
  return samples;
}

struct Answers {
  explicit Answers(py::ssize_t n)
      : points({n, py::ssize_t{3}}), normals({n, py::ssize_t{3}}), colors({n, py::ssize_t{3}}),
        weights(n), views(n), directions(n), support(n) {}

  void put(std::size_t i, const Answer& answer) {
    for (int a = 0; a < 3; ++a) {
      points.mutable_data()[3 * i + a] = answer.point[a];
      normals.mutable_data()[3 * i + a] = static_cast<float>(answer.normal[a]);
      colors.mutable_data()[3 * i + a] = answer.color[a];
    }
    weights.mutable_data()[i] = static_cast<float>(answer.weight);
    views.mutable_data()[i] = answer.view;
    directions.mutable_data()[i] = answer.directions;
    support.mutable_data()[i] = answer.support;
  }
  py::tuple tuple() const {
    return py::make_tuple(points, normals, weights, views, directions, support, colors);
  }

  Array<double> points;
  Array<float> normals;
  Array<std::uint8_t> colors;
  Array<float> weights;
  Array<std::int32_t> views, directions, support;
};

// For each of `targets` (indices of points) what all points around it agree on.
py::tuple agree(const Array<double>& points, const Array<float>& normals,
                const Array<float>& weights, const Array<std::int32_t>& views,
                const Array<std::uint8_t>& colors, const Array<std::int32_t>& targets,
                int view_count, double radius, double near, double paint,
                bool move, int threads) {
  Answers answers(targets.shape(0));
  const auto count = static_cast<std::size_t>(targets.shape(0));
  const std::int32_t* target = targets.data();
  {
    py::gil_scoped_release release;
    const Field field(points.data(), static_cast<std::size_t>(points.shape(0)),
                      samples_of(normals, weights, views, colors), {radius, near, paint});
    // In the order of cells, so that what one target read is there for the next.
    std::vector<std::int32_t> place(points.shape(0));
    for (std::size_t k = 0; k < field.hash().size(); ++k)
      place[field.hash().original(k)] = static_cast<std::int32_t>(k);
    std::vector<std::int32_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
      return place[target[a]] != place[target[b]] ? place[target[a]] < place[target[b]] : a < b;
    });
    rops::parallel_with(count, kChunk, threads, [&] {
      return [&, scratch = rops::consensus::Scratch(view_count)](std::size_t k) mutable {
        const std::size_t i = order[k], at = target[i];
        const double* p = points.data() + 3 * at;
        const float* n = normals.data() + 3 * at;
        answers.put(i, field.ask({p[0], p[1], p[2]}, {n[0], n[1], n[2]}, move, scratch));
      };
    });
  }
  return answers.tuple();
}

// Whether one of the points `taken` lies nearer than `spacing` to point `k`, facing the same way.
bool crowded(const rops::fine::CellHash& hash, const std::vector<std::uint8_t>& taken,
             std::int32_t k, const float* normals, double spacing) {
  const Vec3& p = hash.point(k);
  const float* n = normals + 3 * static_cast<std::size_t>(hash.original(k));
  const auto low = hash.cell_of({p[0] - spacing, p[1] - spacing, p[2] - spacing});
  const auto high = hash.cell_of({p[0] + spacing, p[1] + spacing, p[2] + spacing});
  for (std::int64_t x = low[0]; x <= high[0]; ++x)
    for (std::int64_t y = low[1]; y <= high[1]; ++y)
      for (std::int64_t z = low[2]; z <= high[2]; ++z) {
        const auto [begin, end] = hash.range({x, y, z});
        for (std::int32_t other = begin; other < end; ++other) {
          if (!taken[other]) continue;
          const Vec3 apart = rops::fine::minus(hash.point(other), p);
          const float* m = normals + 3 * static_cast<std::size_t>(hash.original(other));
          if (rops::fine::dot(apart, apart) < spacing * spacing &&
              n[0] * m[0] + n[1] * m[1] + n[2] * m[2] >= 0)
            return true;
        }
      }
  return false;
}

// Of points on a surface, those chosen so that none lies nearer than `spacing` to another that
// faces the same way; those that come first in `order` first.
Array<std::int32_t> spread(const Array<double>& points, const Array<float>& normals,
                           const Array<std::int32_t>& order, double spacing) {
  const auto n = static_cast<std::size_t>(points.shape(0));
  std::vector<std::int32_t> chosen;
  {
    py::gil_scoped_release release;
    const rops::fine::CellHash hash(points.data(), n, spacing);
    std::vector<std::int32_t> place(n);
    for (std::size_t k = 0; k < n; ++k) place[hash.original(k)] = static_cast<std::int32_t>(k);
    std::vector<std::uint8_t> taken(n, 0);
    for (std::size_t k = 0; k < n; ++k) {
      const std::int32_t i = order.data()[k];
      if (crowded(hash, taken, place[i], normals.data(), spacing)) continue;
      taken[place[i]] = 1;
      chosen.push_back(i);
    }
    std::sort(chosen.begin(), chosen.end());
  }
  Array<std::int32_t> result(static_cast<py::ssize_t>(chosen.size()));
  std::copy(chosen.begin(), chosen.end(), result.mutable_data());
  return result;
}

// How far each vertex of a mesh lies below the mean of those that its faces join it with, along
// its normal; NaN without faces.
Array<float> dents(const Array<double>& vertices, const Array<std::int32_t>& faces,
                   const Array<double>& normals) {
  const auto n = static_cast<std::size_t>(vertices.shape(0));
  Array<float> result(static_cast<py::ssize_t>(n));
  float* out = result.mutable_data();
  const double *p = vertices.data(), *q = normals.data();
  const std::int32_t* corner = faces.data();
  const auto count = static_cast<std::size_t>(faces.shape(0));
  py::gil_scoped_release release;
  std::vector<std::array<double, 4>> sums(n);
  for (std::size_t f = 0; f < count; ++f, corner += 3)
    for (int k = 0; k < 3; ++k) {
      std::array<double, 4>& sum = sums[corner[k]];
      const double* a = p + 3 * static_cast<std::size_t>(corner[(k + 1) % 3]);
      const double* b = p + 3 * static_cast<std::size_t>(corner[(k + 2) % 3]);
      for (int axis = 0; axis < 3; ++axis) sum[axis] += a[axis] + b[axis];
      sum[3] += 2;
    }
  for (std::size_t i = 0; i < n; ++i) {
    double height = 0;
    for (int axis = 0; axis < 3; ++axis)
      height += (sums[i][axis] / sums[i][3] - p[3 * i + axis]) * q[3 * i + axis];
    out[i] = static_cast<float>(height);
  }
  return result;
}

// Of each vertex, how many hang together with it by faces; 0 without a face.
Array<std::int32_t> piece_sizes(const Array<std::int32_t>& faces, py::ssize_t n) {
  Array<std::int32_t> result(n);
  std::int32_t* out = result.mutable_data();
  const std::int32_t* corner = faces.data();
  const auto count = static_cast<std::size_t>(faces.shape(0));
  py::gil_scoped_release release;
  std::vector<std::int32_t> root(n), size(n, 0);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](std::int32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<std::uint8_t> faced(n, 0);
  for (std::size_t f = 0; f < count; ++f, corner += 3)
    for (int k = 0; k < 3; ++k) {
      faced[corner[k]] = 1;
      const std::int32_t a = find(corner[0]), b = find(corner[k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  for (py::ssize_t i = 0; i < n; ++i) size[find(i)] += faced[i];
  for (py::ssize_t i = 0; i < n; ++i) out[i] = size[find(i)];
  return result;
}

// The heaviest point of each cubic cell and each of the six ways to face.
Array<std::int32_t> heaviest(const Array<double>& points, const Array<float>& normals,
                             const Array<float>& weights, double side) {
  const auto n = static_cast<std::size_t>(points.shape(0));
  std::vector<std::int32_t> best;
  {
    py::gil_scoped_release release;
    const double* p = points.data();
    rops::CellNumbers cells(p, n, side);
    for (std::size_t i = 0; i < n; ++i) {
      const float* q = normals.data() + 3 * i;
      int way = 0;
      for (int a = 1; a < 3; ++a)
        if (std::abs(q[a]) > std::abs(q[way])) way = a;
      way += q[way] < 0 ? 3 : 0;
      const std::size_t cell = 6 * cells.of(cells.key_of(p + 3 * i)) + way;
      if (cell >= best.size()) best.resize(6 * cells.count(), -1);
      std::int32_t& at = best[cell];
      if (at < 0 || weights.data()[i] > weights.data()[at]) at = static_cast<std::int32_t>(i);
    }
    best.erase(std::remove(best.begin(), best.end(), -1), best.end());
    std::sort(best.begin(), best.end());
  }
  Array<std::int32_t> result(static_cast<py::ssize_t>(best.size()));
  std::copy(best.begin(), best.end(), result.mutable_data());
  return result;
}
}  // namespace

namespace rops {
void bind_consensus(py::module_& m) {
  m.def("agree", &agree);
  m.def("spread", &spread);
  m.def("heaviest", &heaviest);
  m.def("dents", &dents);
  m.def("piece_sizes", &piece_sizes);
}
}  // namespace rops

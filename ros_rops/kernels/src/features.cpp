// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Local reference frames and RoPS of all keypoints in one pass; thinning of keypoints.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "cells.hpp"
#include "descriptor.hpp"
#include "frame.hpp"
#include "parallel.hpp"
#include "support.hpp"

namespace py = pybind11;

namespace {
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ints = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;
using Floats = py::array_t<float, py::array::c_style>;

constexpr double kCellsPerRadius = 3;

struct Job {
  const double* vertices;
  const double* normals;
  const std::int32_t* keypoints;
  std::size_t count;
  double radius, normal_radius;  // normal_radius 0: the covariance's own frame
  bool touching;
  const double* given;  // frames handed in, or none
  double* frames;
  double* eigenvalues;
  float* descriptors;  // or none
};

void clear(const Job& job, std::size_t k, std::size_t length) {
  std::fill_n(job.frames + 9 * k, 9, 0.0);
  std::fill_n(job.eigenvalues + 3 * k, 3, 0.0);
  if (job.descriptors) std::fill_n(job.descriptors + length * k, length, 0.0f);
}

bool find_frame(const Job& job, const rops::SortedMesh& mesh, std::size_t k,
                rops::Support& support, rops::Mat3& frame) {
  const std::size_t vertex = job.keypoints[k];
  if (job.given) {
    for (int i = 0; i < 9; ++i) frame[i / 3][i % 3] = job.given[9 * k + i];
    return true;
  }
  const auto sum = rops::covariance(mesh, job.vertices + 3 * vertex, job.radius, job.touching,
                                    support);
  const rops::Eigen3 axes = rops::eigen(sum.matrix);
  if (!(axes.values[0] > 0)) return false;
  std::copy(axes.values.begin(), axes.values.end(), job.eigenvalues + 3 * k);
  frame = rops::covariance_frame(axes, sum.moment);
  if (job.normal_radius == 0) return true;
  const double* n = job.normals + 3 * vertex;
  return rops::normal_frame(support, job.radius, job.normal_radius, {n[0], n[1], n[2]}, frame);
}

void run_one(const Job& job, const rops::SortedMesh& mesh, const rops::Convention& convention,
             std::size_t k, rops::Support& support) {
  clear(job, k, convention.length());
  rops::Mat3 frame;
  rops::gather(mesh, job.vertices + 3 * static_cast<std::size_t>(job.keypoints[k]), job.radius,
               support);
  if (!find_frame(job, mesh, k, support, frame)) return;
  for (int i = 0; i < 9; ++i) job.frames[9 * k + i] = frame[i / 3][i % 3];
  if (job.descriptors)
    rops::describe(convention, frame, support, job.descriptors + convention.length() * k);
}

// Every keypoint is computed alone, so neither threads nor order can change a result.
void run_all(const Job& job, const rops::SortedMesh& mesh, const rops::Convention& convention,
             int threads) {
  std::vector<std::size_t> turn(job.count);
  std::iota(turn.begin(), turn.end(), std::size_t{0});
  std::sort(turn.begin(), turn.end(), [&](std::size_t a, std::size_t b) {
    return mesh.rank[job.keypoints[a]] < mesh.rank[job.keypoints[b]];
  });
  constexpr std::size_t kChunk = 8;
  rops::parallel_with(job.count, kChunk, threads, [&] {
    return [&, support = rops::Support(mesh.cells.order.size(), mesh.faces.size())](
               std::size_t i) mutable { run_one(job, mesh, convention, turn[i], support); };
  });
}

rops::Convention convention_of(const Ints& axes, const Doubles& angles, int bins,
                               double log_unit, bool skip_keypoint, bool absolute_norm) {
  rops::Convention convention{{}, bins, log_unit, skip_keypoint, absolute_norm};
  for (py::ssize_t i = 0; i < axes.size(); ++i)
    convention.rotations.push_back(
        {axes.data()[i], std::cos(angles.data()[i]), std::sin(angles.data()[i])});
  return convention;
}

py::tuple features(const Doubles& vertices, const Ints& faces, const Doubles& normals,
                   const Ints& keypoints, double radius, double normal_radius, bool touching,
                   bool loose, const py::object& frames, const Ints& axes, const Doubles& angles, int bins,
                   double log_unit, bool skip_keypoint, bool absolute_norm, int threads) {
  const auto convention =
      convention_of(axes, angles, bins, log_unit, skip_keypoint, absolute_norm);
  const py::ssize_t count = keypoints.shape(0);
  const py::ssize_t length = static_cast<py::ssize_t>(convention.length());
  Doubles lrfs({count, py::ssize_t{3}, py::ssize_t{3}}), values({count, py::ssize_t{3}});
  Floats descriptors({count, length});
  const Doubles given = frames.is_none() ? Doubles() : Doubles(frames);
  const Job job{vertices.data(), normals.data(), keypoints.data(),
                static_cast<std::size_t>(count), radius, normal_radius, touching,
                frames.is_none() ? nullptr : given.data(), lrfs.mutable_data(),
                values.mutable_data(), length ? descriptors.mutable_data() : nullptr};
  const std::size_t vertex_count = vertices.shape(0), face_count = faces.shape(0);
  const std::int32_t* triangles = faces.data();
  {
    py::gil_scoped_release release;
    const rops::SortedMesh mesh(job.vertices, vertex_count, triangles, face_count,
                                radius / kCellsPerRadius, touching, loose);
    run_all(job, mesh, convention, threads);
  }
  return py::make_tuple(lrfs, values, descriptors);
}

// Positions in `wanted` kept: each farther than `spacing` from those kept before it.
Ints thin(const Doubles& points, const Ints& wanted, double spacing) {
  const double* p = points.data();
  const std::vector<std::int32_t> chosen(wanted.data(), wanted.data() + wanted.size());
  std::vector<std::int32_t> kept;
  {
    py::gil_scoped_release release;
    const rops::Cells cells(p, chosen, spacing);
    std::vector<char> covered(points.shape(0), 0);
    for (const std::int32_t i : chosen) {
      if (covered[i]) continue;
      kept.push_back(i);
      cells.for_each_run(p + 3 * i, spacing, [&](std::size_t begin, std::size_t end) {
        for (std::size_t at = begin; at < end; ++at) {
          const std::int32_t j = cells.order[at];
          double square = 0;
          for (int k = 0; k < 3; ++k)
            square += (p[3 * j + k] - p[3 * i + k]) * (p[3 * j + k] - p[3 * i + k]);
          covered[j] |= square < spacing * spacing;
        }
      });
      covered[i] = 1;
    }
  }
  return Ints(static_cast<py::ssize_t>(kept.size()), kept.data());
}
}  // namespace

namespace rops {
void bind_features(py::module_& m) {
  m.def("features", &features);
  m.def("thin", &thin);
}
}  // namespace rops

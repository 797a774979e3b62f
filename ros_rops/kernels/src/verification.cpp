// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Python's way to evidence and to the scoring, refining and examining of poses.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>

#include "parallel.hpp"
#include "verification.hpp"

namespace py = pybind11;

namespace rops {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Flags = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;
using Shape = std::vector<py::ssize_t>;
using Triple = std::array<float, 3>;

Float3 to_float3(const Triple& v) { return {v[0], v[1], v[2]}; }

std::vector<Oriented> to_oriented(const Doubles& points, const Doubles& normals) {
  std::vector<Oriented> out(points.shape(0));
  const double *p = points.data(), *n = normals.data();
  for (std::size_t i = 0; i < out.size(); ++i, p += 3, n += 3) {
    out[i].point = {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
    out[i].normal = {static_cast<float>(n[0]), static_cast<float>(n[1]),
                     static_cast<float>(n[2])};
  }
  return out;
}

std::shared_ptr<Evidence> make_evidence(const Doubles& points, const Doubles& normals,
                                        const Flags& rim, float cell, int reach, int sensor,
                                        const Triple& origin, const Triple& direction,
                                        const Doubles& beyond) {
  const std::vector<Oriented> vertices = to_oriented(points, normals);
  const std::vector<std::uint8_t> edge(rim.data(), rim.data() + rim.size());
  std::vector<Float3> past(beyond.shape(0));
  for (std::size_t i = 0; i < past.size(); ++i)
    past[i] = {static_cast<float>(beyond.data()[3 * i]),
               static_cast<float>(beyond.data()[3 * i + 1]),
               static_cast<float>(beyond.data()[3 * i + 2])};
  py::gil_scoped_release release;
  auto out = std::make_shared<Evidence>();
  out->field = build_field(vertices, edge, cell, reach, true);
  if (sensor)
    out->rasters.push_back(
        build_raster(vertices, past, sensor == 2, to_float3(origin), to_float3(direction), cell));
  draw_samples(*out);
  return out;
}

// Points, normals and rim of the vertices, in the order of the field.
py::tuple vertices(const Evidence& evidence) {
  const Field& field = evidence.field;
  const auto count = static_cast<py::ssize_t>(field.vertices.size());
  Doubles points(Shape{count, 3}), normals(Shape{count, 3});
  Flags rim(Shape{count});
  double *p = points.mutable_data(), *n = normals.mutable_data();
  for (const Oriented& v : field.vertices) {
    *p++ = v.point.x, *p++ = v.point.y, *p++ = v.point.z;
    *n++ = v.normal.x, *n++ = v.normal.y, *n++ = v.normal.z;
  }
  std::copy(field.rim.begin(), field.rim.end(), rim.mutable_data());
  return py::make_tuple(points, normals, rim);
}

Doubles score(const Evidence& source, const Evidence& target, const Doubles& poses, int samples,
              float tau, float front, float facing, int threads) {
  const std::size_t count = poses.shape(0);
  Doubles result(Shape{static_cast<py::ssize_t>(count), 2, 4});
  const double* in = poses.data();
  double* out = result.mutable_data();
  const ScoreSettings settings{samples, tau, front, facing};
  py::gil_scoped_release release;
  parallel(count, threads, [&](std::size_t h) {
    const Rigid T = to_rigid(in + 16 * h);
    const Score there = score_one_way(source, target, T, settings);
    const Score back = score_one_way(target, source, T.inverse(), settings);
    double* row = out + 8 * h;
    for (const Score& s : {there, back}) {
      *row++ = s.overlap, *row++ = s.front, *row++ = s.empty, *row++ = s.disagree;
    }
  });
  return result;
}

void write_pose(const Pose& pose, double* out) {
  const double bottom[4] = {0, 0, 0, 1};
  std::copy(pose.m, pose.m + 12, out);
  std::copy(bottom, bottom + 4, out + 12);
}

Pose read_pose(const double* in) {
  Pose pose;
  std::copy(in, in + 12, pose.m);
  return pose;
}

Doubles refine(const Evidence& source, const Evidence& target, const Doubles& poses, int samples,
               const Doubles& radii, float agree, int threads) {
  const std::size_t count = poses.shape(0);
  Doubles moved(Shape{static_cast<py::ssize_t>(count), 4, 4});
  const double* in = poses.data();
  double* out = moved.mutable_data();
  const RefineSettings settings{samples, agree};
  py::gil_scoped_release release;
  parallel(count, threads, [&](std::size_t h) {
    Pose pose = read_pose(in + 16 * h);
    refine_pose(source, target, pose, radii.data(), radii.size(), settings);
    write_pose(pose, out + 16 * h);
  });
  return moved;
}

void write_exam(const Exam* exams, double* numbers, double* hessian) {
  NormalEquations both = exams[0].equations;
  both.add(exams[1].equations);
  for (int r = 0, k = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c, ++k) hessian[6 * r + c] = hessian[6 * c + r] = both.a[k];
  for (int side = 0; side < 2; ++side) {
    const Exam& e = exams[side];
    *numbers++ = e.count, *numbers++ = e.matched, *numbers++ = e.equations.absolute;
    *numbers++ = e.front, *numbers++ = e.empty, *numbers++ = e.disagree;
  }
}

py::tuple examine(const Evidence& source, const Evidence& target, const Doubles& poses, int rounds,
                  int samples, float radius, float front, float facing, int threads) {
  const auto count = poses.shape(0);
  Doubles moved(Shape{count, 4, 4}), numbers(Shape{count, 2, 6}), hessians(Shape{count, 6, 6});
  const double* in = poses.data();
  double *to = moved.mutable_data(), *row = numbers.mutable_data(),
         *hessian = hessians.mutable_data();
  const ExamSettings settings{samples, radius, front, facing};
  {
    py::gil_scoped_release release;
    parallel(count, threads, [&](std::size_t h) {
      Pose pose = read_pose(in + 16 * h);
      Exam exams[2];
      examine_pose(source, target, pose, rounds, settings, exams[0], exams[1]);
      write_pose(pose, to + 16 * h);
      write_exam(exams, row + 12 * h, hessian + 36 * h);
    });
  }
  return py::make_tuple(moved, numbers, hessians);
}

// Poses in order of preference, those left out that lie close to one taken before.
py::array_t<std::int32_t> distinct(const Doubles& poses, float cosine, float distance,
                                   std::size_t most) {
  std::vector<std::int32_t> kept;
  std::vector<Rigid> taken;
  const float least_trace = 1 + 2 * cosine, distance2 = distance * distance;
  for (py::ssize_t h = 0; h < poses.shape(0) && kept.size() < most; ++h) {
    const Rigid T = to_rigid(poses.data() + 16 * h);
    bool fresh = true;
    for (std::size_t k = 0; k < taken.size() && fresh; ++k) {
      const Float3 gap = taken[k].t - T.t;
      if (dot(gap, gap) > distance2) continue;
      float trace = 0;
      for (int i = 0; i < 9; ++i) trace += taken[k].r[i] * T.r[i];
      fresh = trace < least_trace;
    }
    if (!fresh) continue;
    kept.push_back(static_cast<std::int32_t>(h));
    taken.push_back(T);
  }
  py::array_t<std::int32_t> out(static_cast<py::ssize_t>(kept.size()));
  std::copy(kept.begin(), kept.end(), out.mutable_data());
  return out;
}

}  // namespace

void bind_verification(py::module_& m) {
  py::class_<Evidence, std::shared_ptr<Evidence>>(m, "_Evidence")
      .def(py::init(&make_evidence))
      .def("grown",
           [](const Evidence& shape, const Evidence& view, const Doubles& T, float near,
              int reach, int threads) {
             const Rigid pose = to_rigid(T.data());
             py::gil_scoped_release release;
             return std::make_shared<Evidence>(grow(shape, view, pose, near, reach, threads));
           })
      .def("vertices", &vertices)
      .def_property_readonly("sample_count", [](const Evidence& e) { return e.samples.size(); })
      .def_property_readonly("vertex_count",
                             [](const Evidence& e) { return e.field.vertices.size(); })
      .def_property_readonly("noise", [](const Evidence& e) { return e.field.noise; })
      .def_property_readonly("sensor_count", [](const Evidence& e) { return e.rasters.size(); });
  m.def("_score", &score);
  m.def("_refine", &refine);
  m.def("_examine", &examine);
  m.def("_distinct", &distinct);
}

}  // namespace rops

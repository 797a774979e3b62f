// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Bindings of the volume.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "volume.hpp"

namespace py = pybind11;

namespace {

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;
using rops::Volume;

bool touch(Volume& volume, const Array<double>& vertices, const Array<std::int32_t>& faces,
           double longest, std::size_t most) {
  const double* v = vertices.data();
  const std::int32_t* f = faces.data();
  const std::size_t count = faces.shape(0);
  py::gil_scoped_release release;
  return volume.touch(v, f, count, longest, most);
}

void integrate(Volume& volume, const rops::sight::View& view, int threads) {
  py::gil_scoped_release release;
  volume.integrate(view, threads);
}

Array<float> distances(const Volume& volume, int threads) {
  const py::ssize_t count = volume.bricks().size(), side = Volume::kSide;
  Array<float> values({count, side, side, side});
  float* out = values.mutable_data();
  py::gil_scoped_release release;
  volume.distances(out, threads);
  return values;
}

Array<std::int32_t> bricks(const Volume& volume) {
  const py::ssize_t count = volume.bricks().size();
  Array<std::int32_t> numbers({count, py::ssize_t{3}});
  std::int32_t* out = numbers.mutable_data();
  for (const auto& brick : volume.bricks()) out = std::copy(brick.begin(), brick.end(), out);
  return numbers;
}

}  // namespace

namespace rops {
void bind_volume(py::module_& m) {
  py::class_<Volume>(m, "_Volume")
      .def(py::init<const Vec3&, double, double>())
      .def("touch", &touch)
      .def("integrate", &integrate)
      .def("distances", &distances)
      .def("bricks", &bricks);
}
}  // namespace rops

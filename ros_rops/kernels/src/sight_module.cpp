// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Bindings of the lines of sight.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "parallel.hpp"
#include "sight.hpp"

namespace py = pybind11;

namespace {

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;
using rops::sight::View;

std::unique_ptr<View> make_view(const Array<double>& vertices, const Array<std::int32_t>& faces,
                                const Array<float>& weights, int kind, rops::Vec3 origin,
                                rops::Vec3 direction, const Array<double>& T_object_view,
                                const Array<float>& beyond) {
  const rops::sight::Scan scan{
      vertices.data(), static_cast<std::size_t>(vertices.shape(0)), faces.data(),
      static_cast<std::size_t>(faces.shape(0)), weights.data(),
      static_cast<rops::sight::Kind>(kind), origin, direction, T_object_view.data(),
      beyond.data(), static_cast<std::size_t>(beyond.shape(0))};
  py::gil_scoped_release release;
  return std::make_unique<View>(scan);
}

py::tuple look(const View& view, const Array<double>& points, double reach, int threads) {
  const py::ssize_t count = points.shape(0);
  py::array_t<float> distance(count), weight(count), cosine(count);
  const double* p = points.data();
  float *d = distance.mutable_data(), *w = weight.mutable_data(), *c = cosine.mutable_data();
  {
    py::gil_scoped_release release;
    rops::parallel_with(count, 1024, threads, [&] {
      return [&](std::size_t i) {
        const auto glance = view.look({p[3 * i], p[3 * i + 1], p[3 * i + 2]}, reach);
        d[i] = glance.distance, w[i] = glance.weight, c[i] = glance.cosine;
      };
    });
  }
  return py::make_tuple(distance, weight, cosine);
}

}  // namespace

namespace rops {
void bind_sight(py::module_& m) {
  py::class_<View>(m, "_Sight")
      .def(py::init(&make_view))
      .def("look", &look);
}
}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/pybind11.h>

namespace rops {
// One function per source file binds what that file offers.
void bind_matching(pybind11::module_& m);
void bind_mesh(pybind11::module_& m);
void bind_features(pybind11::module_& m);
void bind_verification(pybind11::module_& m);
void bind_fine(pybind11::module_& m);
void bind_points(pybind11::module_& m);
void bind_sight(pybind11::module_& m);
void bind_volume(pybind11::module_& m);
void bind_consensus(pybind11::module_& m);
void bind_winding(pybind11::module_& m);
void bind_inliers(pybind11::module_& m);
void bind_smoothing(pybind11::module_& m);
}  // namespace rops

PYBIND11_MODULE(_kernels, m) {
  m.doc() = "Compiled loops; use the typed faces in ros_rops.kernels instead.";
  rops::bind_matching(m);
  rops::bind_mesh(m);
  rops::bind_features(m);
  rops::bind_verification(m);
  rops::bind_fine(m);
  rops::bind_points(m);
  rops::bind_sight(m);
  rops::bind_volume(m);
  rops::bind_consensus(m);
  rops::bind_winding(m);
  rops::bind_inliers(m);
  rops::bind_smoothing(m);
}

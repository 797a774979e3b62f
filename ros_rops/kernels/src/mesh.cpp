// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/pybind11.h>

namespace rops {
void bind_mesh(pybind11::module_&) {}
}  // namespace rops

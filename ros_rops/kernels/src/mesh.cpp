// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Range view to triangle mesh: candidate triangles of a grid, the edge and grazing tests,
// normals, boundary and resolution.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "delaunay.hpp"

namespace py = pybind11;

namespace {
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ints = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;
using Face = std::array<std::int32_t, 3>;
using Vec = std::array<double, 3>;

// A triangle flatter than this, of its longest edge, is a line: its normal means nothing.
constexpr double kSliver = 1e-6;

struct Edge {
  std::int32_t low, high;
  int faces;
};

Vec difference(const double* a, const double* b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double length(const Vec& a) { return std::sqrt(dot(a, a)); }

// The part of `edge` across the ray: how far apart the sensor sees its ends.
double lateral_length(const Vec& edge, const double* ray) {
  return length(cross(edge, {ray[0], ray[1], ray[2]}));
}

// Each edge once, in the order of its vertices, with the number of faces that share it.
std::vector<Edge> unique_edges(const std::vector<Face>& faces, std::size_t vertices) {
  std::vector<std::size_t> start(vertices + 1, 0);
  for (const Face& f : faces)
    for (int k = 0; k < 3; ++k) ++start[std::min(f[k], f[(k + 1) % 3]) + 1];
  for (std::size_t v = 0; v < vertices; ++v) start[v + 1] += start[v];
  std::vector<std::int32_t> ends(3 * faces.size());
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  for (const Face& f : faces)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(f[k], f[(k + 1) % 3]);
      ends[next[low]++] = high;
    }
  std::vector<Edge> edges;
  edges.reserve(2 * faces.size());
  for (std::size_t v = 0; v < vertices; ++v) {
    std::sort(ends.begin() + start[v], ends.begin() + start[v + 1]);
    for (std::size_t i = start[v]; i < start[v + 1]; ++i) {
      if (i > start[v] && ends[i] == ends[i - 1])
        ++edges.back().faces;
      else
        edges.push_back({static_cast<std::int32_t>(v), ends[i], 1});
    }
  }
  return edges;
}

// What the sensor's spacing is around each vertex: the lower median over its candidate edges
// of their lateral length. Depth steps do not enter it, long edges over holes are outvoted.
std::vector<double> expected_spacing(const double* points, const double* rays,
                                     const std::vector<Edge>& edges, std::size_t vertices) {
  std::vector<std::size_t> start(vertices + 1, 0);
  for (const Edge& e : edges) ++start[e.low + 1], ++start[e.high + 1];
  for (std::size_t v = 0; v < vertices; ++v) start[v + 1] += start[v];
  std::vector<double> lengths(2 * edges.size());
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  for (const Edge& e : edges) {
    const Vec step = difference(points + 3 * e.high, points + 3 * e.low);
    const double lateral = lateral_length(step, rays + 3 * e.low);
    lengths[next[e.low]++] = lateral;
    lengths[next[e.high]++] = lateral;
  }
  std::vector<double> spacing(vertices, 0.0);
  for (std::size_t v = 0; v < vertices; ++v) {
    const std::size_t degree = start[v + 1] - start[v];
    if (degree == 0) continue;
    const auto middle = lengths.begin() + start[v] + (degree - 1) / 2;
    std::nth_element(lengths.begin() + start[v], middle, lengths.begin() + start[v + 1]);
    spacing[v] = *middle;
  }
  return spacing;
}

// Turn `face` towards the sensor; false when it is too long, grazing or without area.
bool accept(Face& face, const double* points, const double* rays,
            const std::vector<double>& spacing, double edge_factor, double least_cosine) {
  const double expected = (spacing[face[0]] + spacing[face[1]] + spacing[face[2]]) / 3;
  const Vec a = difference(points + 3 * face[1], points + 3 * face[0]);
  const Vec b = difference(points + 3 * face[2], points + 3 * face[0]);
  const Vec c = difference(points + 3 * face[2], points + 3 * face[1]);
  const double longest = std::max({length(a), length(b), length(c)});
  const Vec normal = cross(a, b);
  const double area = length(normal);
  if (!(longest <= edge_factor * expected) || !(area > kSliver * longest * longest)) return false;
  const double* ray = rays + 3 * face[0];
  const double cosine = dot(normal, {ray[0], ray[1], ray[2]}) / area;
  if (cosine < 0) std::swap(face[1], face[2]);
  return std::abs(cosine) >= least_cosine;
}

// Area-weighted unit normals of the vertices.
void add_normals(const std::vector<Face>& faces, const double* points, double* normals,
                 std::size_t vertices) {
  std::fill(normals, normals + 3 * vertices, 0.0);
  for (const Face& f : faces) {
    const Vec normal = cross(difference(points + 3 * f[1], points + 3 * f[0]),
                             difference(points + 3 * f[2], points + 3 * f[0]));
    for (const std::int32_t v : f)
      for (int k = 0; k < 3; ++k) normals[3 * v + k] += normal[k];
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    double* n = normals + 3 * v;
    const double size = length({n[0], n[1], n[2]});
    if (size > 0)
      for (int k = 0; k < 3; ++k) n[k] /= size;
  }
}

std::vector<Face> to_faces(const Ints& array) {
  std::vector<Face> faces(array.shape(0));
  const std::int32_t* data = array.data();
  for (std::size_t i = 0; i < faces.size(); ++i)
    faces[i] = {data[3 * i], data[3 * i + 1], data[3 * i + 2]};
  return faces;
}

Ints to_array(const std::vector<Face>& faces) {
  Ints array({static_cast<py::ssize_t>(faces.size()), py::ssize_t{3}});
  std::int32_t* out = array.mutable_data();
  for (const Face& f : faces) out = std::copy(f.begin(), f.end(), out);
  return array;
}

// Triangles of one grid cell whose corners (row-major) are a b / c d, -1 where none.
void add_cell(const double* points, std::int32_t a, std::int32_t b, std::int32_t c,
              std::int32_t d, std::vector<Face>& faces) {
  const int corners = (a >= 0) + (b >= 0) + (c >= 0) + (d >= 0);
  if (corners < 3) return;
  if (a < 0) return faces.push_back({b, c, d});
  if (b < 0) return faces.push_back({a, c, d});
  if (c < 0) return faces.push_back({a, d, b});
  if (d < 0) return faces.push_back({a, c, b});
  const double down = length(difference(points + 3 * d, points + 3 * a));
  const double up = length(difference(points + 3 * b, points + 3 * c));
  if (down < up) {
    faces.push_back({a, c, d});
    faces.push_back({a, d, b});
  } else {
    faces.push_back({a, c, b});
    faces.push_back({b, c, d});
  }
}

Ints grid_triangles(const Doubles& points, const Ints& grid) {
  const py::ssize_t rows = grid.shape(0), columns = grid.shape(1);
  const std::int32_t* cell = grid.data();
  const double* p = points.data();
  std::vector<Face> faces;
  {
    py::gil_scoped_release release;
    faces.reserve(2 * points.shape(0));
    for (py::ssize_t r = 0; r + 1 < rows; ++r, cell += columns)
      for (py::ssize_t c = 0; c + 1 < columns; ++c)
        add_cell(p, cell[c], cell[c + 1], cell[c + columns], cell[c + columns + 1], faces);
  }
  return to_array(faces);
}

Ints delaunay_triangles(const Doubles& uv) {
  const double* points = uv.data();
  const std::size_t count = uv.shape(0);
  std::vector<Face> faces;
  {
    py::gil_scoped_release release;
    faces = rops::delaunay(points, count);
  }
  return to_array(faces);
}

py::tuple mesh_from_triangles(const Doubles& points, const Doubles& rays, const Ints& candidates,
                              double edge_factor, double least_cosine) {
  const std::size_t vertices = points.shape(0);
  Doubles normals({static_cast<py::ssize_t>(vertices), py::ssize_t{3}});
  py::array_t<bool> boundary(static_cast<py::ssize_t>(vertices));
  const double *p = points.data(), *r = rays.data();
  double* n = normals.mutable_data();
  bool* rim = boundary.mutable_data();
  std::vector<Face> faces = to_faces(candidates), kept;
  double total = 0;
  std::size_t count = 0;
  {
    py::gil_scoped_release release;
    const auto spacing = expected_spacing(p, r, unique_edges(faces, vertices), vertices);
    kept.reserve(faces.size());
    for (Face& face : faces)
      if (accept(face, p, r, spacing, edge_factor, least_cosine)) kept.push_back(face);
    add_normals(kept, p, n, vertices);
    std::fill(rim, rim + vertices, true);
    for (const Face& f : kept) rim[f[0]] = rim[f[1]] = rim[f[2]] = false;
    const auto edges = unique_edges(kept, vertices);
    count = edges.size();
    for (const Edge& e : edges) {
      total += length(difference(p + 3 * e.high, p + 3 * e.low));
      if (e.faces == 1) rim[e.low] = rim[e.high] = true;
    }
  }
  return py::make_tuple(to_array(kept), normals, boundary, count ? total / count : 0.0);
}
}  // namespace

namespace rops {
void bind_mesh(py::module_& m) {
  m.def("grid_triangles", &grid_triangles);
  m.def("delaunay_triangles", &delaunay_triangles);
  m.def("mesh_from_triangles", &mesh_from_triangles);
}
}  // namespace rops

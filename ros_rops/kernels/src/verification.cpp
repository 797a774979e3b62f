// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <thread>

#include "evidence.h"

namespace py = pybind11;

namespace rops {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Flags = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;

template <class F>
void parallel(std::size_t count, int threads, F&& body) {
  const std::size_t hands = std::max<std::size_t>(
      1, std::min<std::size_t>(threads > 0 ? threads : std::thread::hardware_concurrency(),
                               count));
  std::vector<std::thread> pool;
  for (std::size_t h = 1; h < hands; ++h)
    pool.emplace_back([&, h] { for (std::size_t i = h; i < count; i += hands) body(i); });
  for (std::size_t i = 0; i < count; i += hands) body(i);
  for (std::thread& t : pool) t.join();
}

Rigid rigid_at(const double* m) {
  Rigid out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.r[3 * r + c] = static_cast<float>(m[4 * r + c]);
  out.t = {static_cast<float>(m[3]), static_cast<float>(m[7]), static_cast<float>(m[11])};
  return out;
}

struct ScoreSettings {
  float tau, front, facing;
};

// overlap (soft), in front, facing but not seen, normals disagree, matched within tau/3
struct Tally {
  double overlap = 0, front = 0, empty = 0, disagree = 0, residual = 0, count = 0;
};

void tally_samples(const Evidence& from, const Evidence& to, const Rigid& T, std::size_t first,
                   std::size_t last, const ScoreSettings& s, Tally& out) {
  const float tau2 = s.tau * s.tau;
  last = std::min(last, from.samples.size());
  for (std::size_t k = first; k < last; ++k) {
    const Vec3 p = T.apply(from.samples[k].point), n = T.rotate(from.samples[k].normal);
    const std::int32_t c = to.field.closest(p);
    if (c >= 0) {
      const Oriented& q = to.field.surface[c];
      const Vec3 gap = p - q.point;
      const float d2 = dot(gap, gap);
      if (d2 < tau2) {
        const float near = (1 - d2 / tau2) * (1 - d2 / tau2), agree = dot(n, q.normal);
        if (agree > 0) {
          out.overlap += near * agree;
          if (agree > 0.7f && !to.field.border[c]) {
            out.residual += std::fabs(dot(gap, q.normal));
            out.count += 1;
          }
        }
        if (agree < 0.5f) out.disagree += near;
      }
    }
    for (const Raster& raster : to.rasters) {
      const Sight sight = raster.look(p, n, s.front, s.facing);
      if (sight == Sight::kInFront) out.front += 1;
      if (sight == Sight::kEmpty) out.empty += 1;
    }
  }
}

py::array_t<double> score(const Evidence& source, const Evidence& target, Array poses, int samples,
                          float tau, float front, float facing, int threads) {
  const std::size_t count = poses.shape(0);
  py::array_t<double> result({count, std::size_t{12}});
  const double* in = poses.data();
  double* out = result.mutable_data();
  const ScoreSettings settings{tau, front, facing};
  py::gil_scoped_release release;
  parallel(count, threads, [&](std::size_t h) {
    const Rigid T = rigid_at(in + 16 * h);
    Tally a, b;
    tally_samples(source, target, T, 0, samples, settings, a);
    tally_samples(target, source, T.inverse(), 0, samples, settings, b);
    const double ns = std::min<double>(samples, source.samples.size());
    const double nt = std::min<double>(samples, target.samples.size());
    const double row[12] = {a.overlap / ns, a.front / ns,    a.empty / ns, a.disagree / ns,
                            a.residual,     a.count / ns,    b.overlap / nt, b.front / nt,
                            b.empty / nt,   b.disagree / nt, b.residual, b.count / nt};
    std::copy(row, row + 12, out + 12 * h);
  });
  return result;
}

// Normal equations of the point-to-plane problem: unknown small turn and shift of the source,
// in the target frame.
struct Normal6 {
  double a[21] = {}, b[6] = {}, squares = 0, absolute = 0, weight = 0;
  int count = 0;
  void add(Vec3 p, Vec3 n, float e, float w) {
    const Vec3 m = cross(p, n);
    const double j[6] = {m.x, m.y, m.z, n.x, n.y, n.z};
    int k = 0;
    for (int r = 0; r < 6; ++r) {
      const double wj = w * j[r];
      b[r] -= wj * e;
      for (int c = r; c < 6; ++c) a[k++] += wj * j[c];
    }
    squares += static_cast<double>(w) * e * e;
    absolute += static_cast<double>(w) * std::fabs(e);
    weight += w;
    ++count;
  }
};

bool solve6(const Normal6& n, double damping, double* x) {
  double m[6][6];
  int k = 0;
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) m[r][c] = m[c][r] = n.a[k++];
  for (int r = 0; r < 6; ++r) m[r][r] += damping * m[r][r] + 1e-12;
  double l[6][6] = {};
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c <= r; ++c) {
      double sum = m[r][c];
      for (int i = 0; i < c; ++i) sum -= l[r][i] * l[c][i];
      if (r == c) {
        if (sum <= 0) return false;
        l[r][r] = std::sqrt(sum);
      } else {
        l[r][c] = sum / l[c][c];
      }
    }
  double y[6];
  for (int r = 0; r < 6; ++r) {
    y[r] = n.b[r];
    for (int i = 0; i < r; ++i) y[r] -= l[r][i] * y[i];
    y[r] /= l[r][r];
  }
  for (int r = 5; r >= 0; --r) {
    x[r] = y[r];
    for (int i = r + 1; i < 6; ++i) x[r] -= l[i][r] * x[i];
    x[r] /= l[r][r];
  }
  return true;
}

struct Pose {
  double m[12];
  Rigid rigid() const {
    Rigid out;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) out.r[3 * r + c] = static_cast<float>(m[4 * r + c]);
    out.t = {static_cast<float>(m[3]), static_cast<float>(m[7]), static_cast<float>(m[11])};
    return out;
  }
  // exp(x) on the left; Rodrigues.
  void advance(const double* x) {
    const double angle = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (angle > 1e-12) {
      const double a = x[0] / angle, b = x[1] / angle, c = x[2] / angle;
      const double s = std::sin(angle), v = 1 - std::cos(angle), k = std::cos(angle);
      const double Q[9] = {k + a * a * v,     a * b * v - c * s, a * c * v + b * s,
                           a * b * v + c * s, k + b * b * v,     b * c * v - a * s,
                           a * c * v - b * s, b * c * v + a * s, k + c * c * v};
      std::copy(Q, Q + 9, R);
    }
    double n[12];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) {
        n[4 * r + c] = R[3 * r] * m[c] + R[3 * r + 1] * m[4 + c] + R[3 * r + 2] * m[8 + c];
        if (c == 3) n[4 * r + c] += x[3 + r];
      }
    std::copy(n, n + 12, m);
  }
};

void match_forward(const Evidence& from, const Evidence& to, const Rigid& T, std::size_t samples,
                   float radius, float agree, Normal6& eq) {
  samples = std::min(samples, from.samples.size());
  for (std::size_t k = 0; k < samples; ++k) {
    const Vec3 p = T.apply(from.samples[k].point);
    const std::int32_t c = to.field.closest(p);
    if (c < 0 || to.field.border[c]) continue;
    const Oriented& q = to.field.surface[c];
    const Vec3 gap = p - q.point;
    const float d2 = dot(gap, gap);
    if (d2 > radius * radius || dot(T.rotate(from.samples[k].normal), q.normal) < agree) continue;
    const float w = 1 - d2 / (radius * radius);
    eq.add(p, q.normal, dot(gap, q.normal), w);
  }
}

void match_backward(const Evidence& source, const Evidence& target, const Rigid& T,
                    std::size_t samples, float radius, float agree, Normal6& eq) {
  const Rigid back = T.inverse();
  samples = std::min(samples, target.samples.size());
  for (std::size_t k = 0; k < samples; ++k) {
    const Vec3 x = back.apply(target.samples[k].point);
    const std::int32_t c = source.field.closest(x);
    if (c < 0 || source.field.border[c]) continue;
    const Oriented& s = source.field.surface[c];
    const Vec3 gap = s.point - x;
    const float d2 = dot(gap, gap);
    if (d2 > radius * radius) continue;
    const Vec3 n = T.rotate(s.normal);
    if (dot(n, target.samples[k].normal) < agree) continue;
    const float w = 1 - d2 / (radius * radius);
    eq.add(T.apply(s.point), n, dot(gap, s.normal), w);
  }
}

py::tuple refine(const Evidence& source, const Evidence& target, Array poses, int samples,
                 Array radii, float agree, int threads) {
  const std::size_t count = poses.shape(0), rounds = radii.size();
  py::array_t<double> moved({count, std::size_t{4}, std::size_t{4}});
  py::array_t<double> numbers({count, std::size_t{3}});
  const double* in = poses.data();
  const double* radius = radii.data();
  double* out = moved.mutable_data();
  double* stats = numbers.mutable_data();
  {
  py::gil_scoped_release release;
  parallel(count, threads, [&](std::size_t h) {
    Pose pose;
    std::copy(in + 16 * h, in + 16 * h + 12, pose.m);
    Normal6 eq;
    for (std::size_t k = 0; k < rounds; ++k) {
      const Rigid T = pose.rigid();
      eq = Normal6();
      match_forward(source, target, T, samples, static_cast<float>(radius[k]), agree, eq);
      match_backward(source, target, T, samples, static_cast<float>(radius[k]), agree, eq);
      double x[6];
      if (eq.count < 10 || !solve6(eq, 1e-4, x)) break;
      pose.advance(x);
    }
    std::copy(pose.m, pose.m + 12, out + 16 * h);
    const double bottom[4] = {0, 0, 0, 1};
    std::copy(bottom, bottom + 4, out + 16 * h + 12);
    stats[3 * h] = eq.count;
    stats[3 * h + 1] = eq.weight;
    stats[3 * h + 2] = eq.weight > 0 ? eq.absolute / eq.weight : INFINITY;
  });
  }
  return py::make_tuple(moved, numbers);
}

// One direction of the last, exact round: vertices against nearest vertices.
struct Exam {
  Normal6 eq;
  double front = 0, empty = 0, disagree = 0, matched = 0, seen = 0, count = 0;
};

void examine_one_way(const Evidence& from, const Evidence& to, const Rigid& T, bool forward,
                     int samples, float radius, float front, float facing, Exam& out) {
  const std::size_t total = from.field.vertices.size();
  const std::size_t stride = std::max<std::size_t>(1, total / std::max(samples, 1));
  const Rigid back = T.inverse();
  const Rigid& go = forward ? T : back;
  for (std::size_t k = 0; k < total; k += stride) {
    const Oriented& v = from.field.vertices[k];
    const Vec3 p = go.apply(v.point), n = go.rotate(v.normal);
    out.count += 1;
    for (const Raster& raster : to.rasters) {
      const Sight sight = raster.look(p, n, front, facing);
      out.front += sight == Sight::kInFront;
      out.empty += sight == Sight::kEmpty;
      out.seen += sight == Sight::kSeen;
    }
    const std::int32_t c = to.field.closest_vertex(p);
    if (c < 0) continue;
    const Oriented& q = to.field.vertices[c];
    const Vec3 gap = p - q.point;
    if (dot(gap, gap) > radius * radius) continue;
    const float agree = dot(n, q.normal);
    out.disagree += agree < 0.5f;
    if (agree < 0.5f || to.field.rim[c]) continue;
    out.matched += 1;
    if (forward) {
      out.eq.add(p, q.normal, dot(gap, q.normal), 1);
    } else {
      out.eq.add(T.apply(q.point), T.rotate(q.normal), -dot(gap, q.normal), 1);
    }
  }
}

// Refine one pose on vertices and measure all that speaks for and against it.
py::tuple examine(const Evidence& source, const Evidence& target, Array start, int rounds,
                  int samples, float radius, float front, float facing) {
  Pose pose;
  std::copy(start.data(), start.data() + 12, pose.m);
  Exam a, b;
  {
    py::gil_scoped_release release;
    for (int k = 0; k <= rounds; ++k) {
      a = Exam(), b = Exam();
      const Rigid T = pose.rigid();
      examine_one_way(source, target, T, true, samples, radius, front, facing, a);
      examine_one_way(target, source, T, false, samples, radius, front, facing, b);
      if (k == rounds) break;
      Normal6 eq = a.eq;
      for (int i = 0; i < 21; ++i) eq.a[i] += b.eq.a[i];
      for (int i = 0; i < 6; ++i) eq.b[i] += b.eq.b[i];
      double x[6];
      if (a.eq.count + b.eq.count < 10 || !solve6(eq, 1e-6, x)) break;
      pose.advance(x);
    }
  }
  py::array_t<double> moved(std::vector<py::ssize_t>{4, 4});
  std::copy(pose.m, pose.m + 12, moved.mutable_data());
  const double bottom[4] = {0, 0, 0, 1};
  std::copy(bottom, bottom + 4, moved.mutable_data() + 12);
  py::array_t<double> hessian(std::vector<py::ssize_t>{6, 6});
  int k = 0;
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c, ++k)
      hessian.mutable_at(r, c) = hessian.mutable_at(c, r) = a.eq.a[k] + b.eq.a[k];
  py::array_t<double> numbers(std::vector<py::ssize_t>{2, 7});
  int row = 0;
  for (const Exam* e : {&a, &b}) {
    const double values[7] = {e->count, e->matched, e->eq.absolute, e->front,
                              e->empty, e->disagree, e->seen};
    std::copy(values, values + 7, numbers.mutable_data() + 7 * row++);
  }
  return py::make_tuple(moved, numbers, hessian);
}

std::vector<Oriented> oriented(const Array& points, const Array& normals) {
  std::vector<Oriented> out(points.shape(0));
  const double *p = points.data(), *n = normals.data();
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].point = {float(p[3 * i]), float(p[3 * i + 1]), float(p[3 * i + 2])};
    out[i].normal = {float(n[3 * i]), float(n[3 * i + 1]), float(n[3 * i + 2])};
  }
  return out;
}

std::shared_ptr<Evidence> make_evidence(Array points, Array normals, Flags rim, float cell,
                                        int reach) {
  const std::vector<Oriented> vertices = oriented(points, normals);
  const std::vector<std::uint8_t> edge(rim.data(), rim.data() + rim.size());
  auto out = std::make_shared<Evidence>();
  py::gil_scoped_release release;
  out->field = build_field(vertices, edge, cell, reach);
  draw_samples(*out);
  return out;
}

}  // namespace

void bind_verification(py::module_& m) {
  py::class_<Evidence, std::shared_ptr<Evidence>>(m, "_Evidence")
      .def(py::init(&make_evidence))
      .def("add_raster",
           [](Evidence& e, Array points, bool pinhole, std::array<float, 3> o,
              std::array<float, 3> d, float pixel) {
             const std::vector<Oriented> v = oriented(points, points);
             e.rasters.push_back(build_raster(v, pinhole, {o[0], o[1], o[2]},
                                              {d[0], d[1], d[2]}, pixel));
           })
      .def_property_readonly("sample_count", [](const Evidence& e) { return e.samples.size(); })
      .def_property_readonly("grid_cells", [](const Evidence& e) { return e.field.nearest.size(); });
  m.def("_score", &score);
  m.def("_refine", &refine);
  m.def("_examine", &examine);
}

}  // namespace rops

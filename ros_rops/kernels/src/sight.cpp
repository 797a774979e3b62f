// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Lines of sight against a view's triangles: exact on the triangle, found by image pixel.
#include "sight.hpp"

#include <algorithm>

namespace rops::sight {

namespace {

// Image points are tangents of angles; beyond this one (84 degrees off the axis) they tell little.
constexpr double kWidest = 10.0;
// Of a barycentric coordinate: rays through a common edge must not slip between its triangles.
constexpr double kSlack = 1e-7;
// A face over more pixels is kept aside while there are few such; so many list entries a face.
constexpr double kMostPixels = 1024;
constexpr std::size_t kMostLarge = 16, kMostEntries = 24;

struct Box {
  double u0, v0, u1, v1;
};

Vec3 unit(const Vec3& a) {
  const double length = std::sqrt(dot(a, a));
  return length > 0 ? a * (1 / length) : Vec3{0, 0, 1};
}

template <class Vertex>
Box box_of(const Vertex& a, const Vertex& b, const Vertex& c) {
  return {std::min({a.u, b.u, c.u}), std::min({a.v, b.v, c.v}), std::max({a.u, b.u, c.u}),
          std::max({a.v, b.v, c.v})};
}

// The way a pinhole looks is where its points are: whatever the data call its axis, an object
// beside it must not end up at infinity of the image plane.
Vec3 viewing_axis(const Scan& scan) {
  if (scan.kind != Kind::kPinhole) return unit(scan.direction);
  Vec3 sum{0, 0, 0};
  for (std::size_t f = 0; f < 3 * scan.face_count; ++f) {
    const double* p = scan.vertices + 3 * scan.faces[f];
    const Vec3 ray = unit(Vec3{p[0], p[1], p[2]} - scan.origin);
    for (int k = 0; k < 3; ++k) sum[k] += ray[k];
  }
  return unit(sum);
}

}  // namespace

View::View(const Scan& scan) : kind_(scan.kind) {
  const double* T = scan.T_object_view;
  const auto turned = [T](const Vec3& a) {
    return Vec3{T[0] * a[0] + T[1] * a[1] + T[2] * a[2], T[4] * a[0] + T[5] * a[1] + T[6] * a[2],
                T[8] * a[0] + T[9] * a[1] + T[10] * a[2]};
  };
  const Vec3 w = viewing_axis(scan);
  const Vec3 helper = std::fabs(w[0]) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = unit(cross(helper, w));
  axes_ = {turned(u), turned(cross(w, u)), turned(w)};
  const Vec3 origin = kind_ == Kind::kPinhole ? turned(scan.origin) : Vec3{0, 0, 0};
  eye_ = {origin[0] + T[3], origin[1] + T[7], origin[2] + T[11]};
  place(scan);
  if (kind_ == Kind::kUnknown) {
    find_rim();
    list_by_cell();
  } else {
    list_by_pixel();
    look_beyond(scan);
  }
}

Vec3 View::in_sensor(const Vec3& p) const {
  const Vec3 d = p - eye_;
  return {dot(axes_[0], d), dot(axes_[1], d), dot(axes_[2], d)};
}

Vec3 View::position(const Vertex& a) const {
  if (kind_ == Kind::kPinhole) return {a.u * a.z, a.v * a.z, a.z};
  return {a.u, a.v, a.z};
}

void View::place(const Scan& scan) {
  const double* T = scan.T_object_view;
  vertices_.resize(scan.vertex_count);
  std::vector<std::uint8_t> usable(scan.vertex_count, 1);
  for (std::size_t i = 0; i < scan.vertex_count; ++i) {
    const double* p = scan.vertices + 3 * i;
    Vec3 q;
    for (int r = 0; r < 3; ++r)
      q[r] = T[4 * r] * p[0] + T[4 * r + 1] * p[1] + T[4 * r + 2] * p[2] + T[4 * r + 3];
    const Vec3 s = in_sensor(q);
    vertices_[i] = {s[0], s[1], s[2], scan.weights[i]};
    if (kind_ != Kind::kPinhole) continue;
    vertices_[i].u /= s[2], vertices_[i].v /= s[2];
    usable[i] = s[2] > 0 && std::hypot(vertices_[i].u, vertices_[i].v) < kWidest;
  }
  for (std::size_t f = 0; f < scan.face_count; ++f) {
    const std::int32_t* v = scan.faces + 3 * f;
    if (usable[v[0]] && usable[v[1]] && usable[v[2]]) faces_.push_back({v[0], v[1], v[2]});
  }
}

void View::list_by_pixel() {
  std::vector<Box> boxes;
  std::vector<double> lengths;
  for (const Face& f : faces_) {
    const Box b = box_of(vertices_[f[0]], vertices_[f[1]], vertices_[f[2]]);
    boxes.push_back(b);
    lengths.push_back(std::max(b.u1 - b.u0, b.v1 - b.v0));
  }
  if (faces_.empty()) return;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  double pixel = *middle > 0 ? *middle : 1;
  const auto pixels = [&](const Box& b) {
    return ((b.u1 - b.u0) / pixel + 1) * ((b.v1 - b.v0) / pixel + 1);
  };
  // Faces of one view are of about one size in its image. Where they are not, larger pixels bound
  // the memory.
  for (;; pixel *= 2) {
    double entries = 0;
    large_.clear();
    for (std::size_t f = 0; f < boxes.size(); ++f) {
      const double n = pixels(boxes[f]);
      if (n > kMostPixels) large_.push_back(static_cast<std::uint32_t>(f));
      else entries += n;
    }
    if (large_.size() <= kMostLarge && entries <= kMostEntries * boxes.size()) break;
  }
  per_cell_ = 1 / pixel;
  lists_ = SparseLists(faces_.size(), [&](std::size_t f, auto&& emit) {
    const Box& b = boxes[f];
    if (pixels(b) > kMostPixels) return;
    const std::int64_t i1 = cell_index((b.u1 + kSlack * pixel) * per_cell_);
    const std::int64_t j1 = cell_index((b.v1 + kSlack * pixel) * per_cell_);
    for (auto i = cell_index((b.u0 - kSlack * pixel) * per_cell_); i <= i1; ++i)
      for (auto j = cell_index((b.v0 - kSlack * pixel) * per_cell_); j <= j1; ++j)
        emit(cell_key(i, j));
  });
}

void View::look_beyond(const Scan& scan) {
  const double* T = scan.T_object_view;
  std::vector<Vec3> ends;  // image point and depth
  Box all{INFINITY, INFINITY, -INFINITY, -INFINITY};
  for (std::size_t k = 0; k < scan.beyond_count; ++k) {
    const float* p = scan.beyond + 3 * k;
    Vec3 q;
    for (int r = 0; r < 3; ++r)
      q[r] = T[4 * r] * p[0] + T[4 * r + 1] * p[1] + T[4 * r + 2] * p[2] + T[4 * r + 3];
    Vec3 s = in_sensor(q);
    if (kind_ == Kind::kPinhole) {
      if (!(s[2] > 0)) continue;
      s[0] /= s[2], s[1] /= s[2];
      if (std::hypot(s[0], s[1]) >= kWidest) continue;
    }
    ends.push_back(s);
    all = {std::min(all.u0, s[0]), std::min(all.v0, s[1]), std::max(all.u1, s[0]),
           std::max(all.v1, s[1])};
  }
  const double width = all.u1 - all.u0, height = all.v1 - all.v0, count = ends.size();
  if (ends.size() < 4 || !(width > 0 && height > 0)) return;
  // Rays come thinned: with four to a pixel few pixels that they crossed are left without one.
  const double pixel = std::max(2 * std::sqrt(width * height / count), (width + height) / count);
  passed_.u0 = all.u0, passed_.v0 = all.v0, passed_.per_pixel = 1 / pixel;
  passed_.nu = static_cast<std::int64_t>(width / pixel) + 1;
  passed_.nv = static_cast<std::int64_t>(height / pixel) + 1;
  passed_.depth.assign(passed_.nu * passed_.nv, NAN);
  const auto at = [this](double u, double v, int du, int dv) {
    const auto clamped = [](double x, std::int64_t n) {
      return static_cast<std::int64_t>(std::min(std::max(x, -1.0), static_cast<double>(n)));
    };
    return std::array<std::int64_t, 2>{
        clamped(std::floor((u - passed_.u0) * passed_.per_pixel) + du, passed_.nu),
        clamped(std::floor((v - passed_.v0) * passed_.per_pixel) + dv, passed_.nv)};
  };
  for (const Vec3& s : ends) {
    const auto [i, j] = at(s[0], s[1], 0, 0);
    const auto row = std::min(j, passed_.nv - 1), column = std::min(i, passed_.nu - 1);
    float& d = passed_.depth[row * passed_.nu + column];
    d = std::fmin(d, static_cast<float>(s[2]));
  }
  // Beside the object nothing is known: what the sensor saw too flat lies there, without a face.
  for (const Face& f : faces_) {
    const Box b = box_of(vertices_[f[0]], vertices_[f[1]], vertices_[f[2]]);
    const auto low = at(b.u0, b.v0, -1, -1), high = at(b.u1, b.v1, 1, 1);
    for (auto j = std::max<std::int64_t>(low[1], 0); j <= std::min(high[1], passed_.nv - 1); ++j)
      for (auto i = std::max<std::int64_t>(low[0], 0); i <= std::min(high[0], passed_.nu - 1); ++i)
        passed_.depth[j * passed_.nu + i] = NAN;
  }
}

Glance View::look(const Vec3& point, double reach) const {
  const Vec3 s = in_sensor(point);
  return kind_ == Kind::kUnknown ? nearest(s, reach) : along_ray(s);
}

Glance View::along_ray(const Vec3& s) const {
  const bool pinhole = kind_ == Kind::kPinhole;
  if (pinhole && !(s[2] > 0)) return {};
  const double u = pinhole ? s[0] / s[2] : s[0], v = pinhole ? s[1] / s[2] : s[1];
  double depth = INFINITY;
  std::uint32_t hit = 0;
  Vec3 parts{};
  const auto try_face = [&](std::uint32_t f) {
    const Vertex &a = vertices_[faces_[f][0]], &b = vertices_[faces_[f][1]],
                 &c = vertices_[faces_[f][2]];
    const double bu = b.u - a.u, bv = b.v - a.v, cu = c.u - a.u, cv = c.v - a.v;
    const double area = bu * cv - cu * bv;
    if (area == 0) return;
    const double pu = u - a.u, pv = v - a.v;
    const double y = (pu * cv - cu * pv) / area, z = (bu * pv - pu * bv) / area, x = 1 - y - z;
    if (!(x >= -kSlack && y >= -kSlack && z >= -kSlack)) return;
    // What is linear in space is so in the image when divided by depth.
    const Vec3 q = pinhole ? Vec3{x / a.z, y / b.z, z / c.z} : Vec3{x, y, z};
    const double sum = pinhole ? 1 / (q[0] + q[1] + q[2]) : 1;
    const double at = pinhole ? sum : x * a.z + y * b.z + z * c.z;
    if (at < depth) depth = at, hit = f, parts = q * sum;
  };
  const auto [begin, end] =
      lists_.at(cell_key(cell_index(u * per_cell_), cell_index(v * per_cell_)));
  for (auto f = begin; f != end; ++f) try_face(*f);
  for (const auto f : large_) try_face(f);
  if (depth == INFINITY) return {s[2] < passed_(u, v) ? INFINITY : NAN, 0, 0};
  const double stretch = pinhole ? std::sqrt(1 + u * u + v * v) : 1;
  const Vec3 ray = pinhole ? Vec3{u / stretch, v / stretch, 1 / stretch} : Vec3{0, 0, 1};
  const Vertex &a = vertices_[faces_[hit][0]], &b = vertices_[faces_[hit][1]],
               &c = vertices_[faces_[hit][2]];
  const Vec3 n = unit(cross(position(b) - position(a), position(c) - position(a)));
  return {static_cast<float>((depth - s[2]) * stretch),
          static_cast<float>(parts[0] * a.weight + parts[1] * b.weight + parts[2] * c.weight),
          static_cast<float>(std::fabs(dot(n, ray)))};
}

}  // namespace rops::sight

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
#include "descriptor.hpp"

#include <algorithm>
#include <cmath>

namespace rops {
namespace {

constexpr int kAxes[3][2] = {{1, 2}, {0, 2}, {0, 1}};  // the two that turn
constexpr std::size_t kTables = 4;  // neighbours share a bin: do not wait for the last store
constexpr std::size_t kLogs = 4096;

struct Range {
  double low, scale;
};

double count_log(std::uint32_t count) {
  static const std::vector<double> table = [] {
    std::vector<double> values(kLogs, 0.0);
    for (std::size_t n = 1; n < kLogs; ++n) values[n] = n * std::log(static_cast<double>(n));
    return values;
  }();
  return count < kLogs ? table[count] : count * std::log(static_cast<double>(count));
}

Range range(const Lanes& low, const Lanes& high, int bins) {
  double least = low[0], most = high[0];
  for (std::size_t k = 1; k < kLanes; ++k) {
    least = std::min(least, low[k]);
    most = std::max(most, high[k]);
  }
  return {least, most > least ? bins / (most - least) : 0.0};
}

// Offsets into the frame; the keypoint's own (zero) goes, the last vector is filled up.
ROPS_CLONES std::size_t to_local(const Mat3& frame, bool skip_keypoint, Support& support) {
  const double *dx = support.offsets[0], *dy = support.offsets[1], *dz = support.offsets[2];
  double *x = support.local[0], *y = support.local[1], *z = support.local[2];
  std::size_t n = 0;
  for (std::size_t i = 0; i < support.size; ++i) {
    x[n] = frame[0][0] * dx[i] + frame[0][1] * dy[i] + frame[0][2] * dz[i];
    y[n] = frame[1][0] * dx[i] + frame[1][1] * dy[i] + frame[1][2] * dz[i];
    z[n] = frame[2][0] * dx[i] + frame[2][1] * dy[i] + frame[2][2] * dz[i];
    n += !skip_keypoint || dx[i] != 0 || dy[i] != 0 || dz[i] != 0;
  }
  for (std::size_t i = n; n && i < n + kLanes; ++i) x[i] = x[0], y[i] = y[0], z[i] = z[0];
  return n;
}

// out = stride * bin of the values, over their range.
ROPS_CLONES void bin_fixed(const double* values, std::size_t n, int bins, int stride,
                           std::int32_t* out) {
  const Lanes* v = reinterpret_cast<const Lanes*>(values);
  Lanes low = v[0], high = v[0];
  for (std::size_t i = 1; i < (n + kLanes - 1) / kLanes; ++i) {
    low = v[i] < low ? v[i] : low;
    high = v[i] > high ? v[i] : high;
  }
  const Range r = range(low, high, bins);
  for (std::size_t i = 0; i < n; ++i)
    out[i] = stride * std::min(static_cast<int>((values[i] - r.low) * r.scale), bins - 1);
}

// Turn two coordinates and add their bins to those of the axis; n is not a whole vector.
ROPS_CLONES void bin_turned(const double* first, const double* second, std::size_t n,
                            const Rotation& rotation, int bins, int first_stride,
                            int second_stride, Support& support) {
  const std::size_t vectors = (n + kLanes - 1) / kLanes;
  const Lanes* a = reinterpret_cast<const Lanes*>(first);
  const Lanes* b = reinterpret_cast<const Lanes*>(second);
  Lanes* u = reinterpret_cast<Lanes*>(support.turned[0]);
  Lanes* v = reinterpret_cast<Lanes*>(support.turned[1]);
  const double c = rotation.cosine, s = rotation.sine;
  Lanes u_low = c * a[0] + s * b[0], v_low = c * b[0] - s * a[0];
  Lanes u_high = u_low, v_high = v_low;
  for (std::size_t i = 0; i < vectors; ++i) {
    u[i] = c * a[i] + s * b[i];
    v[i] = c * b[i] - s * a[i];
    u_low = u[i] < u_low ? u[i] : u_low;
    u_high = u[i] > u_high ? u[i] : u_high;
    v_low = v[i] < v_low ? v[i] : v_low;
    v_high = v[i] > v_high ? v[i] : v_high;
  }
  const Range ru = range(u_low, u_high, bins), rv = range(v_low, v_high, bins);
  const double last = bins - 0.5;  // the greatest value belongs to the last bin
  const Lanes top = {last, last, last, last};
  for (std::size_t i = 0; i < vectors; ++i) {
    Lanes p = (u[i] - ru.low) * ru.scale, q = (v[i] - rv.low) * rv.scale;
    p = p < top ? p : top;
    q = q < top ? q : top;
    const IntLanes index = __builtin_convertvector(p, IntLanes) * first_stride +
                           __builtin_convertvector(q, IntLanes) * second_stride;
    for (std::size_t k = 0; k < kLanes; ++k)
      support.bins[kLanes * i + k] = support.fixed_bins[kLanes * i + k] + index[k];
  }
}

// How many points fall in each of the bins^3 boxes; the projections are its marginals.
void count_boxes(Support& support, std::size_t n, std::size_t boxes) {
  std::vector<std::uint32_t>& table = support.table;
  table.assign(kTables * boxes, 0);
  std::uint32_t* t = table.data();
  const std::int32_t* bins = support.bins.data();
  std::size_t i = 0;
  for (; i + kTables <= n; i += kTables)
    for (std::size_t k = 0; k < kTables; ++k) ++t[k * boxes + bins[i + k]];
  for (; i < n; ++i) ++t[bins[i]];
  for (std::size_t b = 0; b < boxes; ++b)
    for (std::size_t k = 1; k < kTables; ++k) t[b] += t[k * boxes + b];
}

// The distribution matrix of the projection along the axis of `stride`.
void project(const std::uint32_t* boxes, int bins, int row_stride, int column_stride, int stride,
             std::uint32_t* matrix) {
  for (int i = 0; i < bins; ++i)
    for (int j = 0; j < bins; ++j) {
      const std::uint32_t* box = boxes + i * row_stride + j * column_stride;
      std::uint32_t sum = 0;
      for (int k = 0; k < bins; ++k) sum += box[k * stride];
      matrix[i * bins + j] = sum;
    }
}

// mu11, mu21, mu12, mu22 and the entropy (eqs. 2-4).
void statistics(const std::uint32_t* matrix, int bins, std::size_t n, double log_unit,
                double* out) {
  double row_mean = 0, column_mean = 0, logs = 0;
  for (int i = 0; i < bins; ++i)
    for (int j = 0; j < bins; ++j) {
      const std::uint32_t count = matrix[i * bins + j];
      row_mean += static_cast<double>(i) * count;
      column_mean += static_cast<double>(j) * count;
      logs += count_log(count);
    }
  const double total = static_cast<double>(n);
  row_mean /= total;
  column_mean /= total;
  std::fill(out, out + 4, 0.0);
  for (int i = 0; i < bins; ++i) {
    double plain = 0, first = 0, second = 0;
    for (int j = 0; j < bins; ++j) {
      const double v = j - column_mean, m = matrix[i * bins + j] * v;
      plain += m;
      first += m * v;
    }
    const double u = i - row_mean;
    second = u * first;
    out[0] += u * plain;
    out[1] += u * u * plain;
    out[2] += second;
    out[3] += u * second;
  }
  for (int k = 0; k < 4; ++k) out[k] /= total;
  out[4] = (std::log(total) - logs / total) * log_unit;
}

void normalise(const std::vector<double>& values, bool absolute, float* out) {
  double sum = 0;
  for (const double value : values) sum += absolute ? std::abs(value) : value;
  const double factor = sum > 0 ? 1 / sum : 0.0;
  for (const double value : values) *out++ = static_cast<float>(value * factor);
}

}  // namespace

void describe(const Convention& convention, const Mat3& frame, Support& support, float* out) {
  const int bins = convention.bins, strides[3] = {bins * bins, bins, 1};
  const std::size_t n = to_local(frame, convention.skip_keypoint, support);
  std::vector<double> values(convention.length(), 0.0);
  std::vector<std::uint32_t> matrix(bins * bins);
  double* next = values.data();
  int axis = -1;
  for (const Rotation& rotation : convention.rotations) {
    if (n == 0) break;
    if (rotation.axis != axis) {
      axis = rotation.axis;
      bin_fixed(support.local[axis], n, bins, strides[axis], support.fixed_bins.data());
    }
    const int a = kAxes[axis][0], b = kAxes[axis][1];
    bin_turned(support.local[a], support.local[b], n, rotation, bins, strides[a], strides[b],
               support);
    count_boxes(support, n, bins * bins * bins);
    for (int out_axis = 2; out_axis >= 0; --out_axis, next += 5) {  // xy, xz, yz
      const int row = kAxes[out_axis][0], column = kAxes[out_axis][1];
      project(support.table.data(), bins, strides[row], strides[column], strides[out_axis],
              matrix.data());
      statistics(matrix.data(), bins, n, convention.log_unit, next);
    }
  }
  normalise(values, convention.absolute_norm, out);
}

}  // namespace rops

// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Four doubles at a time, the same arithmetic on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

// The wider instructions where the processor has them; without contraction to fused
// multiply-add both clones give the same bytes.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define ROPS_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define ROPS_CLONES
#endif

namespace rops {

constexpr std::size_t kLanes = 4;
typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));
typedef std::int32_t IntLanes __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

// Rows of doubles, each beginning on a vector's boundary and padded to whole vectors.
class Rows {
 public:
  Rows(std::size_t rows, std::size_t length)
      : stride_((length + 2 * kLanes) / kLanes * kLanes),
        data_(static_cast<double*>(
            ::operator new(rows * stride_ * sizeof(double), std::align_val_t{sizeof(Lanes)}))) {}
  double* operator[](std::size_t row) { return data_.get() + row * stride_; }
  const double* operator[](std::size_t row) const { return data_.get() + row * stride_; }

 private:
  struct Free {
    void operator()(double* p) const { ::operator delete(p, std::align_val_t{sizeof(Lanes)}); }
  };
  std::size_t stride_;
  std::unique_ptr<double, Free> data_;
};

}  // namespace rops

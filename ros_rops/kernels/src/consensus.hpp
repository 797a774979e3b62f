// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// What the points of all views around a place agree on: a height, a normal, a colour.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cell_hash.hpp"

namespace rops::consensus {

constexpr std::size_t kWide = 8;

using fine::cross;
using fine::dot;
using fine::minus;
using fine::Vec3;

// A measured point, in the frame of the object.
struct Sample {
  std::array<float, 3> normal;
  float weight;
  std::int32_t view;
  std::array<std::uint8_t, 4> color;
};

struct Reach {
  double radius;  // across the normal, and along it
  double near;    // across: what counts as the same place
  double paint;   // across: what colours mix
};

// Points count less the farther they are and the more their normals differ.
constexpr float kLeastCosine = 0.2f, kFullCosine = 0.7f;
// Of the heights' slope, relative to the radius: a one-sided neighbourhood must not tilt freely.
constexpr double kRidge = 0.01;
constexpr double kMostSlope = 1.0;
constexpr int kSteps = 2;
// Points are collected once around where a target begins; it moves by less than the rest.
constexpr double kSlack = 1.25;

inline Vec3 normalized(const Vec3& v) {
  const double length = std::sqrt(dot(v, v));
  if (!(length > 0)) return v;
  return {v[0] / length, v[1] / length, v[2] / length};
}

struct Answer {
  Vec3 point, normal;
  double weight = 0;
  std::int32_t view = -1, directions = 0, support = 0;
  std::array<std::uint8_t, 3> color{};
};

// The points around a target, as rows: offsets from where it began, normals, weights.
struct Around {
  static constexpr int kRows = 7;
  std::vector<float> rows[kRows];
  std::vector<std::int32_t> which;
  std::size_t count = 0;

  void clear() {
    count = 0;
    which.clear();
    for (std::vector<float>& row : rows) row.clear();
  }
  void add(const Vec3& offset, const Sample& s, std::int32_t k) {
    for (int a = 0; a < 3; ++a) {
      rows[a].push_back(static_cast<float>(offset[a]));
      rows[3 + a].push_back(s.normal[a]);
    }
    rows[6].push_back(s.weight);
    which.push_back(k);
    ++count;
  }
  // Fill the last vector with points that weigh nothing.
  void pad() {
    for (std::vector<float>& row : rows) row.resize((count + kWide - 1) / kWide * kWide, 0.0f);
  }
};

// Where a target is by now.
struct Place {
  float shift[3];  // from where it began
  float normal[3], e[3], f[3];
  float radius;
};

// Sums over the points around, of weight times: 1, u, v, uu, uv, vv; the same of 1, u, v times
// the height, and times the height along the target's normal; the points' normals.
constexpr int kSums = 15;
void add_up(const Around& around, const Place& place, double* sums);
// The weight of each point around, and its squared distance across the normal.
void weigh(const Around& around, const Place& place, float* weights, float* across);

// What each view says at a place.
struct Tally {
  double weight = 0, share = 0;
  bool near = false;
};

struct Scratch {
  explicit Scratch(int views) : tallies(views) {}
  Around around;
  std::vector<Tally> tallies;
  std::vector<std::int32_t> present;
  std::vector<float> weights, across;
};

class Field {
 public:
  Field(const double* points, std::size_t n, const std::vector<Sample>& samples, Reach reach)
      : hash_(points, n, kSlack * reach.radius), reach_(reach) {
    samples_.reserve(n);
    for (std::size_t k = 0; k < n; ++k) samples_.push_back(samples[hash_.original(k)]);
  }

  const fine::CellHash& hash() const { return hash_; }

  // What is agreed on at p, where the surface faces along n; the point moves there if asked.
  Answer ask(const Vec3& p, const Vec3& n, bool move, Scratch& scratch) const;

 private:
  void collect(const Vec3& p, const Vec3& n, Around& around) const;
  void count(const Place& place, Scratch& scratch, Answer& answer) const;

  fine::CellHash hash_;
  std::vector<Sample> samples_;
  Reach reach_;
};

}  // namespace rops::consensus

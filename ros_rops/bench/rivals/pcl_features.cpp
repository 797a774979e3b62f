// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Descriptors of the Point Cloud Library for vertices of a mesh, for rivals/pcl.py, which compiles
// this where libpcl-dev is installed. Everything goes through binary streams, host byte order:
//
//   pcl_features NAME RADIUS THREADS   NAME: spin, shot, usc, fpfh or rops
//   in:  int32 vertices N, faces F, keypoints K; float32 points (N, 3), normals (N, 3);
//        int32 faces (F, 3), keypoints (K); float32 frames (K, 3, 3), rows x, y, z
//   out: int32 K, D; float64 seconds of the computation; float32 descriptors (K, D)
#include <pcl/features/fpfh_omp.h>
#include <pcl/features/rops_estimation.h>
#include <pcl/features/shot_omp.h>
#include <pcl/features/impl/spin_image.hpp>  // the library has one size of histogram only
#include <pcl/features/usc.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using Point = pcl::PointXYZ;
using Normal = pcl::Normal;
using Frame = pcl::ReferenceFrame;
using Points = pcl::PointCloud<Point>;
using Normals = pcl::PointCloud<Normal>;
using Frames = pcl::PointCloud<Frame>;
using Table = std::vector<float>;  // rows of descriptors, one after the other

constexpr unsigned kSpinWidth = 15;  // bins of a side (Johnson and Hebert 1999)
using Spin = pcl::Histogram<(kSpinWidth + 1) * (2 * kSpinWidth + 1)>;
using Rops = pcl::Histogram<135>;

struct Task {
  Points::Ptr points{new Points};
  Normals::Ptr normals{new Normals};
  Frames::Ptr frames{new Frames};
  pcl::IndicesPtr keypoints{new pcl::Indices};
  std::vector<pcl::Vertices> faces;
  float radius = 0;
  unsigned threads = 1;
};

template <typename T>
std::vector<T> read(std::size_t count) {
  std::vector<T> values(count);
  if (std::fread(values.data(), sizeof(T), count, stdin) != count)
    throw std::runtime_error("the input ends early");
  return values;
}

template <typename T>
void write(const T* values, std::size_t count) {
  if (std::fwrite(values, sizeof(T), count, stdout) != count)
    throw std::runtime_error("the output cannot be written");
}

Task read_task(float radius, unsigned threads) {
  Task task;
  task.radius = radius;
  task.threads = threads;
  const auto counts = read<std::int32_t>(3);
  const std::size_t vertices = counts[0], faces = counts[1], keypoints = counts[2];
  const auto points = read<float>(3 * vertices), normals = read<float>(3 * vertices);
  for (std::size_t i = 0; i < vertices; ++i) {
    task.points->push_back(Point(points[3 * i], points[3 * i + 1], points[3 * i + 2]));
    task.normals->push_back(Normal(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]));
  }
  const auto corners = read<std::int32_t>(3 * faces);
  task.faces.resize(faces);
  for (std::size_t f = 0; f < faces; ++f)
    task.faces[f].vertices.assign(&corners[3 * f], &corners[3 * f] + 3);
  for (const std::int32_t index : read<std::int32_t>(keypoints)) task.keypoints->push_back(index);
  const auto axes = read<float>(9 * keypoints);
  for (std::size_t k = 0; k < keypoints; ++k) {
    Frame frame;
    for (int d = 0; d < 9; ++d) frame.rf[d] = axes[9 * k + d];
    task.frames->push_back(frame);
  }
  return task;
}

// What all estimators take; the surface is the whole cloud, so that indices mean one thing.
template <typename Out, typename Estimator, typename Values>
Table run(Estimator& estimator, const Task& task, std::size_t length, const Values& values) {
  estimator.setInputCloud(task.points);
  estimator.setIndices(task.keypoints);
  estimator.setSearchMethod(pcl::search::KdTree<Point>::Ptr(new pcl::search::KdTree<Point>));
  estimator.setRadiusSearch(task.radius);
  pcl::PointCloud<Out> found;
  estimator.compute(found);
  if (found.size() != task.keypoints->size())
    throw std::runtime_error("PCL refused the input");
  Table table;
  table.reserve(length * found.size());
  for (const Out& one : found) table.insert(table.end(), values(one), values(one) + length);
  return table;
}

Table spin(const Task& task) {
  pcl::SpinImageEstimation<Point, Normal, Spin> estimator(kSpinWidth, 0.0, 0);
  estimator.setInputNormals(task.normals);
  return run<Spin>(estimator, task, Spin::descriptorSize(),
                   [](const Spin& one) { return one.histogram; });
}

Table shot(const Task& task) {
  pcl::SHOTEstimationOMP<Point, Normal, pcl::SHOT352> estimator(task.threads);
  estimator.setInputNormals(task.normals);
  estimator.setInputReferenceFrames(task.frames);
  return run<pcl::SHOT352>(estimator, task, 352,
                           [](const pcl::SHOT352& one) { return one.descriptor; });
}

Table usc(const Task& task) {
  using Usc = pcl::UniqueShapeContext1960;
  pcl::UniqueShapeContext<Point, Usc> estimator;
  estimator.setInputReferenceFrames(task.frames);
  estimator.setLocalRadius(task.radius);
  estimator.setMinimalRadius(0.1 * task.radius);       // Tombari et al. 2010, section 4
  estimator.setPointDensityRadius(0.2 * task.radius);
  return run<Usc>(estimator, task, 1960, [](const Usc& one) { return one.descriptor; });
}

Table fpfh(const Task& task) {
  using Fpfh = pcl::FPFHSignature33;
  pcl::FPFHEstimationOMP<Point, Normal, Fpfh> estimator(task.threads);
  estimator.setInputNormals(task.normals);
  return run<Fpfh>(estimator, task, 33, [](const Fpfh& one) { return one.histogram; });
}

Table rops(const Task& task) {
  pcl::ROPSEstimation<Point, Rops> estimator;
  estimator.setTriangles(task.faces);
  estimator.setSupportRadius(task.radius);
  estimator.setNumberOfPartitionBins(5);
  estimator.setNumberOfRotations(3);
  return run<Rops>(estimator, task, 135, [](const Rops& one) { return one.histogram; });
}

Table compute(const std::string& name, const Task& task) {
  if (name == "spin") return spin(task);
  if (name == "shot") return shot(task);
  if (name == "usc") return usc(task);
  if (name == "fpfh") return fpfh(task);
  if (name == "rops") return rops(task);
  throw std::runtime_error("no descriptor " + name);
}

void serve(const std::string& name, float radius, unsigned threads) {
  using Clock = std::chrono::steady_clock;
  const Task task = read_task(radius, threads);
  const auto start = Clock::now();
  const Table table = compute(name, task);
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const std::size_t rows = task.keypoints->size();
  const std::int32_t shape[2] = {static_cast<std::int32_t>(rows),
                                 static_cast<std::int32_t>(rows ? table.size() / rows : 0)};
  write(shape, 2);
  write(&seconds, 1);
  write(table.data(), table.size());
}

}  // namespace

int main(int count, char** words) {
  try {
    if (count != 4) throw std::runtime_error("usage: pcl_features NAME RADIUS THREADS");
    serve(words[1], std::strtof(words[2], nullptr),
          static_cast<unsigned>(std::strtoul(words[3], nullptr, 10)));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}

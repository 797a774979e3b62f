// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
// Scoring, refining and examining poses of a source against a target by their evidence.
#pragma once
#include "evidence.hpp"
#include "normal_equations.hpp"

namespace rops {

// Per sample of one side: soft overlap, share in front of what the other side saw, share that
// should have been seen but was not, share that lies on a surface facing another way.
struct Score {
  double overlap = 0, front = 0, empty = 0, disagree = 0;
};

struct ScoreSettings {
  int samples;
  float tau, front, facing;
};

Score score_one_way(const Evidence& from, const Evidence& to, const Rigid& T_to_from,
                    const ScoreSettings& settings);

struct RefineSettings {
  int samples;
  float agree;
};

// One pass of point-to-plane rounds with falling radii, on samples of both sides; returns the
// number of matches of the last round.
int refine_pose(const Evidence& source, const Evidence& target, Pose& pose, const double* radii,
                std::size_t rounds, const RefineSettings& settings);

// One direction of the last, exact round: vertices against nearest vertices.
struct Exam {
  NormalEquations equations;
  double count = 0, matched = 0, front = 0, empty = 0, disagree = 0;
};

struct ExamSettings {
  int samples;
  float radius, front, facing;
};

// Refine on vertices for `rounds` rounds, then measure: source to target and back.
void examine_pose(const Evidence& source, const Evidence& target, Pose& pose, int rounds,
                  const ExamSettings& settings, Exam& forward, Exam& backward);

}  // namespace rops

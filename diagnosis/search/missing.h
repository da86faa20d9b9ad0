// SPDX-License-Identifier: BSD-3-Clause
// The equation error: the effort that was logged against the effort that the recorded motion takes, and against what the
// servo should have asked for; at samples far enough apart to be about independent, with what noise alone gives.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// One recording, thinned to about independent samples.
struct Grid {
  int recording = 0;
  std::vector<size_t> samples;
  Eigen::MatrixXd q, qd, qdd, u, c, cd;  // by kept sample, joint; u logged effort, c command
  Eigen::MatrixXd u1, u2;                // derivatives of u
  Eigen::MatrixXd bare, tau;             // effort that the motion takes, without and with the laws of joints
  Eigen::MatrixXd servo;                 // effort that the servo should have asked for
};

// The whitened rows of several recordings: of every kept sample, 2 n values for n joints, first (1) logged effort -
// effort that the motion takes, then (2) logged effort - effort the servo should have asked for.
struct MissingRows {
  std::vector<Grid> grids;       // by recording
  long rows = 0;                 // samples of all grids
  std::vector<char> has_effort;  // by joint; where none was logged, the servo's stands for it
  std::vector<double> sigma;     // [2 n] what noise alone gives
  Eigen::VectorXd residual;      // [2 n rows] over sigma; 0 where no joint is driven
};

// Against a plant, along `paths` under it (null: as recorded).
MissingRows calc_missing_rows(const Problem& problem, const Plant& plant, const std::vector<int>& recordings,
                              const Paths* paths = nullptr);

// Logged effort minus what the motion takes under `base`, thinned samples of one recording.
struct MissingEffort {
  std::vector<double> time;
  Eigen::MatrixXd q, qd, u, missing;  // by sample, joint
  std::vector<double> sigma;          // by joint: what noise alone gives
};
MissingEffort calc_missing_effort(const Problem& problem, const Hypothesis& base, int recording);

}  // namespace hrp::diagnosis

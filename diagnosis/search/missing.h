// SPDX-License-Identifier: BSD-3-Clause
// Equation error: logged effort minus the effort of the recorded motion, and minus the servo's effort. Samples are far
// enough apart to be nearly independent; standard deviations from noise are given.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// One recording, thinned to about independent samples.
struct Grid {
  int recording = 0;
  std::vector<size_t> samples;
  Eigen::MatrixXd q, qd, qdd, u, c, cd;  // sample x joint; u: logged effort, c: command
  Eigen::MatrixXd u1, u2;                // first and second derivative of u
  Eigen::MatrixXd bare, tau;             // effort of the motion without and with the joints' laws
  Eigen::MatrixXd servo;                 // effort by the servo law
};

// Whitened rows of several recordings. Each sample has 2 n values for n joints: (1) logged effort - effort of the
// motion, (2) logged effort - effort by the servo law.
struct MissingRows {
  std::vector<Grid> grids;       // by recording
  long rows = 0;                 // samples of all grids
  std::vector<char> has_effort;  // by joint; without a log, the servo's effort is used
  std::vector<double> sigma;     // [2 n] standard deviation from noise
  Eigen::VectorXd residual;      // [2 n rows] in units of sigma; 0 at joints without a drive
};

// Rows for a plant, along `paths` computed under it (null: as recorded).
MissingRows calc_missing_rows(const Problem& problem, const Plant& plant, const std::vector<int>& recordings,
                              const Paths* paths = nullptr);

// Logged effort minus the effort of the motion under `base`, at thinned samples of one recording [N m].
struct MissingEffort {
  std::vector<double> time;
  Eigen::MatrixXd q, qd, u, missing;  // by sample, joint
  std::vector<double> sigma;          // by joint: standard deviation from noise
};

// Of one recording. At a joint without a drive: minus the effort that its motion takes.
MissingEffort calc_missing_effort(const Problem& problem, const Hypothesis& base, int recording);

}  // namespace hrp::diagnosis

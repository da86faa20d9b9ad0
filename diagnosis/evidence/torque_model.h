// SPDX-License-Identifier: BSD-3-Clause
// Which terms, of each joint and of the whole robot, predict the missing torque that they were not fitted to.
//
// Evidence of a model: L = - sum over joints of N/2 ln(cross-validated mean square) - cost of its terms, N the number of
// independent samples. What the best model leaves is thus the yardstick, not the noise of an encoder.
#pragma once

#include <vector>

#include "diagnosis/evidence/torque_design.h"

namespace hrp::diagnosis {

// Terms by their places in the design's lists.
struct TorqueModel {
  std::vector<std::vector<size_t>> own;  // by joint of the design: terms, ascending
  std::vector<size_t> whole;             // terms of the whole robot
};

struct TorqueFit {
  Eigen::VectorXd theta;        // by column of `list_slots`: joints' own columns, then those of the whole robot
  Eigen::MatrixXd covariance;   // robust, of theta; empty unless asked for
  std::vector<double> cross;    // by joint: cross-validated mean square [(N m)^2]
  std::vector<double> held;     // by joint: mean square on held-out recordings
  std::vector<std::vector<double>> each_held;  // by joint, by held-out recording
  double evidence = 0.0;
};

// Where the columns of a model stand in theta.
struct Slots {
  std::vector<std::vector<long>> own;  // by joint, by term of the model: first slot
  std::vector<long> whole;             // by term of the model
  long size = 0;
};
Slots list_slots(const TorqueDesign& design, const TorqueModel& model);

TorqueFit fit_torque(const TorqueDesign& design, const TorqueModel& model, bool with_covariance = false);

// Held-out mean square that a fit leaves, summed over the joints, each over the spread of its effort.
double calc_held_left(const TorqueDesign& design, const TorqueFit& fit);

// A gain k of the effort moves the recorded effort to the left of the equation: what is left is k times what it would be
// in units of the effort, and a small k would fit anything. Factor that takes a mean square of `terms` (columns of the
// joint, with the parameters theta) back to the effort's units; 1 without a gain, and where k is over one.
double calc_per_effort(const JointDesign& joint, const std::vector<size_t>& terms, const Eigen::VectorXd& theta);

// [nats] that the size of a joint's gain costs, by `calc_factor_cost`; 0 without one.
double calc_gain_cost(const JointDesign& joint, const std::vector<size_t>& terms, const Eigen::VectorXd& theta);

// What every drive has, by joint of the design.
std::vector<std::vector<size_t>> list_usual_terms(const TorqueDesign& design);

constexpr double kWholeGain = 6.0;  // [nats] that a term of the whole robot must add: a likelihood ratio of 400

// Least mean square, as a share of the effort's: filters and rounding leave about as much of a perfect model.
constexpr double kFloor = 1e-6;

// [nats] of a log-normal prior: a drive that loses half of its torque is less likely than friction.
double calc_factor_cost(double factor);
// [nats] the same for a link's mass: most are near what the model says, but some are placeholders, or a tool is missing
// (Student's t of ten degrees of freedom: as wide at its middle, and not as sure far away).
double calc_mass_cost(double factor);
// [nats] of a term with these parameters before any recording: that it is there, and its size where it is a factor.
double calc_term_cost(const TermRow& row, const Eigen::VectorXd& parameters);

// Whether the parameters of a joint's terms are those of a real drive: friction brakes, rotors have mass, delays are
// positive and short.
bool is_physical(const TorqueDesign& design, size_t joint, const std::vector<size_t>& terms,
                 const Eigen::VectorXd& theta);

// Loads have mass and hang within reach of their link; masses are wrong by factors, zeros by fractions of a radian.
bool is_whole_physical(const TorqueDesign& design, const Term& term, const Eigen::VectorXd& parameters);

// Parameters of a term of the whole robot; 0 for those that hardly move any joint's torque: their values mean nothing.
Eigen::VectorXd drop_unseen(const TorqueDesign& design, const Term& term, Eigen::VectorXd parameters);

struct Choice {
  TorqueModel model;
  TorqueFit fit;
  std::vector<std::vector<double>> inclusion;  // by joint, by term of the design: probability over all subsets
  // By joint, by term: standard deviation of its first parameter over the subsets that have it, by their probabilities:
  // how far the value depends on what else is in the model.
  std::vector<std::vector<double>> choice_std;
};
// Whether commands may be late.
enum class Timing { kFree, kAsRecorded };
Choice choose_torque_model(const TorqueDesign& design, int jobs, Timing timing = Timing::kFree);
// The same without terms of the whole robot.
Choice choose_joint_terms(const TorqueDesign& design, int jobs);

}  // namespace hrp::diagnosis

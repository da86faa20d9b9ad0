// SPDX-License-Identifier: BSD-3-Clause
// Fits and scores models of the missing torque: sets of terms of each joint and of the whole robot.
//
// Evidence of a model: L = - sum over joints of N/2 ln(cross-validated mean square) - cost of its terms, with N
// independent samples. The residual of the model itself sets the scale, not the noise of an encoder.
#pragma once

#include <vector>

#include "diagnosis/evidence/torque/design.h"

namespace hrp::diagnosis {

// A model: indices into the term lists of the design.
struct TorqueModel {
  std::vector<std::vector<size_t>> own;  // by joint of the design: terms, ascending
  std::vector<size_t> whole;             // terms of the whole robot
};

// Adds a term of the joint's own that the model does not have. Returns its place in the list.
size_t add_own_term(size_t joint, size_t term, TorqueModel* model);

struct TorqueFit {
  Eigen::VectorXd theta;       // by column of `list_slots`: joints' own columns, then those of the whole robot
  Eigen::MatrixXd covariance;  // robust, of theta; empty unless asked for
  std::vector<double> cross;   // by joint: cross-validated mean square [(N m)^2]
  std::vector<double> held;    // by joint: mean square on held-out recordings
  std::vector<std::vector<double>> each_held;  // by joint, by held-out recording
  double evidence = 0.0;
};

// Indices of a model's parameters in theta.
struct Slots {
  std::vector<std::vector<long>> own;  // by joint, by term of the model: first slot
  std::vector<long> whole;             // by term of the model
  long size = 0;
};
Slots list_slots(const TorqueDesign& design, const TorqueModel& model);

// Columns of a model in one joint's sums, and their slots in theta.
struct UsedColumns {
  Columns columns, slots;
};
UsedColumns list_used_columns(const TorqueDesign& design, const TorqueModel& model, const Slots& slots, size_t joint);

// Weight of a joint's rows where all joints are fitted together: the inverse of what a model leaves, but for what
// nobody fits.
double calc_row_weight(const JointDesign& joint, double left);

// Fits a model by least squares: each joint alone, or all joints together if the model has terms of the whole robot.
// Evidence and errors are cross-validated over the folds.
TorqueFit fit_torque(const TorqueDesign& design, const TorqueModel& model, bool with_covariance = false);

// Held-out mean squares, each relative to the squared spread of the joint's effort, summed over joints [1].
double calc_held_left(const TorqueDesign& design, const TorqueFit& fit);

// With a gain k, the recorded effort becomes a regressor and the residual is k times the residual in units of the
// effort. A small k would then fit anything. Returns the factor 1 / k^2 that converts a mean square of `terms` (columns
// of the joint, parameters theta) back to units of the effort; 1 without a gain or with k > 1.
double calc_per_effort(const JointDesign& joint, const std::vector<size_t>& terms, const Eigen::VectorXd& theta);

// Prior cost [nats] of the size of the joint's gain, by `calc_factor_cost`; 0 without a gain.
double calc_gain_cost(const JointDesign& joint, const std::vector<size_t>& terms, const Eigen::VectorXd& theta);

// Terms that every drive has (friction, rotor), by joint of the design.
std::vector<std::vector<size_t>> list_usual_terms(const TorqueDesign& design);

// [nats] least gain of a term of the whole robot, or one that every drive has: odds of 400
constexpr double kWholeGain = 6.0;

// Log-likelihood [nats] of a joint's cross-validated mean square [(N m)^2], but for a constant.
double calc_evidence(const JointDesign& joint, double cross);

// The same where no error counts below the share to which efforts and masses are known; of a fit, with its prior costs.
double calc_blurred_evidence(const JointDesign& joint, double cross);
double calc_blurred_evidence(const TorqueDesign& design, const TorqueFit& fit);

// Smallest mean square as a share of the squared effort spread: errors of filters and rounding.
constexpr double kFloor = 1e-6;

// Prior cost [nats] of a factor, log-normal: a drive that loses half of its torque is less likely than friction.
double calc_factor_cost(double factor);
// Prior cost [nats] of a link's mass factor, Student's t with ten degrees of freedom in ln(factor). It is as wide as
// the log-normal prior in the middle but has heavier tails, because some masses are placeholders or lack a tool.
double calc_mass_cost(double factor);
// Prior cost [nats] of a term with these parameters: of its presence, and of its size if it is a factor.
double calc_term_cost(const TermRow& row, const Eigen::VectorXd& parameters);
// Prior cost [nats] of a force [N] that points down like a weight: a force that may have any direction lies within the
// angle theta of the vertical with probability (1 - cos theta) / 2. No angle counts below 0.02 rad, to which bases are
// level.
double calc_direction_cost(const Vector3d& force_W, const Vector3d& gravity_W);

// True if the parameters of a joint's terms are physical: friction opposes motion, inertias are positive, delays are
// positive and short, and no term is ten times the missing torque, which the others would have to take back.
bool is_physical(const TorqueDesign& design, size_t joint, const std::vector<size_t>& terms,
                 const Eigen::VectorXd& theta);

// True if a term of the whole robot is physical: a load has positive mass within reach of its link; mass factors and
// encoder zeros are within their bounds.
bool is_whole_physical(const TorqueDesign& design, const Term& term, const Eigen::VectorXd& parameters);

// True if all terms of a model are physical in its fit. Values differ from those in the fit of a joint's subset.
bool is_model_physical(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit);

// Parameters of a term of the whole robot, with 0 for those that hardly change any joint's torque. The values of these
// are not determined.
Eigen::VectorXd drop_unseen(const TorqueDesign& design, const Term& term, Eigen::VectorXd parameters);

// The chosen model, its fit, and averages over all subsets of terms.
struct Choice {
  TorqueModel model;
  TorqueFit fit;
  std::vector<std::vector<double>> inclusion;  // by joint, by term of the design: posterior probability
  // By joint, by term: standard deviation of its first parameter over the subsets that contain it, weighted by their
  // probabilities. It shows how far the value depends on the other terms.
  std::vector<std::vector<double>> choice_std;
};
// kFree: commands may be late. kAsRecorded: the models contain no delays of commands.
enum class Timing { kFree, kAsRecorded };
Choice choose_torque_model(const TorqueDesign& design, int jobs, Timing timing = Timing::kFree);
// Each load in the place of the term `at` of the whole robot, as the last one, with newly chosen terms of the joints:
// those beside a force were chosen for the force. Only physical ones.
std::vector<Choice> list_loads_instead(const TorqueDesign& design, const TorqueModel& model, size_t at, int jobs);
// Chooses terms of the joints only, without terms of the whole robot.
Choice choose_joint_terms(const TorqueDesign& design, int jobs);

}  // namespace hrp::diagnosis

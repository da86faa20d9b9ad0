// SPDX-License-Identifier: BSD-3-Clause
// Estimates how much a parameter differs between parts of the recordings. If the model lacks some physics, the best
// value depends on the regime. The noise alone does not show that.
#pragma once

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// Standard deviation by column of a joint's part of the model (its own terms, then the whole robot's), in addition to
// the noise:
//
// - Between parts: recordings; quarters by time, speed, position, load. The variance between parts is that of random
//   effects (DerSimonian and Laird 1986), for the value in one more part (Higgins, Thompson and Spiegelhalter 2009).
//   The division with the largest variance counts.
// - Drift: change from the middle of a recording to its ends, if it is significant.
// - Considered, not estimated (Schmidt 1966): the torque constant is known to `gain_std` [1], sampling instants to half
// a
//   sample. Such errors are too small to be named, but they change the other parameters. Dry friction varies by a fifth
//   over a turn; a joint that moved through part of a turn shows only that part.
//
// Of the joint's own terms the smaller of two estimates: with masses as in `fit`, or fitted to these rows again. One
// joint's rows cannot tell its gain from a mass that it carries. A mass that suits all joints may leave more in the
// rows of this one.
Eigen::VectorXd calc_spread_between(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit,
                                    size_t joint, double gain_std);

// Sums over the samples of one joint, from which its considered errors follow. Those of several recordings add up.
struct ConsideredSums {
  Eigen::MatrixXd xx;     // column x column, of the regressors
  Eigen::MatrixXd moved;  // column x 2: regressors by the effort [N m] and by its rate [N m/s]
};

// `x`: sample x column; `effort` [N m] and `effort_rate` [N m/s] by sample.
ConsideredSums sum_considered(const Eigen::MatrixXd& x, const Eigen::VectorXd& effort,
                              const Eigen::VectorXd& effort_rate);

// Variance by column if the torque constant is wrong by `gain_std` [1] and the effort is late by half a sample.
// `sample_time` [s].
Eigen::VectorXd calc_considered_variance(const ConsideredSums& sums, double sample_time, double gain_std);

// Standard deviation by slot of `fit`, of a model with terms of the whole robot: each joint's torque constant and each
// other link's mass is known to 2 %. Unlike what parts of one joint say, this concerns the rows of all joints.
Eigen::VectorXd calc_considered_std(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit);

// What the terms' values owe to masses and centres of mass that the model does not fit: each is known to 2 %
// beforehand, and to what the recordings tell beside all terms. Standard deviation by slot of `fit`, beyond that with
// exact masses. A wrong mass looks like a rotor, a spring or a constant torque.
Eigen::VectorXd calc_unsure_mass_std(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit);

// Friction reverses with the motion, and weight and inertia do not: they hardly tell on each other.
bool is_loss(const EffectInfo& effect);

// Of a load: widths of its coefficients m and m p, with those of m p replaced by m times the width of the place p = (m
// p) / m. Postures tell the weight's moment m p well and m alone poorly, so p is known no better than m. `covariance`:
// of the coefficients, which gives their correlation.
Eigen::Vector4d take_place_widths(const Eigen::Vector4d& coefficients, const Eigen::Matrix4d& covariance,
                                  const Eigen::Vector4d& width);

// Standard deviation of a level of dry friction, in its unit, from the part of a turn that a travel [rad] leaves
// unseen: the mean of some of a turn's windows, each with a friction of its own, for that of all (sampling from a
// finite population).
double calc_unseen_std(double level, double travel);

}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
// Readings of sensors behind the gears, minus their prediction, as a linear model of effects of links and sensors:
//
//   read - predicted = sum of column x parameter,  one row for each reading and moment.
//
// Sensors share the effects of links: a load acts on every sensor between it and the base. A group of readings is
// weighted by the residual of the best model, not by the sensor noise.
#pragma once

#include <vector>

#include "diagnosis/estimate/gram.h"
#include "diagnosis/evidence/links/rows.h"
#include "diagnosis/measurement/link_sensors.h"

namespace hrp::diagnosis {

using LinkTerms = std::vector<size_t>;  // indices into LinkDesign::terms

// Normal equations and noise of one group of readings.
struct LinkGroup {
  ReadingGroup reading;
  std::vector<Gram> train, held;  // by stretch; by held-out recording, or as `train` if none is held out
  std::vector<Gram> alone;        // by recording, whole length
  double spread = 0.0;            // rms of the readings about the mean of each recording
  double floor = 0.0;             // mean square that counts as noise: sensor noise behind the filter
  double effective = 1.0;         // independent samples in the training recordings
};

// The linear model of all sensors: terms and the sums of all groups.
struct LinkDesign {
  const LinkReadings* readings = nullptr;
  const Experiment* experiment = nullptr;
  std::vector<LinkTerm> terms;
  std::vector<LinkGroup> groups;
  long width = 0;
  bool has_held = false;
};

// Linearisation point of a nonlinear term, from an earlier fit. Without one, the term starts at its row's start value.
struct LinkPoint {
  const LinkTermRow* row = nullptr;
  int index = 0;
  Vector3d near = Vector3d::Zero();
};
using LinkPoints = std::vector<LinkPoint>;
const LinkPoint* find_point(const LinkPoints& points, const LinkTermRow& row, int index);  // null if there is none

// Computes the columns of all terms at the linearisation points `points`, and their sums. Terms that no reading shows
// are left out. `readings` must outlive the design.
LinkDesign make_link_design(const LinkData& data, const LinkSensors& sensors, LinkReadings* readings,
                            const LinkPoints& points);

struct LinkFit {
  std::vector<Eigen::VectorXd> theta;  // by term of the model
  Eigen::MatrixXd covariance;          // of all parameters in sequence; empty unless requested
  std::vector<double> cross, held;     // mean squares by group: cross-validated; held out
  double evidence = 0.0;               // [nats] log evidence minus the costs of the terms
  bool physical = true;
};

// Fits a set of terms by weighted least squares. The weights follow the cross-validated residuals (three iterations).
LinkFit fit_links(const LinkDesign& design, const LinkTerms& model, bool with_covariance = false);

// Evidence [nats] of other models with the weights of `fit`; minus infinity for models that are not physical.
std::vector<double> compare_links(const LinkDesign& design, const std::vector<LinkTerms>& models, const LinkFit& fit);

// Greedy selection: adds, exchanges and removes terms. Most robots have one or two effects.
LinkTerms choose_link_terms(const LinkDesign& design);

// Parameters and variances of one recording alone, for all terms of the model.
struct LinkAlone {
  std::vector<Eigen::VectorXd> theta, variance;
};
LinkAlone fit_alone(const LinkDesign& design, const LinkTerms& model, const LinkFit& fit, size_t recording);

// True if the coefficients p of a term are within its physical range.
bool is_physical(const LinkDesign& design, const LinkTerm& term, const Eigen::VectorXd& p);

}  // namespace hrp::diagnosis

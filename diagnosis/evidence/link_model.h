// SPDX-License-Identifier: BSD-3-Clause
// What sensors behind the gears read beyond the prediction, as a linear model of effects of links and of the sensors:
//
//   read - predicted = sum of column x parameter,  one row for each reading and moment.
//
// Sensors of different kinds share the effects of links: a load pulls at every sensor between it and the base. Readings of
// a group count by what the best model leaves of them, not by their noise.
#pragma once

#include <vector>

#include "diagnosis/estimate/gram.h"
#include "diagnosis/evidence/link_rows.h"
#include "diagnosis/measurement/link_sensors.h"

namespace hrp::diagnosis {

using LinkTerms = std::vector<size_t>;  // places in LinkDesign::terms

struct LinkGroup {
  ReadingGroup reading;
  std::vector<Gram> train, held;  // by stretch; by held-out recording, or `train` where nothing is held out
  std::vector<Gram> alone;        // by recording, all of it
  double spread = 0.0;            // of the readings, held-out recordings
  double floor = 0.0;             // mean square below which nothing is missing: noise behind the filter
  double effective = 1.0;         // independent samples of training
};

struct LinkDesign {
  const LinkReadings* readings = nullptr;
  const Experiment* experiment = nullptr;
  std::vector<LinkTerm> terms;
  std::vector<LinkGroup> groups;
  long width = 0;
  bool has_held = false;
};

// What is not linear is linear near a point that a fit before has found; where there is none, near the row's start.
struct LinkPoint {
  const LinkTermRow* row = nullptr;
  int index = 0;
  Vector3d near = Vector3d::Zero();
};
using LinkPoints = std::vector<LinkPoint>;
const LinkPoint* find_point(const LinkPoints& points, const LinkTermRow& row, int index);  // null: there is none

LinkDesign make_link_design(const LinkData& data, const LinkSensors& sensors, LinkReadings* readings, const LinkPoints& points);

struct LinkFit {
  std::vector<Eigen::VectorXd> theta;   // by term of the model
  Eigen::MatrixXd covariance;           // of all of them, one after the other; empty unless asked for
  std::vector<double> cross, held;      // by group: mean squares, predicted from other stretches; held out
  double evidence = 0.0;                // [nats] with the cost of the terms
  bool physical = true;
};

LinkFit fit_links(const LinkDesign& design, const LinkTerms& model, bool with_covariance = false);

// Evidence of other models under the weights of a fit; minus infinity where they are not physical.
std::vector<double> compare_links(const LinkDesign& design, const std::vector<LinkTerms>& models, const LinkFit& fit);

// Greedy, with exchanges and removals; most of what is there is one or two effects.
LinkTerms choose_link_terms(const LinkDesign& design);

// Parameters of one recording alone beside all of the model's terms, with their variances.
struct LinkAlone {
  std::vector<Eigen::VectorXd> theta, variance;
};
LinkAlone fit_alone(const LinkDesign& design, const LinkTerms& model, const LinkFit& fit, size_t recording);

bool is_physical(const LinkDesign& design, const LinkTerm& term, const Eigen::VectorXd& p);

}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
// Effects that the equations of a robot on its feet may show, each as a combination of columns.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "common/effects/effect_info.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/measurement/floating/columns.h"
#include "diagnosis/measurement/floating/contacts.h"

namespace hrp::diagnosis::floating {

// One coefficient: the columns that it multiplies.
using Terms = std::vector<std::pair<int, double>>;

struct CandidateLaw;  // candidate_laws.h

struct Candidate {
  EffectId effect = EffectId::kNamed;
  const CandidateLaw* law = nullptr;
  Where where;
  int place = -1;            // joint, link, foot, sensor, IMU by index; -1: none or all
  std::vector<Terms> terms;  // by coefficient
  bool positive = false;     // the first coefficient cannot be negative
  double least = 0;          // what the first coefficient must exceed to be worth a name
  double low = -1e9, high = 1e9;  // of the first coefficient
  Vector3d center{0, 0, 0};  // [m] of a link's mass by the model, and how far from its origin the link extends
  double extent = 1e9;
  bool vector = false;       // coefficients are three axes of one quantity
  std::string unit;          // of parameters that have that of a sensor's reading
  double known = 0;          // how well clocks and mountings are known: what a smaller error of one explains is no mismatch
  double worth = 0;          // share of an equation's spread that it must take away
  double lever = 0;          // [m] of a joint's torque without a shape of its own: a force under the sole makes one, too
  bool is_listed() const;    // in the table of effects; else a free law
  std::vector<long> core;    // coefficients by which it is sure and of one size in all regimes; none: by its kind
  // Of a vector its length, else the size of the first coefficient.
  double calc_size(const Eigen::VectorXd& x) const { return vector ? x.norm() : std::abs(x(0)); }
};

// Links that something from outside may pull at: the base, those that several links hang on, and the last ones.
std::vector<int> list_pulled_links(const LeggedLog& log);

std::vector<Candidate> list_candidates(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout);

// A load is a point: its inertia follows from mass and place. Adds the terms for a load at `place` [m] in its link.
Candidate make_load(const Candidate& payload, const ColumnLayout& layout, const Vector3d& place);

// A link's mass that lies elsewhere turns about its origin otherwise, too: the terms about a mass moved by `offset` [m].
// Its inertia about its own centre stays.
Candidate make_moved(const Candidate& com_error, const ColumnLayout& layout, const Vector3d& offset);

// Parameters as the report has them.
std::vector<Estimate> make_estimates(const Candidate& candidate, const Eigen::VectorXd& x, const Eigen::VectorXd& std);

// Whether the values can be: a load lies within `reach` [m] of its link, stiffness is positive, and so on.
bool is_sensible(const Candidate& candidate, const Eigen::VectorXd& x, double reach);

// Friction and rotors are in every drive, whatever is beside them; a sensor's zero is told by means alone. Of all else
// nothing is expected: where it and the others leave most of what stands out, another cause may pass for it.
bool is_expected(EffectId effect);

}  // namespace hrp::diagnosis::floating

// SPDX-License-Identifier: BSD-3-Clause
// Effects that the equations of a robot on its feet may show, each as a combination of columns.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "common/effects/effect_info.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/floating/fit/columns.h"

namespace hrp::diagnosis::floating {

constexpr double kLargestAngle = 0.5;  // [rad] columns of angles are linear up to it
// [m/N] A sole that gives less is rigid: a robot of 100 kg sinks by 1 mm.
constexpr double kRigidHeight = 1e-6;
// [m] From its link's origin: the farthest place of a load.
constexpr double kReach = 1.0;

// One coefficient: the columns that it multiplies.
using Terms = std::vector<std::pair<int, double>>;

struct CandidateLaw;  // candidate_laws.h

// A law at a place, with the numbers that depend on the place.
struct Candidate {
  const CandidateLaw* law = nullptr;
  Where where;
  int place = -1;            // joint, link, foot, sensor, IMU by index; -1: none or all
  std::vector<Terms> terms;  // by coefficient
  // By coefficient, what its values deviate from 0 by; empty: anything is possible. What no motion tells stays near 0
  // then.
  std::vector<double> prior;
  bool vector = false;       // coefficients are axes of one quantity
  double least = 0;          // what the first coefficient must exceed to be worth a name
  Vector3d center{0, 0, 0};  // [m] of a link's mass by the model
  double extent = 1e9;       // [m] from its origin, which a link's mass lies within
  std::string unit;          // of parameters that have the unit of a sensor's reading
  // How well clocks and mountings are known. What a smaller error of one explains as well is no mismatch.
  double known = 0;
  // [m] Of a joint's torque that has no shape of its own: a force under the sole makes a torque of this lever, too.
  double lever = 0;

  bool is_listed() const;          // in the table of effects; else a free law
  const EffectInfo& info() const;  // of the table, if listed
  // Of a vector its length, else the size of the first coefficient.
  double calc_size(const Eigen::VectorXd& x) const { return vector ? x.norm() : std::abs(x(0)); }
};

// Links that something from outside may pull at: the base, those that several links hang on, and the last ones.
std::vector<int> list_pulled_links(const LeggedLog& log);

std::vector<Candidate> list_candidates(const LeggedLog& log, const ColumnLayout& layout);

// A load is a point: its inertia follows from mass and place. Adds the terms for a load at `place` [m] in its link.
Candidate make_load(const Candidate& payload, const ColumnLayout& layout, const Vector3d& place);

// Of a load of about `mass` [kg]: any mass, at a place within kReach of its link's origin. A walk may not tell its
// height: weights do not change with it, and a body that turns little hardly does.
std::vector<double> make_place_prior(double mass);

// A link's mass that lies elsewhere turns about its origin otherwise, too: the terms about a mass moved by `offset`
// [m]. Its inertia about its own centre stays.
Candidate make_moved(const Candidate& com_error, const ColumnLayout& layout, const Vector3d& offset);

// Coefficients by which an effect is certain: those of its law, else the first one.
std::vector<long> find_core(const Candidate& candidate);

// Parameters as the report has them; none: no value is told.
std::vector<Estimate> make_estimates(const Candidate& candidate, const Eigen::VectorXd& x, const Eigen::VectorXd& std);

// Whether the values are possible: a load lies within kReach of its link, a stiffness is positive, and so on.
bool is_sensible(const Candidate& candidate, const Eigen::VectorXd& x);

// Whether an effect is plausible beside any other cause. Every drive has friction and a rotor, and every sensor has a
// zero, which means alone tell. Any other effect may stand in for another cause where most of a mismatch is left.
bool is_expected(const EffectInfo& effect);

}  // namespace hrp::diagnosis::floating

// SPDX-License-Identifier: BSD-3-Clause
// Table of the effects that recordings of a standing robot can show: coefficients, start values, bounds.
#pragma once

#include <utility>
#include <vector>

#include "diagnosis/model/made.h"
#include "diagnosis/standing/terms.h"

namespace hrp::diagnosis::standing {

// Hints where to look for effects that no linear prediction finds, or that only some motions show.
struct StandHints {
  double slip_ratio = 0;                     // friction coefficient at which feet slipped; 0: no slip
  std::vector<std::vector<double>> ripples;  // by joint [1/rad]: angular wave numbers of ripples in the missing effort
  std::vector<double> play;  // by joint [rad]: how far its link must move against its encoder (find_play)
};

// Where apply() writes coefficients that differ from the table's parameters (see StandRow).
struct StandTarget {
  JointTerms* joint = nullptr;
  LinkInertia* link = nullptr;
  std::vector<FootTerms>* feet = nullptr;
};

// Start values of a candidate: pairs of coefficient index and value. The others start at neutral.
using Start = std::vector<std::pair<size_t, double>>;

// An effect of the table in the equations of a standing robot: its fitted coefficients and what a search has to know.
// The effect is absent if the first coefficient is neutral. Residuals are linear in most coefficients:
//   feet: 1/k, c/k of roll, then of pitch, 1/kz, and nuisances: where the centre of the bush truly is
//   (x y z [m] off the nominal), and moments at rest about x and y [N m]; hardening adds one coefficient [1/rad^2]
//   payload: mass, mass x com;  spring: stiffness, moment at position 0;  cogging: sine and cosine amplitude, periods
//   elasticity: 1/stiffness, rotor inertia;  Stribeck: Coulomb, static less Coulomb, velocity, viscous
//   backlash: gap (kMostPlay where no torque ever held the link at an end), and as nuisances rotor inertia and
//   compliance of the teeth; what the link was seen to move where no torque held it at both ends (read off), else 0
// For all other effects the coefficients are the table's parameters, those that are fitted first.
struct StandRow {
  EffectId id;
  Reading reading = Reading::kAll;
  std::vector<double> neutral, step;  // step: of finite differences; 0: read off, not fitted
  void (*apply)(const std::vector<double>& p, const StandTarget& at) = nullptr;  // null: as the table does
  // Converts coefficients and standard deviations back to the table's order; NaN: unknown. Null: they are the same.
  void (*to_table)(std::vector<double>* p, Eigen::VectorXd* std) = nullptr;
  bool positive = false;    // first coefficient must exceed its neutral value
  bool at_drive = false;    // changes only what a drive's effort is compared with, not motion or forces
  bool by_command = false;  // needs recorded commands
  bool noisy = false;       // multiplies a noisy signal: rates, accelerations, efforts, moments
  bool away = false;        // starts far from neutral, where a slope at neutral says nothing
  bool drifts = false;      // the same for starts that are not neutral: clocks drift too far
  int refined = 0;          // iterations of a fit in screening, in place of one linear prediction
  bool all_count = false;   // all coefficients define the effect, not only the first
  bool follows_position = false;
  bool loose = false;            // the position of the link comes from the feet
  bool slides = false;           // visible only if feet slide
  bool tilts_feet = false;       // compliance of ground and sole looks like it
  bool bends_leg = false;        // the same, up to find_bound()
  bool of_transmission = false;  // an elastic transmission contains it
  // An empty list: not a candidate. Null: one start at neutral.
  std::vector<Start> (*list_starts)(const StandProblem&, const StandHints&, size_t place) = nullptr;
  bool (*is_sensible)(const StandProblem&, const Effect&) = nullptr;
  void (*keep)(std::vector<double>* p) = nullptr;  // limits shape coefficients after a step
  double (*find_prior)(const StandProblem&, const Effect&, size_t parameter) = nullptr;
  double (*find_doubt)(const Effect&) = nullptr;
  std::vector<Effect> (*list_richer)(const StandProblem&, const Effect&) = nullptr;
};
std::vector<StandRow> make_rows();  // of all effects (effect_rows.cpp)
const StandRow& get_row(const Effect& effect);

// Candidates that may be added to a hypothesis. Effects with a parameter that no linear fit finds (a Stribeck velocity,
// a wave number of cogging) occur several times, with different start values.
std::vector<Effect> list_candidates(const StandProblem& problem, const Hypothesis& base, const StandHints& hints);

// Richer laws that contain a fitted one, starting at its values. A linear prediction from neutral does not find them.
std::vector<Effect> list_richer(const StandProblem& problem, const Effect& effect);

// True if the candidate starts far from neutral, so that its slope at neutral says nothing.
bool starts_away(const Effect& effect);

// True for one quantity given in components of chosen axes: a force, an offset, a slope.
bool is_vector(const Effect& effect);

// Soft soles at their neutral value.
Effect make_soft_soles(const StandProblem& problem);

// True for parameters that define the effect. Others are fitted as well but may be ill-determined in one recording.
bool is_main(const Effect& effect, size_t parameter);

// True if the effect is physical: positive stiffness, plausible scales.
bool is_sensible(const StandProblem& problem, const Effect& effect);
bool are_sensible(const StandProblem& problem, const Hypothesis& hypothesis);

// Largest compliance [rad/(N m)] of ground and sole about a foot's roll (axis 0) or pitch (axis 1): kRigidTilt about
// the axis with the longer lever, more about the other. find_sinking: the same in height [m/N].
double find_give(const StandFoot& foot, int axis);
double find_sinking(const StandFoot& foot);

// Part of a parameter that compliance of the ground may cause, in the parameter's unit. It looks like soft soles, or
// like elastic transmissions of the leg about the same axis. Only an excess over this bound is certain.
double find_bound(const StandProblem& problem, const Effect& effect, size_t parameter);

// Prior cost [nats] of an effect at this link: logarithm of how much likelier the heaviest link is. Of links that move
// alike (hips and a waist that hardly turns), the heavy one is likely to carry a load. 0 for effects that do not act on
// links.
double find_doubt(const StandProblem& problem, const Effect& effect);

// Standard deviation of the prior of a parameter about its neutral value; 0: no prior.
double find_prior(const StandProblem& problem, const Effect& effect, size_t parameter);

}  // namespace hrp::diagnosis::standing

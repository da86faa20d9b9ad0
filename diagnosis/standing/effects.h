// SPDX-License-Identifier: BSD-3-Clause
// Every effect that a standing robot's recordings may hide: how it is written, started, varied, bounded.
#pragma once

#include <utility>
#include <vector>

#include "diagnosis/standing/terms.h"

namespace hrp::diagnosis::standing {

// Where to look for effects that no linear prediction finds, or that only some motions can show (hints.h).
struct StandHints {
  double slip_ratio = 0;                     // friction at which feet were seen to slip; 0: they were not
  std::vector<std::vector<double>> ripples;  // by joint [1/rad]: how often the missing effort repeats
  std::vector<double> play;                  // by joint [rad]: how far its link would have to move against its encoder
};

// [rad/(N m)] How far ground and sole may give of themselves: feet are taken as rigid above 5e4 N m/rad.
constexpr double kContact = 2e-5;

constexpr double kMostPlay = 0.2;  // [rad] between teeth that somebody would still call a transmission

// Where values of an effect go that are written in coefficients of their own (see StandRow).
struct StandTarget {
  JointTerms* joint = nullptr;
  LinkInertia* link = nullptr;
  std::vector<FootTerms>* feet = nullptr;
};

// Coefficients from which a candidate starts, the others neutral.
using Start = std::vector<std::pair<size_t, double>>;

// How an effect of the table shows in the equations of a standing robot: the coefficients that are fitted, of which the
// first is absent at its neutral value, and what a search has to know. Residuals are linear in most coefficients:
//   feet: 1/k, c/k of roll, then of pitch, 1/kz, and nuisances: where the centre of the bush truly is
//   (x y z [m] off the nominal), and moments at rest about x and y [N m]; hardening adds one coefficient [1/rad^2]
//   payload: mass, mass x com;  spring: stiffness, moment at position 0;  cogging: sine and cosine amplitude, periods
//   elasticity: 1/stiffness, rotor inertia;  Stribeck: Coulomb, static less Coulomb, velocity, viscous
//   backlash: gap (kMostPlay where no torque ever held the link at an end), and as nuisances rotor inertia and
//   compliance of the teeth; what the link was seen to move where no torque held it at both ends (read off), else 0
// All others are the table's parameters, the first of them that are fitted.
struct StandRow {
  EffectId id;
  Reading reading = Reading::kAll;
  std::vector<double> neutral, step;  // step: of finite differences; 0: read off, not fitted
  void (*apply)(const std::vector<double>& p, const StandTarget& at) = nullptr;  // null: the table's
  std::vector<double> (*from_table)(const std::vector<double>& p) = nullptr;  // coefficients from the table's parameters
  // And back, with standard deviations: both in the table's order, the first of them; NaN: not told. Null: the same.
  void (*to_table)(std::vector<double>* p, Eigen::VectorXd* std) = nullptr;
  bool positive = false;      // first coefficient must not fall below its neutral value
  bool at_drive = false;      // leaves motion and forces as they are: changes only what a drive's effort is compared with
  bool by_command = false;    // shows where commands were recorded
  bool noisy = false;         // multiplies a noisy signal: rates, accelerations, efforts, moments
  bool away = false;          // without a neutral start, or far from it: a slope at none says nothing
  bool drifts = false;        // the same where it starts elsewhere than at none: clocks part too far
  int refined = 0;            // so many steps of a fit, instead of one linear prediction, in screening
  bool all_count = false;     // all coefficients define the effect, not the first alone
  bool follows_position = false;
  bool loose = false;         // the link's place is read off the feet
  bool slides = false;        // is seen where feet slide only
  bool tilts_feet = false;    // what ground and sole give looks like it
  bool bends_leg = false;     // the same by how much: find_bound()
  bool of_transmission = false;  // a transmission that gives has it, too
  // None: not a candidate here. Null: from none.
  std::vector<Start> (*list_starts)(const StandProblem&, const StandHints&, size_t place) = nullptr;
  bool (*is_sensible)(const StandProblem&, const Effect&) = nullptr;
  void (*keep)(std::vector<double>* p) = nullptr;  // shapes within bounds after a step
  double (*find_prior)(const StandProblem&, const Effect&, size_t parameter) = nullptr;
  double (*find_doubt)(const Effect&) = nullptr;
  std::vector<Effect> (*list_richer)(const StandProblem&, const Effect&) = nullptr;
};
std::vector<StandRow> make_rows();  // of all effects: effect_rows.cpp
const StandRow* find_row(const Effect& effect);  // null: a standing robot's equations do not show it
const StandRow& get_row(const Effect& effect);

// What may be added to a hypothesis. Effects with a parameter that no linear fit finds (a Stribeck velocity, the
// periods of cogging) come several times, with different starts.
std::vector<Effect> list_candidates(const StandProblem& problem, const Hypothesis& base,
                                         const StandHints& hints);

// Richer laws of the same kind, from where the plain one ended: no linear prediction from nothing finds them.
std::vector<Effect> list_richer(const StandProblem& problem, const Effect& effect);

bool starts_away(const Effect& effect);

// One quantity written in axes that somebody chose: a force, an offset, a slope.
bool is_vector(const Effect& effect);

// Soles that give, from none.
Effect make_soft_soles(const StandProblem& problem);

// Parameters that define an effect; what else is fitted with it may be ill-determined in one recording.
bool is_main(const Effect& effect, size_t parameter);

// Within what can be: positive stiffness, scales that a sensor can have.
bool is_sensible(const StandProblem& problem, const Effect& effect);
bool are_sensible(const StandProblem& problem, const Hypothesis& hypothesis);

// [rad/(N m)] The most that ground and sole give about a foot's roll (axis 0) or pitch: kContact about the sole's short
// edge, more about the long one. Straight down [m/N]: find_sinking.
double find_give(const StandFoot& foot, int axis);
double find_sinking(const StandFoot& foot);

// How much of a parameter the ground may be to blame for, whatever the recordings say: what gives under the feet looks
// like soles, or like transmissions of the leg about the same axis. An effect is sure of what exceeds that only.
double find_bound(const StandProblem& problem, const Effect& effect, size_t parameter);

// Minus the logarithm of how much likelier than here an effect of this kind is at the likeliest place, before anything
// is recorded: of links that move alike (hips and a waist that hardly turns) the heavy one carries the load.
double find_doubt(const StandProblem& problem, const Effect& effect);

// Standard deviation of what is known beforehand of a parameter about its neutral value; 0: nothing.
double find_prior(const StandProblem& problem, const Effect& effect, size_t parameter);

}  // namespace hrp::diagnosis::standing

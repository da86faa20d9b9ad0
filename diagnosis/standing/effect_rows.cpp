// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "common/effects/link_law.h"
#include "common/spatial/gravity.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/model/link_reach.h"
#include "diagnosis/standing/effect_rows.h"
#include "diagnosis/standing/layout.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kPlumb = 0.02;  // [rad] accuracy of a robot's vertical

// Noise [N m] of a joint's effort equation; 0 while it is unknown.
double find_noise(const StandProblem& problem, int joint) {
  return problem.noise.empty() ? 0 : problem.noise[find_drive(problem, static_cast<size_t>(joint))];
}

// Largest distance [m] of a wrong centre of mass: twice the edge of a cube with the link's mass and half the density of
// water. Half of it is the standard deviation of the prior. An upright robot hardly determines the height of a centre
// of mass, so the prior decides.
double find_size(const StandProblem& problem, int link) {
  return 2 * std::cbrt(problem.tree.links[static_cast<size_t>(link)].inertia.mass / 500);
}

Vector3d get3(const std::vector<double>& p) { return {p[0], p[1], p[2]}; }

// ---- How coefficients act that differ from the table's parameters --------------------------------------------------

void apply_stribeck(const std::vector<double>& p, const StandTarget& at) {
  JointLaws& laws = at.joint->laws;
  laws.coulomb += p[0];
  at.joint->excess += p[1];
  laws.stribeck_velocity = p[2];
  laws.viscous += p[3];
}

void apply_spring(const std::vector<double>& p, const StandTarget& at) {
  at.joint->laws.spring_stiffness += p[0];
  at.joint->moment += p[1];
}

void apply_cogging(const std::vector<double>& p, const StandTarget& at) {
  at.joint->cogging_sin = p[0];
  at.joint->cogging_cos = p[1];
  at.joint->laws.cogging_periods = p[2];
}

void apply_elasticity(const std::vector<double>& p, const StandTarget& at) {
  at.joint->compliance += p[0];
  at.joint->laws.motor_inertia += p[1];
}

void apply_backlash(const std::vector<double>& p, const StandTarget& at) {
  at.joint->laws.gap = p[0];
  at.joint->laws.motor_inertia += p[1];
  at.joint->compliance += p[2];
}

void apply_mass(const std::vector<double>& p, const StandTarget& at) {
  scale_mass(std::max(1e-6, p[0]), at.link);  // a step of a fit may go too far
}

// A payload as mass and mass x com, in which forces are linear. A step of a fit may give a moment without mass, or a
// mass far outside the robot. Its inertia would mean nothing and is then left out.
void apply_payload(const std::vector<double>& p, const StandTarget& at) {
  constexpr double kFar = 2.0;  // [m]
  const Vector3d moment(p[1], p[2], p[3]);
  if (p[0] > 0 && moment.norm() < kFar * p[0]) return add_payload(p[0], moment / p[0], 0.0, at.link);
  const Vector3d sum = at.link->mass * at.link->p_LLcm_L + moment;
  at.link->mass = std::max(1e-6, at.link->mass + p[0]);
  at.link->p_LLcm_L = sum / at.link->mass;
}

template <bool kHard>
void apply_soles(const std::vector<double>& all, const StandTarget& at) {
  const size_t size = kFootParameters + (kHard ? 1 : 0);
  for (size_t f = 0; f < at.feet->size(); ++f) {
    const double* p = &all[f * size];
    FootTerms& foot = (*at.feet)[f];
    foot.soft = true;
    for (int a = 0; a < 2; ++a) {
      foot.inverse_k[a] = p[2 * a];
      foot.c_over_k[a] = p[2 * a + 1];
      foot.moment[a] = p[8 + a];
    }
    foot.inverse_kz = p[4];
    foot.shift = {p[5], p[6], p[7]};
    if (kHard) foot.hardening = p[kFootParameters];
  }
}

// ---- Back to the table's parameters, with standard deviations to first order ---------------------------------------

using Values = std::vector<double>;

void tell_stribeck(Values* p, Eigen::VectorXd* std) {
  (*p)[1] += (*p)[0];
  (*std)(1) = std::hypot((*std)(0), (*std)(1));
}

void tell_spring(Values* p, Eigen::VectorXd* std) {
  const double k = (*p)[0], rest = -(*p)[1] / k;
  (*p)[1] = rest;
  (*std)(1) = std::hypot((*std)(1), rest * (*std)(0)) / k;
}

void tell_cogging(Values* p, Eigen::VectorXd* std) {
  const double phase = std::atan2((*p)[1], (*p)[0]), amplitude = std::hypot((*p)[0], (*p)[1]),
               s = std::max((*std)(0), (*std)(1));
  *p = {amplitude, (*p)[2], phase < 0 ? phase + 2 * M_PI : phase};
  *std = Eigen::Vector3d(s, (*std)(2), s / std::max(1e-9, amplitude));
}

void tell_elasticity(Values* p, Eigen::VectorXd* std) {
  *std = Eigen::Vector3d((*std)(0) / ((*p)[0] * (*p)[0]), 0, (*std)(1));
  *p = {1 / (*p)[0], std::nan(""), (*p)[1]};
}

// If no torque held the link at both ends, the gap is at least the observed motion.
void tell_backlash(Values* p, Eigen::VectorXd*) { *p = {(*p)[3] > 0 ? (*p)[3] : (*p)[0]}; }

void tell_payload(Values* p, Eigen::VectorXd* std) {
  for (size_t i = 1; i < 4; ++i) {  // written as mass x com
    const long at = static_cast<long>(i);
    (*p)[i] /= (*p)[0];
    (*std)(at) = std::hypot((*std)(at), (*p)[i] * (*std)(0)) / (*p)[0];
  }
}

// ---- Start values of effects that no linear prediction from neutral finds ------------------------------------------

// Torque limits within the range of the logged efforts.
std::vector<Start> list_limits(const StandProblem& p, const StandHints&, size_t joint) {
  if (!p.effort[joint]) return {};
  double most = 0;
  for (const StandRecording& r : p.recordings) {
    for (double u : r.effort[joint].value) most = std::max(most, std::abs(u));
  }
  return list_at(0, {0.95 * most, 0.8 * most, 0.6 * most, 0.4 * most});
}

// ---- Rows ---------------------------------------------------------------------------------------------------------

// A row of an effect in the drive alone, whose first coefficient is positive.
StandRow make_drive_row(EffectId id, std::vector<double> neutral, std::vector<double> step) {
  StandRow row = make_row(id, std::move(neutral), std::move(step), true);
  row.at_drive = true;
  return row;
}

StandRow make_coulomb() {
  StandRow row = make_drive_row(EffectId::kCoulomb, {0, 0}, {0.1, 0.02});
  row.is_sensible = [](const StandProblem&, const Effect& e) { return std::abs(e.p[1]) < 1; };
  row.list_richer = [](const StandProblem&, const Effect& e) {
    std::vector<Effect> out;
    for (const EffectInfo& richer : list_effects()) {
      if (!richer.dry || !has_part(richer.id, e.id)) continue;
      for (double v : {0.03, 0.1, 0.3}) out.push_back({richer.id, e.place, {0.7 * e.p[0], 0.5 * e.p[0], v, 0}});
    }
    return out;
  };
  return row;
}

StandRow make_stribeck() {
  StandRow row = make_drive_row(EffectId::kStribeck, {0, 0, 0.1, 0}, {0.1, 0.1, 1e-3, 0.1});
  row.apply = &apply_stribeck;
  row.to_table = &tell_stribeck;
  row.is_sensible = [](const StandProblem&, const Effect& e) { return e.p[1] > 0 && e.p[2] > 0.005 && e.p[2] < 1; };
  row.keep = [](std::vector<double>* p) { (*p)[2] = std::clamp((*p)[2], 0.01, 0.5); };  // [rad/s]
  row.list_starts = [](const StandProblem&, const StandHints&, size_t) {
    return list_at(2, {0.03, 0.08, 0.2});
  };  // [rad/s]
  return row;
}

StandRow make_load_friction() {
  StandRow row = make_drive_row(EffectId::kLoadFriction, {0}, {0.01});
  row.is_sensible = [](const StandProblem&, const Effect& e) { return e.p[0] < 1; };
  return row;
}

StandRow make_hysteresis() {
  StandRow row = make_drive_row(EffectId::kHysteresis, {0, 0.02}, {1, 1e-4});
  row.follows_position = true;
  row.is_sensible = [](const StandProblem&, const Effect& e) { return e.p[1] > 1e-3 && e.p[1] < 0.5; };
  row.keep = [](std::vector<double>* p) { (*p)[1] = std::clamp((*p)[1], 2e-3, 0.3); };                        // [rad]
  row.list_starts = [](const StandProblem&, const StandHints&, size_t) { return list_at(1, {0.01, 0.04}); };  // [rad]
  return row;
}

StandRow make_spring() {
  StandRow row = make_drive_row(EffectId::kSpring, {0, 0}, {1, 0.1});
  row.apply = &apply_spring;
  row.to_table = &tell_spring;
  row.follows_position = true;
  return row;
}

StandRow make_cogging() {
  StandRow row = make_drive_row(EffectId::kCogging, {0, 0, 1}, {0.1, 0.1, 0.01});
  row.apply = &apply_cogging;
  row.to_table = &tell_cogging;
  row.positive = false;
  row.all_count = true;
  row.list_starts = [](const StandProblem&, const StandHints& hints, size_t j) { return list_at(2, hints.ripples[j]); };
  return row;
}

StandRow make_saturation() {
  StandRow row = make_drive_row(EffectId::kSaturation, {1e300}, {0.01});
  row.positive = false;
  row.away = true;
  // If a drive gives less than the noise, nothing tells what limits it.
  row.is_sensible = [](const StandProblem& problem, const Effect& e) {
    return e.p[0] > kAboveNoise * find_noise(problem, e.place.index);
  };
  row.list_starts = &list_limits;
  return row;
}

void keep_rotor(std::vector<double>* p) { (*p)[1] = std::max((*p)[1], 0.0); }  // [kg m^2]

StandRow make_elasticity() {
  StandRow row = make_row(EffectId::kElasticity, {0, 0}, {1e-6, 0.01}, true);
  row.apply = &apply_elasticity;
  row.to_table = &tell_elasticity;
  row.keep = &keep_rotor;
  row.noisy = row.bends_leg = true;
  return row;
}

StandRow make_backlash() {
  StandRow row = make_row(EffectId::kBacklash, {0, 0, 0, 0}, {1e-3, 0.01, 1e-6, 0}, true);
  row.apply = &apply_backlash;
  row.to_table = &tell_backlash;
  row.keep = &keep_rotor;
  row.away = row.loose = true;
  row.refined = 1;
  // A smaller gap is below the resolution of encoders.
  row.is_sensible = [](const StandProblem&, const Effect& e) { return e.p[0] > 1e-4; };
  // [rad/(N m)] The compliance of the teeth is below that of the servo, as it would oscillate otherwise.
  row.find_prior = [](const StandProblem& problem, const Effect& e, size_t parameter) {
    return parameter == 2
               ? 0.3 /
                     std::max(1.0,
                              get_servo_gains(problem.experiment->scenario, problem.tree.joint(e.place.index).name).kp)
               : 0.0;
  };
  row.list_starts = [](const StandProblem&, const StandHints& hints, size_t j) {
    return hints.play[j] > 0 ? list_at(0, {kSeveralTimes * hints.play[j]}) : std::vector<Start>{};
  };
  return row;
}

StandRow make_joint_offset() {
  StandRow row = make_row(EffectId::kJointOffset, {0}, {1e-3});
  row.keep = [](std::vector<double>* p) { (*p)[0] = std::clamp((*p)[0], -0.3, 0.3); };  // [rad]
  row.tilts_feet = true;
  return row;
}

StandRow make_payload() {
  StandRow row = make_row(EffectId::kPayload, {0, 0, 0, 0}, {0.1, 0.01, 0.01, 0.01}, true);
  row.apply = &apply_payload;
  row.to_table = &tell_payload;
  row.noisy = true;
  // It hangs on the robot.
  row.is_sensible = [](const StandProblem& problem, const Effect& e) {
    const Vector3d moment(e.p[1], e.p[2], e.p[3]);
    return moment.norm() < e.p[0] * calc_carried_reach(problem.tree, e.place.index);
  };
  return row;
}

StandRow make_mass_error() {
  StandRow row = make_row(EffectId::kMassError, {1}, {0.01});
  row.apply = &apply_mass;
  row.noisy = row.all_count = true;
  return row;
}

StandRow make_com_error() {
  StandRow row = make_row(EffectId::kComError, {0, 0, 0}, {1e-3, 1e-3, 1e-3});
  row.noisy = row.all_count = true;
  row.is_sensible = [](const StandProblem& problem, const Effect& e) {
    return get3(e.p).norm() < find_size(problem, e.place.index);
  };
  row.find_prior = [](const StandProblem& problem, const Effect& e, size_t) {
    return 0.5 * find_size(problem, e.place.index);
  };
  return row;
}

StandRow make_force() {
  StandRow row = make_row(get_effect_of(PlaceKind::kLink, EffectFamily::kZero).id, {0, 0, 0}, {1, 1, 1});
  row.all_count = true;
  // A random direction is vertical within an angle with a probability of half its square. A vertical force is therefore
  // more likely to be a weight.
  row.find_doubt = [](const Effect& e) {
    const Vector3d force = get3(e.p);
    const double angle = std::max(kPlumb, force.head<2>().norm() / std::max(1e-9, force.norm()));
    return -std::log(0.5 * angle * angle);
  };
  return row;
}

double find_sole_prior(const StandProblem& problem, const Effect& e, size_t parameter) {
  const size_t size = get_row(e).step.size(), at = parameter % size;
  const StandFoot& foot = problem.feet[parameter / size];
  if (at == 5 || at == 6) return 0.02;  // [m] the bush is near the sole's centre
  if (at == 7) return 0.01;             // [m] about half the height of a sole
  // [N m] Moment of the foot's weight: the part of the foot above the bush is not known.
  if (at == 8 || at == 9) return foot.mass * kGravity * (0.5 * (foot.com - foot.bush).head<2>().norm() + 0.005);
  return 0;
}

std::vector<Effect> list_hard_soles(const StandProblem& problem, const Effect& e) {
  Effect hard{EffectId::kFootHardening, e.place, {}};
  for (size_t f = 0; f < problem.feet.size(); ++f) {
    const auto begin = e.p.begin() + static_cast<long>(f * kFootParameters);
    hard.p.insert(hard.p.end(), begin, begin + kFootParameters);
    hard.p.push_back(0);
  }
  return {hard};
}

std::vector<StandRow> make_sole_rows() {
  const std::vector<double> step{1e-5, 1e-5, 1e-5, 1e-5, 1e-8, 1e-3, 1e-3, 1e-3, 0.01, 0.01};
  StandRow soft = make_row(EffectId::kFootCompliance, std::vector<double>(kFootParameters, 0), step);
  soft.apply = &apply_soles<false>;
  soft.noisy = true;
  soft.find_prior = &find_sole_prior;
  StandRow hard = soft;
  soft.list_richer = &list_hard_soles;
  hard.id = EffectId::kFootHardening;
  hard.apply = &apply_soles<true>;
  hard.neutral.push_back(0);
  hard.step.push_back(10);
  return {soft, hard};
}

std::vector<StandRow> make_ground_rows() {
  StandRow slope = make_row(EffectId::kGroundSlope, {0, 0}, {1e-3, 1e-3});
  slope.all_count = slope.tilts_feet = true;
  StandRow friction = make_row(EffectId::kGroundFriction, {0}, {0});
  friction.all_count = friction.away = friction.slides = true;
  friction.list_starts = [](const StandProblem&, const StandHints& hints, size_t) {
    return hints.slip_ratio > 0 ? list_at(0, {hints.slip_ratio}) : std::vector<Start>{};
  };
  return {slope, friction};
}

}  // namespace

StandRow make_row(EffectId id, std::vector<double> neutral, std::vector<double> step, bool positive) {
  StandRow row;
  row.id = id;
  row.neutral = std::move(neutral);
  row.step = std::move(step);
  row.positive = positive;
  return row;
}

std::vector<Start> list_at(size_t coefficient, const std::vector<double>& values) {
  std::vector<Start> out;
  for (double value : values) out.push_back({{coefficient, value}});
  return out;
}

std::vector<StandRow> make_rows() {
  StandRow viscous = make_drive_row(get_effect_of(PlaceKind::kJoint, EffectFamily::kSpeedLoss).id, {0}, {0.1});
  StandRow rotor = make_drive_row(get_effect_of(PlaceKind::kJoint, EffectFamily::kReflectedInertia).id, {0}, {0.01});
  StandRow gain = make_drive_row(get_effect_of(PlaceKind::kJoint, EffectFamily::kGain).id, {1}, {0.01});
  StandRow late = make_drive_row(EffectId::kDelay, {0}, {1e-3}), lag = make_drive_row(EffectId::kLag, {0}, {1e-3});
  viscous.noisy = rotor.noisy = gain.noisy = lag.noisy = true;
  gain.positive = false;
  late.by_command = true;
  rotor.of_transmission = true;
  std::vector<StandRow> rows{viscous,
                             make_coulomb(),
                             make_stribeck(),
                             make_load_friction(),
                             rotor,
                             make_spring(),
                             gain,
                             make_saturation(),
                             make_cogging(),
                             make_hysteresis(),
                             late,
                             lag,
                             make_elasticity(),
                             make_backlash(),
                             make_joint_offset(),
                             make_payload(),
                             make_mass_error(),
                             make_com_error(),
                             make_force()};
  for (const auto& more : {make_sole_rows(), make_ground_rows()}) rows.insert(rows.end(), more.begin(), more.end());
  add_sensor_rows(&rows);
  return rows;
}

}  // namespace hrp::diagnosis::standing

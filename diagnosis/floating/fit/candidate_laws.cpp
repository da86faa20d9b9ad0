// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/candidate_laws.h"

#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/floating/fit/law_values.h"
#include "diagnosis/floating/fit/least_squares.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kLowScale = -0.9, kHighScale = 4;  // of a factor less 1: from a tenth to five times

CandidateLaw make_plain_law(EffectId effect) {
  CandidateLaw law{&make_plain};
  law.effect = effect;
  return law;
}

CandidateLaw make_positive(EffectId effect) {
  CandidateLaw law = make_plain_law(effect);
  law.positive = true;
  return law;
}

// A factor.
CandidateLaw make_scale(EffectId effect, double least) {
  CandidateLaw law = make_plain_law(effect);
  law.low = kLowScale;
  law.high = kHighScale;
  law.least = least;
  return law;
}

// A time; its least value depends on the recording's sample time.
CandidateLaw make_late(EffectId effect) {
  CandidateLaw law = make_positive(effect);
  law.high = kLatest;
  law.linearized = true;
  return law;
}

CandidateLaw make_angle(EffectId effect) {
  CandidateLaw law = make_plain_law(effect);
  law.vector = true;
  law.is_sensible = &is_small_angle;
  return law;
}

void add_link_laws(LawTable* t) {
  t->payload = make_positive(EffectId::kPayload);
  t->payload.make_estimates = &make_payload;
  t->payload.is_sensible = &is_payload_near;
  t->payload.refine = &refine_payload;
  // Its least value depends on the link's share of the robot's mass
  t->mass_error = make_scale(EffectId::kMassError, 0);
  t->mass_error.low = std::exp(-kFactor) - 1;
  t->mass_error.high = std::exp(kFactor) - 1;  // a log may have another unit, a mass not
  t->com_error = make_plain_law(EffectId::kComError);
  t->com_error.vector = true;
  t->com_error.is_sensible = &is_mass_within_link;
  t->com_error.refine = &refine_moved_mass;
}

void add_joint_laws(LawTable* t) {
  t->joint_offset = make_angle(EffectId::kJointOffset);
  t->joint_offset.least = kCalibrated;
  t->backlash = make_positive(EffectId::kBacklash);
  t->backlash.least = kCalibrated;
  t->backlash.high = kMostPlay;
  t->elasticity = make_positive(EffectId::kElasticity);
  t->elasticity.make_estimates = &make_elasticity;
  t->elasticity.is_sensible = &is_stiff_enough;
  t->viscous = make_positive(get_effect_of(PlaceKind::kJoint, EffectFamily::kSpeedLoss).id);
  t->coulomb = make_positive(EffectId::kCoulomb);
  // Nothing turns a gear back that loses half of its effort: legs give way to their load. Where friction is most of the
  // effort, that share of the effort predicts it, whatever its law.
  t->load_friction = make_positive(EffectId::kLoadFriction);
  t->load_friction.high = kHalf;
  t->rotor_inertia = make_positive(get_effect_of(PlaceKind::kJoint, EffectFamily::kReflectedInertia).id);
  t->torque_constant = make_scale(get_effect_of(PlaceKind::kJoint, EffectFamily::kGain).id, kKnown);
  t->spring = make_positive(EffectId::kSpring);
  t->spring.make_estimates = &make_spring;
  t->spring.worth = kKnown;
  t->lag = make_late(EffectId::kLag);
  t->delay = make_late(EffectId::kDelay);
}

void add_sensor_laws(LawTable* t) {
  t->sensor_bias = make_plain_law(get_effect_of(PlaceKind::kSensor, EffectFamily::kZero).id);
  t->sensor_bias.vector = true;
  t->sensor_scale = make_scale(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain).id, kExactShare);
  t->sensor_delay = make_late(get_late_reading().id);
  t->sensor_misalignment = make_angle(get_effect_of(PlaceKind::kSensor, EffectFamily::kSensorGeometry).id);
  t->sensor_misalignment.linearized = true;
}

// Drives of one kind have one torque constant, or one error of it.
void add_effort_laws(LawTable* t) {
  t->effort_scale = make_scale(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain).id, kKnown);
  t->effort_scale.make_estimates = &make_reading_scale;
}

void add_ground_laws(LawTable* t) {
  t->flat_sole = make_plain_law(EffectId::kFootCompliance);
  t->point_foot = t->flat_sole;
  t->flat_sole.make_estimates = &make_flat_sole;
  t->flat_sole.is_sensible = &is_soft_sole;
  t->flat_sole.core = {kRollGiveColumn, kPitchGiveColumn};
  t->flat_sole.refine = &refine_sole;
  t->point_foot.make_estimates = &make_point_foot;
  t->point_foot.is_sensible = &is_soft_point;
  t->point_foot.positive = true;
  t->ground_slope = make_angle(EffectId::kGroundSlope);
}

void add_free_laws(LawTable* t) {
  t->bend = {&make_bend};
  t->pull = {&make_pull};
  t->hold = {&make_hold};
  for (CandidateLaw* law : {&t->bend, &t->pull, &t->hold}) law->vector = true;
  t->bend.is_sensible = &is_bend;
  t->bend.unlisted = "what carries the joint bends about an axis across it";
  t->pull.unlisted = "something from outside pulls here, by where the robot is";
  t->hold.unlisted = "something holds the foot to the ground that its force sensor does not feel";
}

LawTable make_table() {
  LawTable out{};
  add_link_laws(&out);
  add_joint_laws(&out);
  add_sensor_laws(&out);
  add_effort_laws(&out);
  add_ground_laws(&out);
  add_free_laws(&out);
  return out;
}

}  // namespace

const LawTable& get_laws() {
  static const LawTable table = make_table();
  return table;
}

}  // namespace hrp::diagnosis::floating

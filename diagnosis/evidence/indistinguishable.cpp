// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/indistinguishable.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/held_commands.h"
#include "diagnosis/evidence/torque/gears.h"
#include "diagnosis/measurement/torque/term_rows.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis {
namespace {

// Travel [rad] that contains at least three periods of the torque ripple of a geared motor. Within less travel, ripple
// (cogging) can look like a bias and becomes an alternative.
constexpr double kManyPeriods = 0.5;
const char* const kMotion = "constant speeds from the slowest on, in both directions";
const char* const kWarmth =
    "the same motion cold and warm: an asymmetry changes with the friction, a constant torque does not";
const char* const kSides = "postures whose weight pulls the joint to the other side";
const char* const kCommands =
    "record the commands and the servo's gains, or weigh the effort at rest with a known mass";

Where make_log_place(const Experiment& e, int joint, Quantity quantity = Quantity::kEffort) {
  return {{"sensor", e.signal_name(joint, quantity)}};
}

// Without values where the motion is too fast to tell the friction at rest.
std::vector<Estimate> make_curve(const DryCurve& curve) {
  if (curve.rest.low <= 0.0) return {};
  return {make_ranged("coulomb", "N m", curve.level, 0.0), make_ranged("static", "N m", curve.rest, 0.0),
          make_ranged("stribeck_velocity", "rad/s", curve.velocity, 0.0)};
}

// Coulomb friction of level x (1 +- asymmetry) equals symmetric friction of that level and a constant torque of level x
// asymmetry. With |asymmetry| > 1, friction would change its sign.
void add_asymmetry(const Where& joint, const GradedTerm& constant, const GradedTerm& level,
                   std::vector<Alternative>* list) {
  const double c = level.parameters[0], share = constant.parameters[0] / c;
  if (!(c > 0.0) || std::abs(share) > 1.0) return;
  const double width = std::hypot(constant.width[0], share * level.width[0]) / c;
  list->push_back(make_alternative(
      get_effect(EffectId::kCoulomb), joint,
      {make_one("level", "N m", c, level.width[0]), make_one("asymmetry", "1", share, width)}, kWarmth));
}

// Root mean square residual of the comparison `of`, before and after the correction of a fault.
struct Missed {
  double before, after;
  std::string unit;
  const char* of;
};

// A finding for one of a joint's columns that another column contradicts.
Finding make_column_finding(const Experiment& e, int joint, Quantity column, EffectId id, const Estimate& estimate,
                            const Missed& missed, const std::string& words) {
  Finding f = make_finding(get_effect(id), make_log_place(e, joint, column), {estimate});
  f.grade = Grade::kSupported;
  f.probability = kSurest;
  f.share = std::clamp(1.0 - std::pow(missed.after / std::max(1e-300, missed.before), 2), 0.0, 1.0);
  const std::string unit = std::string(" ") + missed.unit;
  f.statement = e.robot.tree.joint(joint).name + ": " + words + ". " + missed.of + " by " + number(missed.after, 3) +
                unit + " (root mean square) with it, by " + number(missed.before, 3) + unit + " without.";
  return f;
}

// True if the load of a joint hardly ever changes sides.
bool is_one_sided(const TorqueData& data, int joint) {
  double up = 0.0, all = 0.0;
  for (const TorqueRecording& r : data.recordings) {
    for (long k = 0; k < r.kept(); ++k) {
      if (r.use(k, joint)) {
        up += r.tau(r.full_row(k), joint) > 0.0 ? 1.0 : 0.0;
        all += 1.0;
      }
    }
  }
  return std::min(up, all - up) < kMinority * all;
}

// Under a load that keeps its side the teeth touch on one side: the link is half a gap from where its encoder says.
void add_play(const TorqueData& data, const GradedTerm& g, std::vector<Alternative>* list) {
  const auto add = [&](const Term& zero, const Eigen::VectorXd& offset, const Eigen::VectorXd& width) {
    if (zero.effect().id != EffectId::kJointOffset) return;  // the place of another term may be a link, or the base
    const JointSpec& joint = data.experiment->robot.tree.joint(zero.place);
    const bool turns = joint.actuated && joint.kind == JointKind::kRevolute;
    if (!turns || 2.0 * std::abs(offset[0]) > kMostPlay || !is_one_sided(data, zero.place)) return;
    list->push_back(make_alternative(get_effect(EffectId::kBacklash), {{"joint", joint.name}},
                                     {make_one("gap", "rad", 2.0 * std::abs(offset[0]), 2.0 * width[0])}, kSides));
  };
  add(g.term, g.parameters, g.width);
  for (const Rival& r : g.rivals) add(r.term, r.parameters, r.width);
}

// Gear and gain: see the header.
Alternative make_loaded_friction(const Where& joint, const GradedTerm& gear) {
  const double r = gear.parameters[0], mu = calc_loaded_friction(r), slope = calc_loaded_friction_slope(r);
  const std::string motion = "a known mass lifted: beside such friction the torque constant is " +
                             number(1.0 / (1.0 - mu), 3) + " times the stated one";
  return make_alternative(*find_effect("load_dependent_friction"), joint,
                          {make_one("ratio", "1", mu, slope * gear.width[0])}, motion);
}

}  // namespace

Estimate make_ranged(const char* name, const std::string& unit, const Range& r, double deviation) {
  const double reach = std::max(r.high - r.value, r.value - r.low) / kNinetyFive;
  return make_one(name, unit, r.value, std::hypot(reach, deviation));
}

std::vector<Alternative> list_indistinguishable(const TorqueData& data, const GradedTerm& g, const GradedTerm* excess,
                                                const GradedTerm* level) {
  std::vector<Alternative> alternatives;
  const Experiment& e = *data.experiment;
  const int j = g.term.place;
  const Where joint = {{"joint", g.term.whole() ? std::string() : e.robot.tree.joint(j).name}};
  const bool driven = g.term.whole() || e.robot.tree.joint(j).actuated;
  const bool of_log = !g.term.whole() && driven && data.source[static_cast<size_t>(j)] == EffortSource::kRecorded &&
                      !data.servo[static_cast<size_t>(j)].follows;
  if (g.term.row->scales_effort && of_log) {
    const double gain = 1.0 - g.parameters[0];
    alternatives.push_back(make_alternative(get_effect(EffectId::kSensorScale), make_log_place(e, j),
                                            {make_one("scale", "1", 1.0 / gain, g.width[0] / (gain * gain))},
                                            kCommands));
  }
  if (g.term.row->is_constant() && of_log)
    alternatives.push_back(make_alternative(get_effect(EffectId::kSensorBias), make_log_place(e, j),
                                            {make_one("value", "N m", g.parameters[0], g.width[0])}, kCommands));
  if (g.term.row->is_constant() && !driven && !data.feet.empty() && e.robot.tree.joint(j).kind == JointKind::kPrismatic)
    alternatives.push_back(make_alternative(
        get_effect(EffectId::kSensorBias), {{"sensor", "/wrench/" + data.feet[0].sensor + "/force"}},
        {make_one("value", "N", std::abs(g.parameters[0]), g.width[0])}, "the foot lifted off the sensor"));
  if (g.balanced >= 0)
    alternatives.push_back(make_alternative(get_effect(EffectId::kSpring),
                                            {{"joint", e.robot.tree.joint(g.balanced).name}}, {},
                                            "a look at the joint: what balances its weight?"));
  if (g.term.row->backwards && g.parameters[0] > 0.0) alternatives.push_back(make_loaded_friction(joint, g));
  if (g.term.row->is_constant() && level) add_asymmetry(joint, g, *level, &alternatives);
  add_play(data, g, &alternatives);
  if (g.term.row->level && excess && excess->grade == Grade::kAmbiguous)
    alternatives.push_back(make_alternative(get_effect(EffectId::kCoulomb), joint,
                                            {make_one("level", "N m", g.parameters[0], g.width[0])}, kMotion));
  if (g.term.row->level && !excess && g.curve.there && g.curve.level.value > 0.0 &&
      g.curve.rest.high - g.curve.level.value > kDetail * g.curve.level.value)
    alternatives.push_back(make_alternative(get_effect(EffectId::kStribeck), joint, make_curve(g.curve), kMotion));
  return alternatives;
}

Alternative make_gear_alternative(const TorqueData& data, const GradedTerm& mass, const GradedTerm& friction) {
  const double mu = friction.parameters[0], slope = 2.0 / ((1.0 + mu) * (1.0 + mu));
  const double k = calc_gear_gain(mass, friction);
  const std::string motion =
      "a known mass lifted: beside such a gear the torque constant is " + number(k, 3) + " times the stated one";
  return make_alternative(*find_effect("backdriving_friction"),
                          {{"joint", data.experiment->robot.tree.joint(friction.term.place).name}},
                          {make_one("ratio", "1", calc_backward_loss(mu), slope * friction.width[0])}, motion);
}

std::vector<Finding> make_log_findings(const Experiment& e, int joint, const ServoReading& log) {
  const std::string unit = get_joint_unit(e.robot.tree.joint(joint), "N m");
  std::vector<Finding> list;
  const auto add = [&](EffectId id, const Estimate& estimate, const std::string& words) {
    list.push_back(make_column_finding(e, joint, Quantity::kEffort, id, estimate,
                                       {log.before, log.after, unit, "The servo's law misses the log"}, words));
    list.back().weight = list.back().share;
  };
  if (log.is_scaled()) {
    add(EffectId::kSensorScale, make_one("scale", "1", log.scale, log.scale_std),
        "the recorded effort is " + number(log.scale, 4) + " times what the servo asks for");
    list.back().alternatives.push_back(
        make_alternative(get_effect(EffectId::kTorqueConstant), {{"joint", e.robot.tree.joint(joint).name}},
                         {make_one("scale", "1", log.scale, log.scale_std)},
                         "the stated gains may be wrong instead: hold a known mass and read the effort"));
  }
  // A ripple has a mean over any limited range of positions.
  if (!log.is_biased() || std::abs(log.bias) < kAboveNoise * log.wavers) return list;
  add(EffectId::kSensorBias, make_one("value", unit, log.bias, log.bias_std),
      "the recorded effort is " + number(log.bias, 3) + " " + unit + " off what the servo asks for");
  if (log.travel > kManyPeriods) return list;
  list.back().grade = Grade::kAmbiguous;
  list.back().alternatives.push_back(
      make_alternative(get_effect(EffectId::kCogging), {{"joint", e.robot.tree.joint(joint).name}},
                       {make_one("amplitude", unit, std::abs(log.bias), log.bias_std)},
                       "wide motions of this joint: a ripple changes its sign within them"));
  return list;
}

std::vector<Finding> make_velocity_findings(const Experiment& e, int joint, const std::vector<VelocityReading>& logs) {
  const VelocityReading& log = logs[static_cast<size_t>(joint)];
  const std::string position = e.signal_name(joint, Quantity::kPosition),
                    velocity = e.signal_name(joint, Quantity::kVelocity);
  const std::string unit = get_joint_unit(e.robot.tree.joint(joint), "rad/s");
  std::vector<Finding> list;
  const auto add = [&](EffectId id, Quantity of, const Estimate& estimate, const std::string& words) {
    list.push_back(make_column_finding(
        e, joint, of, id, estimate, {log.before, log.after, unit, "The position's rate misses the velocity"}, words));
    list.back().weight = 0.0;  // does not change the missing torque
  };
  if (log.is_scaled()) {
    const double rippling = calc_rippling_inertia(e, joint, log.scale);
    add(EffectId::kSensorScale, Quantity::kVelocity, make_one("scale", "1", log.scale, log.scale_std),
        "the recorded velocity is " + number(log.scale, 4) + " times the rate of the recorded position" +
            (rippling > 0.0 ? "; if the servo holds its commands between two samples and turns " + number(rippling, 2) +
                                  " kg m^2, the velocity is that at their instants"
                            : ""));
    if (rippling > 0.0) list.back().grade = Grade::kAmbiguous;
    list.back().alternatives.push_back(
        make_alternative(get_effect(EffectId::kSensorScale), make_log_place(e, joint, Quantity::kPosition),
                         {make_one("scale", "1", 1.0 / log.scale, log.scale_std / (log.scale * log.scale))},
                         "two positions of the joint measured by hand"));
    if (may_be_clock(logs, log)) {
      list.back().grade = Grade::kAmbiguous;
      list.back().alternatives.push_back(
          make_alternative(get_effect(EffectId::kClockSkew), make_log_place(e, joint, Quantity::kPosition),
                           {make_one("skew", "1", 1.0 / log.scale - 1.0, log.scale_std / (log.scale * log.scale))},
                           "one motion timed by a second clock: the stamps of all joints may be off alike"));
    }
  }
  if (log.is_biased())
    add(EffectId::kSensorBias, Quantity::kVelocity, make_one("value", unit, log.bias, log.bias_std),
        velocity + " is " + number(log.bias, 3) + " " + unit + " off the rate of the position");
  if (log.is_late())
    add(EffectId::kSensorDelay, Quantity::kVelocity, make_one("delay", "s", log.late, log.late_std),
        velocity + (log.late > kLongest
                        ? " is the rate of the position behind a filter with a time constant of " +
                              number(1e3 * log.late, 3) + " ms"
                        : " is " + number(1e3 * log.late, 3) + " ms later than the rate of the position"));
  if (log.is_position_late())
    add(EffectId::kSensorDelay, Quantity::kPosition, make_one("delay", "s", -log.late, log.late_std),
        position + " is " + number(-1e3 * log.late, 3) + " ms later than the velocity");
  return list;
}

}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/lookalikes.h"

#include <algorithm>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/floating/equations/imu_rows.h"
#include "diagnosis/floating/equations/joint_turns.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/remaining.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr const char* kBends = "link_bending";  // an alternative that the table of effects does not hold

const LawTable& laws() { return get_laws(); }

bool is(const FoundEffect& f, const CandidateLaw& law) { return f.effect.law == &law; }

void add(const CandidateLaw& law, const Where& where, const char* motion, Finding* f) {
  const std::string& name = law.info().name;
  const bool there = std::any_of(f->alternatives.begin(), f->alternatives.end(),
                                 [&](const Alternative& a) { return a.effect == name && a.where == where; });
  if (!there) f->alternatives.push_back(make_alternative(law.info(), where, {}, motion));
  f->grade = Grade::kAmbiguous;
}

// Adds a turn of the IMU that the attitude of the base comes from.
void add_turned_imu(const LeggedLog& log, const char* motion, Finding* f) {
  const int imu = BodyMotion::find_main_imu(log);
  if (imu < 0) return;
  add(laws().sensor_misalignment, {{"sensor", "/imu/" + log.imus[static_cast<size_t>(imu)].name}}, motion, f);
}

// Adds zeros of the joints that carry flat feet, of those feet that `is_meant`.
template <class Meant>
void add_ankle_zeros(const LeggedLog& log, const Meant& is_meant, const char* motion, Finding* f) {
  for (const Foot& foot : log.feet) {
    if (!foot.flat || foot.link <= 0 || !is_meant(foot)) continue;
    add(laws().joint_offset, {{"joint", log.tree.joint(foot.link - 1).name}}, motion, f);
  }
}

// A force's zero under feet that stay in their places, without torques of joints. The other foot's zero beside a zero
// of its moment is the same constant in all equations of the whole body, and a sensor has zeros in all of its axes.
bool is_constant_of_all_feet(const ReportState& state, const FoundEffect& f) {
  const LeggedLog& log = state.log;
  const bool of_one_force = is(f, laws().sensor_bias) && f.effect.unit == "N" && f.effect.place >= 0;
  if (!of_one_force || state.contacts.walks || log.sensors.size() < 2) return false;
  for (size_t j = 0; j < log.has_position.size(); ++j) {
    if (log.is_driven(j)) return false;
  }
  return true;
}

// A force sensor's zero that only the sum of the feet's forces shows. Another foot's zero, one of all feet, or a mass
// makes the same sum.
void add_other_zeros(const ReportState& state, const FoundEffect& f, Finding* zero) {
  if (!f.sums_up && !is_constant_of_all_feet(state, f)) return;
  constexpr const char* kMotion = "each foot in the air once; the robot on a scale";
  const std::vector<ForceSensor>& sensors = state.log.sensors;
  for (size_t s = 0; s < sensors.size(); ++s) {
    if (static_cast<int>(s) == f.effect.place) continue;
    add(laws().sensor_bias, {{"sensor", "/wrench/" + sensors[s].name + "/force"}}, kMotion, zero);
  }
  add(laws().sensor_bias, {{"sensor", "/wrench"}}, kMotion, zero);
  add(laws().mass_error, {{"link", state.log.tree.links[0].name}}, kMotion, zero);
}

// A slope under feet that stay in their places. A turned IMU, or the zeros of all legs together, are the same constant.
// Only feet that have turned on the ground tell them apart.
void add_zeros_for_slope(const ReportState& state, const FoundEffect& f, Finding* slope) {
  if (!is(f, laws().ground_slope) || state.contacts.walks) return;
  constexpr const char* kMotion = "the feet set down again after a quarter turn";
  add_turned_imu(state.log, kMotion, slope);
  add_ankle_zeros(
      state.log, [](const Foot&) { return true; }, kMotion, slope);
}

// A zero of one leg beside a slope. Two feet tell two tilts: beside the slope, the zero is their difference. The other
// leg's zero without a slope makes the same two tilts.
void add_zeros_of_other_leg(const ReportState& state, const FoundEffect& f, Finding* zero) {
  if (!is(f, laws().joint_offset) || state.contacts.walks) return;
  const std::vector<FoundEffect>& all = state.outcome.effects;
  if (std::none_of(all.begin(), all.end(), [](const FoundEffect& g) { return is(g, laws().ground_slope); })) return;
  const auto is_other_leg = [&](const Foot& foot) { return !is_above(state.log.tree, f.effect.place + 1, foot.link); };
  add_ankle_zeros(state.log, is_other_leg, "the robot on ground that is level", zero);
}

// An elastic joint. The link before it or behind it, bending about the same axis, moves all that follows alike, and no
// recorded sensor tells where it gives. No scenario holds a link that bends, so that it is an alternative only.
void add_bending_links(const ReportState& state, Finding* f) {
  const std::string& elastic = laws().elasticity.info().name;
  const auto as_alternative = std::find_if(f->alternatives.begin(), f->alternatives.end(),
                                           [&](const Alternative& a) { return a.effect == elastic; });
  if (f->effect != elastic && as_alternative == f->alternatives.end()) return;
  const Where& joint = f->effect == elastic ? f->where : as_alternative->where;
  const std::vector<Estimate> stiffness = f->effect == elastic ? f->parameters : as_alternative->parameters;
  const TreeSpec& tree = state.log.tree;
  const int child = tree.find_joint(get_place(joint)) + 1;
  if (child < 1) return;  // listed for the whole robot: see add_give_for_rate
  for (const int link : {tree.links[static_cast<size_t>(child)].parent, child}) {
    const Where where{{"link", tree.links[static_cast<size_t>(link)].name}};
    f->alternatives.push_back(
        {kBends, get_family_name(EffectFamily::kPlay), where, stiffness, "markers of motion capture on the link"});
  }
  f->grade = Grade::kAmbiguous;
}

// A link that is too heavy. A load at its centre of mass makes the same forces.
void add_load_at_centre(const ReportState& state, const FoundEffect& f, Finding* heavy) {
  if (!is(f, laws().mass_error) || heavy->grade != Grade::kAmbiguous || heavy->parameters[0].value[0] <= 1) return;
  const EffectInfo& payload = laws().payload.info();
  const bool there = std::any_of(heavy->alternatives.begin(), heavy->alternatives.end(), [&](const Alternative& a) {
    return a.effect == payload.name && a.where == heavy->where;
  });
  if (there) return;
  const LinkInertia& link = state.log.tree.links[static_cast<size_t>(f.effect.place)].inertia;
  const double more = heavy->parameters[0].value[0] - 1, std = heavy->parameters[0].std[0];
  heavy->alternatives.insert(
      heavy->alternatives.begin(),
      make_alternative(payload, heavy->where,
                       {make_value(payload, more * link.mass, std * link.mass), make_assumed_centre(link.p_LLcm_L)},
                       "turns of the body: a load hangs at one point"));
}

// A zero or a slope that only the tilt of a foot shows, where the foot's moment was not recorded. A sole that gives
// leans the same way while its moment hardly changes, and so does a turned IMU.
void add_give_for_lean(const ReportState& state, const FoundEffect& f, Finding* lean) {
  const ChannelInfo& told_by = state.fitter.channels()[f.channel].info;
  if (!(is(f, laws().joint_offset) || is(f, laws().ground_slope)) || !is_of_soles(told_by)) return;
  const LeggedLog& log = state.log;
  const auto foot =
      std::find_if(log.feet.begin(), log.feet.end(), [&](const Foot& g) { return g.name == told_by.name; });
  if (foot == log.feet.end()) return;
  if (foot->sensor >= 0 && log.sensors[static_cast<size_t>(foot->sensor)].has_wrench()) return;
  add(laws().flat_sole, {{"foot", foot->name}}, "the foot's moment, recorded", lean);
  add_turned_imu(log, "the body leaned to known angles", lean);
}

// A scale or a turn of a gyroscope that encoders or forces show, and no other sensor of rates or attitudes. Joints that
// give under load let links turn by more than encoders say, in step with the load. A zero or a delay looks different.
void add_give_for_rate(const ReportState& state, const FoundEffect& f, Finding* turned) {
  const ChannelInfo& told_by = state.fitter.channels()[f.channel].info;
  const bool in_step = is(f, laws().sensor_scale) || is(f, laws().sensor_misalignment);
  const bool direct = told_by.equation.is(EquationKind::kGyroscope);
  if (!in_step || direct || turned->where.dump().find("angular_velocity") == std::string::npos) return;
  add(laws().elasticity, {{"link", state.log.tree.links[0].name}},
      "the same motion, recorded by motion capture or an attitude", turned);
}

// A constant in the effort of a leg that stands, which no sensor of a foot shows. Its gear holds dry friction in one
// direction for as long.
void add_held_friction(const ReportState& state, const FoundEffect& f, Finding* constant) {
  const ChannelInfo& told_by = state.fitter.channels()[f.channel].info;
  const bool of_effort = is(f, laws().sensor_bias) && constant->where.dump().find("/effort") != std::string::npos;
  if (!of_effort || !told_by.equation.is_balance_by_legs()) return;
  add(laws().coulomb, {{"joint", state.log.tree.joint(f.effect.place).name}},
      "the joint turned to and fro, slowly, in one posture", constant);
}

// A zero of an accelerometer along what it feels on average, the weight. A scale makes the same in a body that stays
// upright.
void add_scale_for_zero(const ReportState& state, const FoundEffect& f, Finding* zero) {
  if (!is(f, laws().sensor_bias) || zero->where.dump().find("linear_acceleration") == std::string::npos) return;
  Vector3d sum = Vector3d::Zero();
  double samples = 0;
  for (const Clip& clip : state.log.clips) {
    const Track* reading = clip.imus[static_cast<size_t>(f.effect.place)].accelerometer;
    for (size_t k = 0; k < clip.size(); ++k) {
      sum += get_values(reading, k);
      samples += 1;
    }
  }
  const Vector3d felt = sum / samples, along = felt.normalized(), value = f.x, std = f.std;
  if (std::pow(along.dot(value), 2) < kMostly * value.squaredNorm()) return;
  const EffectInfo& scale = laws().sensor_scale.info();
  const double size = along.dot(value) / felt.norm(), error = along.cwiseProduct(std).norm() / felt.norm();
  zero->alternatives.push_back(
      make_alternative(scale, zero->where, {make_value(scale, 1 + size, error)}, "the IMU at rest in six attitudes"));
  zero->grade = Grade::kAmbiguous;
}

}  // namespace

void add_lookalikes(const ReportState& state, const FoundEffect& found, Finding* finding) {
  add_other_zeros(state, found, finding);
  add_zeros_for_slope(state, found, finding);
  add_zeros_of_other_leg(state, found, finding);
  add_bending_links(state, finding);
  add_load_at_centre(state, found, finding);
  add_give_for_lean(state, found, finding);
  add_give_for_rate(state, found, finding);
  add_scale_for_zero(state, found, finding);
  add_held_friction(state, found, finding);
}

}  // namespace hrp::diagnosis::floating

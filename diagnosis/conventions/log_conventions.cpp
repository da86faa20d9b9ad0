// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/log_conventions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/effects/effect_info.h"
#include "common/effects/units.h"
#include "common/spatial/rpy.h"
#include "diagnosis/conventions/joint_conventions.h"
#include "diagnosis/conventions/mounting.h"
#include "diagnosis/conventions/unit_doubts.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/findings/finding_head.h"
#include "diagnosis/floating/conventions/exchanged_legs.h"
#include "diagnosis/floating/conventions/signed_axes.h"
#include "diagnosis/model/last_link.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {
namespace {

// Standard deviation: the bracket is where the scale can be at all.
double calc_std(const EffortUnit& unit) {
  return std::max(kBlur * unit.scale, 0.5 * std::abs(unit.high - unit.low) / kNinetyFive);
}

// Share of squares that goes away when efforts are taken in that unit, held out where something is.
double calc_share(const TorqueData& data, const EffortUnit& unit) {
  const bool held =
      std::any_of(data.recordings.begin(), data.recordings.end(), [](const TorqueRecording& r) { return !r.train; });
  double before = 0.0, after = 0.0;
  for (const TorqueRecording& r : data.recordings) {
    if (held && r.train) continue;
    for (long k = 0; k < r.kept(); ++k) {
      const double y = r.effort(r.full_row(k), unit.joint), tau = r.tau(r.full_row(k), unit.joint);
      if (r.use(k, unit.joint)) {
        before += std::pow(y - tau, 2);
        after += std::pow(unit.scale * y - tau, 2);
      }
    }
  }
  return before > 0.0 ? std::clamp(1.0 - after / before, 0.0, 1.0) : 0.0;
}

// A fault of the log with one parameter.
Json make_finding(const EffectInfo& effect, const Json& where, const char* parameter, const Json& value, double share,
                  Grade grade = Grade::kSupported) {
  Json f = make_finding_head(effect, where, {{parameter, value}}, grade, share);
  f["of_log"] = true;
  return f;
}

Json make_unit_finding(const TorqueData& data, const EffortUnit& unit) {
  const Experiment& e = *data.experiment;
  const std::string joint = e.robot.tree.joint(unit.joint).name, column = e.signal_name(unit.joint, Quantity::kEffort);
  const double std = calc_std(unit);
  const Json scale = make_value(round_to(unit.scale, 5), round_to(std, 3), "1");
  const Json inverse = make_value(round_to(1.0 / unit.scale, 5), round_to(std / (unit.scale * unit.scale), 3), "1");
  const bool sure = !unit.by_others && !unit.at_least && !is_load_or_unit(unit);
  Json f = make_finding(get_effect_of(PlaceKind::kJoint, EffectFamily::kGain), {{"joint", joint}}, "scale", scale,
                        calc_share(data, unit), sure ? Grade::kSupported : Grade::kAmbiguous);
  if (unit.at_least) f["at_least"] = true;
  if (unit.of_gains) {
    f["alternatives"] = Json::array();
    f["statement"] = joint + ": the drive gives " + number(unit.scale, 3) + " +- " + number(kNinetyFive * std, 2) +
                     " times what its stated gains say: they are in another unit, or of another drive.";
    return f;
  }
  std::string statement = joint + ": the effort is no torque: one logged unit is " + number(unit.scale, 3) + " +- " +
                          number(kNinetyFive * std, 2) + " " + get_joint_unit(e.robot.tree.joint(unit.joint), "N m") +
                          " (a motor's current, or a share?).";
  if (unit.by_others)
    statement += " This joint cannot tell; the value is its neighbours'.";
  else if (unit.at_least)
    statement += " This is a lower bound: with a rotor, or with more inertia than the model has, the unit is larger.";
  if (is_load_or_unit(unit))
    statement += " Or the robot carries a load and the unit is another: this motion does not tell.";
  f["statement"] = statement;
  f["alternatives"] = Json::array({state_alternative(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain),
                                                     {{"sensor", column}}, {{"scale", inverse}})});
  if (is_load_or_unit(unit))
    f["alternatives"].push_back(
        state_alternative(get_effect(EffectId::kPayload), {{"link", e.robot.tree.links.back().name}}, Json::object()));
  return f;
}

// The same fault, told from the balance of standing legs. `left`: share of what does not balance.
Json make_turned_leg_finding(const Experiment& e, int joint, double left) {
  Json f = make_turned_finding(e, {joint}, 1.0 - left);
  f["statement"] = floating::describe_turned_efforts(e, {{joint}, left}) + ".";
  return f;
}

Json make_body_finding(const floating::BodyUnit& unit) {
  const Json scale = make_value(round_to(unit.scale, 5), round_to(kKnown * std::abs(unit.scale), 3), "1");
  Json f = make_finding(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain), {{"sensor", unit.sensor}}, "scale",
                        scale, 1.0);
  f["statement"] = unit.sensor + ": " + unit.meaning + ".";
  f["alternatives"] = Json::array();
  if (!unit.may_hang) return f;
  const std::string imu = unit.sensor.substr(0, unit.sensor.rfind('/'));
  f["grade"] = get_grade_name(Grade::kAmbiguous);
  f["probability"] = kHalf;
  f["statement"] = unit.sensor + ": " + unit.meaning + ", or " + imu + " hangs upside down: too little turns to tell.";
  const Json rpy = make_vector({M_PI, 0.0, 0.0}, {kMounted, kMounted, M_PI}, "rad");
  f["alternatives"].push_back(state_alternative(get_effect_of(PlaceKind::kSensor, EffectFamily::kSensorGeometry),
                                                {{"sensor", imu}}, {{"rpy", rpy}}));
  return f;
}

const char* name_absent(Absent part) {
  return part == Absent::kWeight ? "the weight of the model" : "all torque of the model's bodies";
}

// The base and the first joint's zero say the same where its axis is level.
bool is_first_and_level(const Experiment& e, int joint) {
  const LinkSpec& link = e.robot.tree.links[static_cast<size_t>(joint) + 1];
  if (link.parent > 0) return false;
  const Vector3d axis_W = link.joint.X_PF.R * link.joint.axis_F, down_W = e.scenario.gravity_W.normalized();
  return axis_W.normalized().cross(down_W).norm() > kNearlyAll;
}

// All axes are level and parallel: of an arm that lies on a table gravity does nothing.
bool is_planar(const Experiment& e) {
  return is_first_and_level(e, 0) &&
         list_parallel_joints(e.robot.tree).size() + 1 == static_cast<size_t>(e.num_joints());
}

std::string describe_absent(Absent part, bool planar) {
  if (part == Absent::kBodies)
    return "The logged efforts lack the weight and the inertia of the links, as an estimate of the external torque "
           "does. The model's torque was added to them: what is found differs from the model that the estimate used.";
  return std::string(
             "The logged efforts lack the weight of the links: they are a controller's torque beside its "
             "gravity compensation, ") +
         (planar ? "something else carries the links, or the robot lies on its side."
                 : "or something else carries the links.") +
         " The model's weight was added to them.";
}

Json make_absent_finding(const Experiment& e, const AbsentTorque& absent) {
  const EffectInfo& effect = get_effect_of(PlaceKind::kNone, EffectFamily::kTorqueOverPosition);
  const Json base = {{"link", e.robot.tree.links[0].name}};
  Json f = make_finding(effect, base, "share", make_value(1.0, round_to(kBlur, 3), "1"), 1.0 - absent.left);
  const bool planar = absent.part == Absent::kWeight && is_planar(e);
  f["statement"] = describe_absent(absent.part, planar);
  f["alternatives"] = Json::array();
  if (!planar) return f;
  f["grade"] = get_grade_name(Grade::kAmbiguous);
  f["probability"] = kHalf;
  f["alternatives"].push_back(state_alternative(get_effect_of(PlaceKind::kNone, EffectFamily::kZero), base,
                                                Json::object(), "a look at how the robot is mounted"));
  return f;
}

// A zero that is off by gravity: no effect of the table takes gravity out as the body turns.
Json make_gravity_finding(const floating::GoneGravity& gone) {
  const double std = std::max(gone.left, kBlur);
  const Json value = make_vector({-gone.value.x(), -gone.value.y(), -gone.value.z()}, {std, std, std}, "m/s^2");
  Json f = make_finding(get_effect_of(PlaceKind::kSensor, EffectFamily::kZero), {{"sensor", gone.sensor}}, "value",
                        value, 1.0);
  f["statement"] = gone.sensor + ": gravity is not in it: on average it reads " + number(gone.left, 2) + " m/s^2 " +
                   (gone.follows ? "and nothing of how the body leans. A filter took gravity out."
                                 : "of 9.8. It was zeroed at rest, or a filter took gravity out.");
  f["alternatives"] = Json::array();
  return f;
}

// What a frame says of one effect: its value, and that of the rival in its place, which is off in the other sense.
struct FrameValue {
  const EffectInfo& effect;
  const char* parameter;
  Json value, of_rival;
  std::string statement;
};

Json make_frame_finding(const floating::SensorFrame& frame, const FrameValue& v) {
  Json f = make_finding(v.effect, {{"sensor", frame.sensor}}, v.parameter, v.value, 1.0 - frame.left);
  f["weight"] = 1.0;
  f["statement"] = frame.sensor + v.statement;
  f["alternatives"] = Json::array();
  if (frame.rival.empty()) return f;
  f["grade"] = get_grade_name(Grade::kAmbiguous);
  f["probability"] = kHalf;
  f["statement"] = frame.sensor + v.statement + " Or " + frame.rival +
                   " is off in the other sense: legs that stand do not tell which.";
  f["alternatives"].push_back(state_alternative(v.effect, {{"sensor", frame.rival}}, {{v.parameter, v.of_rival}}));
  return f;
}

// A turn onto other axes, and a clock that is far off: what a sensor has of both beside that is found in converted
// recordings.
void add_frame_findings(const floating::SensorFrame& frame, Json* findings) {
  constexpr double kTurn = 0.05, kDelay = 0.01;  // [rad, s] to which they are told here
  const auto make_rpy = [&](const Matrix3d& R) {
    const Vector3d rpy = calc_rpy(R);
    return make_vector({rpy.x(), rpy.y(), rpy.z()}, {kTurn, kTurn, kTurn}, "rad");
  };
  const auto [Q, signs] = floating::split_signs(frame.R);
  if (signs != Vector3d::Ones()) {
    const std::string text =
        ": its columns are left-handed: x y z hold " + floating::name_columns(frame.R) + " of the model's axes.";
    const Json value = make_vector({signs.x(), signs.y(), signs.z()}, {kKnown, kKnown, kKnown}, "1");
    findings->push_back(make_frame_finding(
        frame, {get_effect_of(PlaceKind::kSensor, EffectFamily::kGain), "scale", value, value, text}));
  }
  if (!Q.isIdentity(1e-9)) {
    const Vector3d rpy = calc_rpy(Q);
    const auto degrees = [](double angle) { return number(std::round(angle * kDegrees) + 0.0, 3); };  // no "-0"
    const std::string text = ": it is mounted otherwise than the model says, turned by roll " + degrees(rpy.x()) +
                             ", pitch " + degrees(rpy.y()) + ", yaw " + degrees(rpy.z()) + " degrees.";
    findings->push_back(make_frame_finding(frame, {get_effect_of(PlaceKind::kSensor, EffectFamily::kSensorGeometry),
                                                   "rpy", make_rpy(Q), make_rpy(Q.transpose()), text}));
  }
  if (frame.late == 0.0) return;
  const double late = round_to(frame.late, 3);
  const std::string text = ": its clock is " + number(std::abs(late), 3) + " s " +
                           (late > 0.0 ? "behind" : "ahead of") + " that of the encoders. It was moved.";
  findings->push_back(make_frame_finding(
      frame, {get_late_reading(), "delay", make_value(late, kDelay, "s"), make_value(-late, kDelay, "s"), text}));
}

// What the capture's body has of a turn, and its clock. A world with another axis up and an order of numbers are no
// effects.
void add_pose_findings(const floating::PoseFrame& pose, Json* findings) {
  floating::SensorFrame frame;
  frame.sensor = "/base/pose";
  frame.R = pose.R_body.transpose();
  frame.late = pose.late;
  frame.left = pose.left;
  add_frame_findings(frame, findings);
}

// Another zero turns the last link's centre of mass about the joint's axis, which is the same motion of the same
// weight. A centre of mass that is off by more than half its distance from the axis is none that anybody stated.
void add_turned_centre(const Experiment& e, const JointZero& zero, Json* f) {
  const std::optional<LastLink> last = find_last_link(e.robot.tree, zero.joint);
  if (!last || zero.turned || 2.0 * std::sin(0.5 * std::min(std::abs(zero.offset), M_PI)) > kHalf) return;
  const Vector3d turned = std::cos(zero.offset) * last->out - std::sin(zero.offset) * last->turn;
  const Vector3d moved = last->length * (turned - last->out), width = zero.std * last->length * last->turn.cwiseAbs();
  const Json offset = make_vector({moved.x(), moved.y(), moved.z()}, {width.x(), width.y(), width.z()}, "m");
  (*f)["alternatives"].push_back(state_alternative(
      get_effect(EffectId::kComError), {{"link", e.robot.tree.links[static_cast<size_t>(zero.joint) + 1].name}},
      {{"offset", offset}}));
  (*f)["grade"] = get_grade_name(Grade::kAmbiguous);
  (*f)["probability"] = kHalf;
}

Json make_zero_finding(const Experiment& e, const JointZero& zero, double share) {
  const std::string joint = e.robot.tree.joint(zero.joint).name;
  const Json value = make_value(round_to(zero.offset, 5), round_to(zero.std, 3), "rad");
  Json f = make_finding(get_effect(EffectId::kJointOffset), {{"joint", joint}}, "offset", value, share);
  f["statement"] = joint + ": the joint counts from another zero than the model: it reads " + number(zero.offset, 4) +
                   " +- " + number(kNinetyFive * zero.std, 2) + " rad too much.";
  f["alternatives"] = Json::array();
  const EffectInfo& tilt = get_effect_of(PlaceKind::kNone, EffectFamily::kZero);
  if (is_first_and_level(e, zero.joint))
    f["alternatives"].push_back(state_alternative(tilt, {{"link", e.robot.tree.links[0].name}}, Json::object()));
  add_turned_centre(e, zero, &f);
  return f;
}

// Numbers of a parameter: a plain one in a model, one with its interval in a finding.
void change(const std::function<double(double)>& move, const std::function<double(double)>& spread, Json* p) {
  if (p->is_number()) {
    *p = move(p->get<double>());
    return;
  }
  (*p)["value"] = move((*p)["value"].get<double>());
  (*p)["std"] = spread((*p)["std"].get<double>());
  for (Json& end : (*p)["ci95"]) end = move(end.get<double>());
  if ((*p)["ci95"].size() == 2 && (*p)["ci95"][0] > (*p)["ci95"][1])
    std::swap((*p)["ci95"][0], (*p)["ci95"][1]);  // a factor below zero
}

// The same effect that was found in converted recordings becomes one of logged recordings: gains multiply, offsets add.
bool merge(const Json& finding, Json* list) {
  const std::string name = finding["parameters"].begin().key();
  if (!finding["parameters"][name]["value"].is_number())
    return false;  // of a quarter turn what is left is another, small one
  const double by = finding["parameters"][name]["value"];
  for (Json& other : *list) {
    if (other["effect"] != finding["effect"] || other["where"] != finding["where"]) continue;
    const EffectInfo& effect = *find_effect(finding["effect"].get<std::string>());
    const int at = find_parameter(effect, name);
    const bool factor = at >= 0 && effect.parameters[static_cast<size_t>(at)].factor;
    change([&](double x) { return factor ? x * by : x + by; }, [&](double x) { return factor ? x * std::abs(by) : x; },
           &other["parameters"][name]);
    other["of_log"] = true;
    return true;
  }
  return false;
}

// An IMU that the legs know is right by then: what differs from it is the pose.
void find_frames(const Experiment& in_units, LogConventions* out) {
  out->frames = floating::find_sensor_frames(in_units);
  out->pose = floating::find_pose_frame(floating::convert_sensor_frames(in_units, out->frames));
}

// Shares are those of the effort in its unit. No motion of a moving base tells the torque of its joints: all of the
// servo's law.
void add_sign_findings(const Experiment& e, const LogConventions& c, Json* findings) {
  if (e.scenario.floating_base) {
    for (const TurnedEffort& t : c.signs) findings->push_back(make_turned_finding(e, t, 1.0));
    return;
  }
  if (c.signs.empty()) return;
  LogConventions but_signs = c;
  but_signs.signs.clear();
  const Experiment in_units = convert_efforts(convert_motion(e, but_signs), c.units);  // outlives its data
  const TorqueData data = make_torque_data(in_units);
  for (const TurnedEffort& t : c.signs) {
    EffortUnit turned;
    turned.joint = t.joint;
    turned.scale = -1.0;
    findings->push_back(make_turned_finding(e, t, calc_share(data, turned)));
  }
}

// A robot that moves its base: sensors of the body. `e`: with the signs of the servos' law.
LogConventions find_of_bodies(const Experiment& e) {
  LogConventions out;
  out.turned = floating::find_turned_legs(e);
  const Experiment in_sense = floating::convert_turned_legs(e, out.turned);
  out.weightless = floating::find_gone_gravity(in_sense);
  const Experiment heavy = floating::return_gravity(in_sense, out.weightless);
  out.bodies = floating::find_body_units(heavy);
  const Experiment in_units = floating::convert_body_units(heavy, out.bodies);
  out.whole = floating::find_whole_readings(in_units);
  const Experiment whole = floating::convert_whole_readings(in_units, out.whole);
  out.sides = floating::find_exchanged_sides(whole);
  find_frames(floating::convert_sides(whole, out.sides), &out);
  out.efforts = floating::find_turned_efforts(convert_recordings(e, out));
  return out;
}

}  // namespace

LogConventions find_conventions(const Experiment& e, int jobs) {
  std::vector<TurnedEffort> by_law;
  for (int joint : list_turned_by_law(e)) by_law.push_back({joint});
  const Experiment in_law = turn_efforts(e, by_law);
  LogConventions out;
  if (e.scenario.floating_base)
    out = find_of_bodies(in_law);
  else if (e.scenario.drive != "motion" && e.num_joints() > 0)
    out = find_joint_conventions(in_law, jobs);
  out.signs.insert(out.signs.begin(), by_law.begin(), by_law.end());
  return out;
}

Experiment convert_recordings(const Experiment& e, const LogConventions& c) {
  const Experiment in_torques = convert_zeros(convert_efforts(convert_motion(e, c), c.units), c.zeros);
  const Experiment in_units = floating::convert_body_units(
      floating::return_gravity(floating::convert_turned_legs(in_torques, c.turned), c.weightless), c.bodies);
  const Experiment in_frames = floating::convert_pose(
      floating::convert_sensor_frames(floating::convert_sides(in_units, c.sides), c.frames), c.pose);
  return drop_friction(
      floating::convert_turned_efforts(floating::convert_whole_readings(in_frames, c.whole), c.efforts), c.friction);
}

ConventionRemarks make_remarks(const Experiment& e, const LogConventions& c) {
  ConventionRemarks out;
  const auto name = [&](int joint) { return e.robot.tree.joint(joint).name; };
  const auto add = [&](const std::string& text) { out.found.push_back(text); };
  if (c.absent.part != Absent::kNothing)
    add(std::string("the logged efforts lack ") + name_absent(c.absent.part) + "; it is put back");
  if (c.angles.any()) add(describe(e, c.angles));
  if (c.commands.any()) add(describe(c.commands));
  for (const GearRatio& r : c.ratios.found) add(describe(e, r));
  for (const TurnedEffort& t : c.signs) add("the effort of " + name(t.joint) + " is taken with the other sign");
  for (const EffortUnit& u : c.units)
    add((u.of_gains ? "gains of " : "the effort of ") + name(u.joint) + " taken times " + number(u.scale, 3));
  for (const JointZero& z : c.zeros)
    add("the zero of " + name(z.joint) + " is taken as " + number(z.offset, 4) + " rad");
  for (const floating::GoneGravity& w : c.weightless) add(w.sensor + ": gravity is not in it; it is put back");
  for (const floating::BodyUnit& u : c.bodies) add(u.sensor + ": " + u.meaning);
  for (const floating::SensorFrame& f : c.frames)
    add(f.sensor + (f.is_turned() ? ": turned onto other axes" : "") +
        (f.late != 0.0 ? ": its clock is moved by " + number(f.late, 3) + " s" : ""));
  if (c.pose.is_turned()) add("/base/pose: " + floating::describe(c.pose));
  if (c.pose.late != 0.0) add("/base/pose: its clock is moved by " + number(c.pose.late, 3) + " s");
  for (const floating::WholeReading& w : c.whole) add(floating::describe(w));
  if (c.sides.any()) add(floating::describe(c.sides));
  if (!c.turned.joints.empty()) add(floating::describe_turned_legs(e, c.turned));
  if (!c.efforts.joints.empty()) add(floating::describe_turned_efforts(e, c.efforts));
  for (const RefutedFriction& r : c.friction)
    add(name(r.joint) + (r.effect->dry ? ": dry" : ": viscous") +
        " friction of the model is not there: " + number(r.stated, 3) + " stated, " + number(r.found, 3) + " found");
  const std::string exchanged = floating::find_exchanged_legs(convert_recordings(e, c));
  if (!exchanged.empty()) add(exchanged);
  out.not_looked_for = floating::list_not_looked_for(e);
  return out;
}

void add_conventions(const Experiment& as_logged, const LogConventions& c, Reports* reports) {
  add_refuted_friction(as_logged, c.friction, reports);
  for (const floating::WholeReading& w : c.whole) reports->report["warnings"].push_back(floating::describe(w));
  if (c.sides.any()) reports->report["warnings"].push_back(floating::describe(c.sides));
  if (!c.turned.joints.empty())
    reports->report["warnings"].push_back(floating::describe_turned_legs(as_logged, c.turned));
  doubt_untold_units(as_logged, c.untold, reports);
  doubt_least_units(as_logged, c.units, reports);
  doubt_beside_units(as_logged, c.units, reports);
  doubt_ratios(as_logged, c.ratios, reports);
  if (!c.counts_otherwise()) return;
  Json own = Json::array(), findings = Json::array();
  add_sign_findings(as_logged, c, &own);
  if (!as_logged.scenario.floating_base) {
    const Experiment in_time = convert_motion(as_logged, c);
    const TorqueData data = make_torque_data(in_time);
    for (const EffortUnit& unit : c.units) own.push_back(make_unit_finding(data, unit));
    if (c.absent.part != Absent::kNothing) own.push_back(make_absent_finding(as_logged, c.absent));
    const double share = c.zeros.empty() ? 0.0 : 1.0 - find_joint_zeros(data).left;
    for (const JointZero& zero : c.zeros) own.push_back(make_zero_finding(as_logged, zero, share));
  }
  for (const GearRatio& ratio : c.ratios.found) own.push_back(make_ratio_finding(as_logged, ratio));
  if (const Json late = make_late_finding(as_logged, c.commands); !late.is_null()) own.push_back(late);
  for (const floating::GoneGravity& gone : c.weightless) own.push_back(make_gravity_finding(gone));
  for (const floating::BodyUnit& unit : c.bodies) own.push_back(make_body_finding(unit));
  for (const int joint : c.efforts.joints) own.push_back(make_turned_leg_finding(as_logged, joint, c.efforts.left));
  for (const floating::SensorFrame& frame : c.frames) add_frame_findings(frame, &own);
  add_pose_findings(c.pose, &own);
  Json& report = reports->report;
  for (const Json& finding : own) {
    if (report.contains("model") && !report["model"].empty() && !merge(finding, &report["model"]))
      report["model"].push_back(make_model_entry(finding));
    if (!merge(finding, &report["findings"])) findings.push_back(finding);
  }
  for (const Json& f : report["findings"]) findings.push_back(f);
  report["findings"] = findings;
  if (!own.empty()) add_to_verdict(&report);  // of a pose's convention nothing but the words below is said
  if (c.angles.any()) report["angles"] = describe(as_logged, c.angles);
  if (c.commands.any()) report["warnings"].push_back(describe(c.commands));
  if (c.pose.is_turned()) report["warnings"].push_back("/base/pose: " + floating::describe(c.pose));
  const std::string text =
      "logs count otherwise than the model; errors are those of recordings in the model's units and zeros";
  report["warnings"].push_back(text);
  reports->series["notes"].push_back(text);
}

}  // namespace hrp::diagnosis

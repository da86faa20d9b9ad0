// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/candidates.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/measurement/floating/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kRigidTilt = 2e-5;    // [rad/(N m)] of ground and sole that are taken as rigid: above 5e4 N m/rad
constexpr double kRigidHeight = 1e-6;  // [m/N] likewise: a robot of 100 kg sinks by 1 mm
constexpr double kMounting = 0.01;    // [rad] to which force sensors are screwed on
constexpr double kThick = 0.03;        // [m] of housings about joints, at least
constexpr double kSmallScale = 0.005;  // a factor nearer to 1 than this is within what scales and models are known to

class Lister {
 public:
  Lister(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout)
      : log_(log), contacts_(contacts), at_(layout) {}

  std::vector<Candidate> run() {
    for (int l = 0; l < at_.links; ++l) add_link(l);
    for (int j = 0; j < at_.joints; ++j) add_joint(j);
    for (int s = 0; s < at_.sensors; ++s) add_sensor(s);
    add_all_sensors();
    for (int i = 0; i < at_.imus; ++i) add_imu(i);
    for (int f = 0; f < at_.feet; ++f) add_foot(f);
    Candidate& slope = add("ground_slope", {{"ground", "ground"}}, -1, {{{at_.slope(0), 1.0}}, {{at_.slope(1), 1.0}}});
    slope.vector = true;
    return std::move(out_);
  }

 private:
  Candidate& add(const std::string& effect, Where where, int place, std::vector<Terms> terms) {
    Candidate c;
    c.effect = effect, c.where = std::move(where), c.place = place, c.terms = std::move(terms);
    out_.push_back(std::move(c));
    return out_.back();
  }

  std::vector<Terms> list_axes(int first) const { return {{{first, 1.0}}, {{first + 1, 1.0}}, {{first + 2, 1.0}}}; }

  // [m] How far from its origin a link's mass may lie: as far again as the model has it, or out to joints and soles.
  double find_extent(int l) const {
    double out = 2 * log_.tree.links[static_cast<size_t>(l)].inertia.p_LLcm_L.norm();
    for (const LinkSpec& child : log_.tree.links) {
      if (child.parent == l) out = std::max(out, child.joint.X_PF.p.norm());
    }
    for (const Foot& foot : log_.feet) {
      if (foot.link == l) out = std::max(out, foot.p_LC.norm() + 0.5 * foot.size.norm());
    }
    return out + kThick;
  }

  void add_link(int l) {
    const LinkSpec& link = log_.tree.links[static_cast<size_t>(l)];
    const LinkInertia& I = log_.experiment->robot.tree.links[static_cast<size_t>(l)].inertia;
    const Where where{{"link", link.name}};
    Candidate& load = add("payload", where, l, {{{at_.link(l, 0), 1.0}}, {{at_.link(l, 1), 1.0}}, {{at_.link(l, 2), 1.0}}, {{at_.link(l, 3), 1.0}}});
    load.positive = true, load.least = kSmallScale * log_.mass;
    const LinkInertia& own = link.inertia;
    if (own.mass < 1e-3 * log_.mass || I.mass <= 0) return;
    const Vector3d c = own.p_LLcm_L;
    const Matrix3d about = own.I_LLcm_L + own.mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
    const double values[] = {own.mass, own.mass * c.x(), own.mass * c.y(), own.mass * c.z(), about(0, 0), about(0, 1), about(0, 2), about(1, 1), about(1, 2), about(2, 2)};
    Terms all;
    for (int p = 0; p < kLinkColumns; ++p) all.emplace_back(at_.link(l, p), values[p]);
    Candidate& scale = add("mass_error", where, l, {all});
    scale.low = -0.9, scale.least = std::max(0.02, kSmallScale * log_.mass / own.mass), scale.high = 4;
    Candidate& moved = add("com_error", where, l, {});
    for (int a = 0; a < 3; ++a) moved.terms.push_back({{at_.link(l, 1 + a), own.mass}});
    moved.vector = true, moved.center = c, moved.extent = find_extent(l);
    moved = make_moved(moved, at_, Vector3d::Zero());
  }

  void add_joint(int j) {
    const auto i = static_cast<size_t>(j);
    const JointSpec& joint = log_.tree.joint(j);
    const Where where{{"joint", joint.name}};
    const auto one = [&](const char* effect, int column) -> Candidate& {
      return add(effect, where, j, {{{at_.joint(j, column), 1.0}}});
    };
    if (log_.has_position[i]) {
      one("joint_offset", kOffsetColumn).least = 0.002;
      Candidate& gap = one("backlash", kPlayColumn);
      gap.positive = true, gap.least = 0.002, gap.high = 0.2;
      one("joint_elasticity", kGiveColumn).positive = true;
    }
    if (!log_.is_driven(i) && joint.actuated) return;
    one("viscous_friction", kViscousColumn).positive = true;
    one("coulomb_friction", kDryColumn).positive = true;
    one("load_dependent_friction", kLoadColumn).positive = true;
    one("rotor_inertia", kRotorColumn).positive = true;
    if (!joint.actuated) return;
    Candidate& gain = one("torque_constant_error", kGainColumn);
    gain.low = -0.9, gain.high = 4, gain.least = 0.02;
    add("parallel_spring", where, j, {{{at_.joint(j, kSpringColumn), 1.0}}, {{at_.joint(j, kConstantColumn), 1.0}}}).positive = true;
    const std::string effort = "/joint_states/" + joint.name + "/effort";
    if (log_.has_effort[i]) {
      add("sensor_bias", {{"sensor", effort}}, j, {{{at_.joint(j, kConstantColumn), 1.0}}});
      Candidate& lag = one("actuator_lag", kLagColumn);
      lag.positive = true, lag.least = 0.5 * log_.sample_time, lag.high = 0.2;
    }
    if (log_.has_law[i]) {
      Candidate& delay = one("command_delay", kDelayColumn);
      delay.positive = true, delay.least = 0.5 * log_.sample_time, delay.high = 0.2;
    }
    if (log_.has_law[i] && log_.has_effort[i]) {
      Candidate& scale = add("sensor_scale", {{"sensor", effort}}, j, {{{at_.joint(j, kEffortScaleColumn), 1.0}, {at_.joint(j, kGainColumn), -1.0}}});
      scale.low = -0.9, scale.high = 4, scale.least = kSmallScale;
    }
  }

  void add_sensor(int s) {
    const auto i = static_cast<size_t>(s);
    const ForceSensor& sensor = log_.sensors[i];
    const std::string name = "/wrench/" + sensor.name;
    const Where force{{"sensor", name + "/force"}}, torque{{"sensor", name + "/torque"}}, both{{"sensor", name}};
    Candidate& scale = add("sensor_scale", force, s, {{{at_.sensor(s, kForceScaleColumn), 1.0}}});
    scale.low = -0.9, scale.high = 4, scale.least = kSmallScale;
    if (sensor.has_force()) {
      add("sensor_bias", force, s, list_axes(at_.sensor(s, kForceBiasColumn))).vector = true;
      Candidate& turn = add("sensor_misalignment", both, s, list_axes(at_.sensor(s, kWrenchTurnColumn)));
      turn.vector = true, turn.least = kMounting;
    } else if (sensor.axis[2]) {
      add("sensor_bias", force, s, {{{at_.sensor(s, kForceBiasColumn + 2), 1.0}}});
    }
    Candidate& delay = add("sensor_delay", both, s, {{{at_.sensor(s, kWrenchDelayColumn), 1.0}}});
    delay.positive = true, delay.least = 0.5 * log_.sample_time, delay.high = 0.2;
    if (!sensor.has_wrench()) return;
    add("sensor_bias", torque, s, list_axes(at_.sensor(s, kTorqueBiasColumn))).vector = true;
    Candidate& gain = add("sensor_scale", torque, s, {{{at_.sensor(s, kTorqueScaleColumn), 1.0}}});
    gain.low = -0.9, gain.high = 4, gain.least = kSmallScale;
  }

  // One factor, or one zero, of all force sensors: they often share an amplifier or a calibration.
  void add_all_sensors() {
    Terms scale, zero;
    for (int s = 0; s < at_.sensors; ++s) {
      scale.emplace_back(at_.sensor(s, kForceScaleColumn), 1.0), zero.emplace_back(at_.sensor(s, kForceBiasColumn + 2), 1.0);
    }
    if (at_.sensors < 2) return;
    Candidate& all = add("sensor_scale", {{"sensor", "/wrench"}}, -1, {scale});
    all.low = -0.9, all.high = 4, all.least = kSmallScale;
    add("sensor_bias", {{"sensor", "/wrench"}}, -1, {zero});
  }

  void add_imu(int i) {
    const ImuSensor& imu = log_.imus[static_cast<size_t>(i)];
    const std::string name = "/imu/" + imu.name;
    const Where force{{"sensor", name + "/linear_acceleration"}}, rate{{"sensor", name + "/angular_velocity"}};
    const auto add_all = [&](const Where& where, int first) {
      Candidate& scale = add("sensor_scale", where, i, {{{at_.imu(i, first), 1.0}}});
      scale.low = -0.9, scale.high = 4, scale.least = kSmallScale;
      add("sensor_bias", where, i, list_axes(at_.imu(i, first + 1))).vector = true;
      Candidate& delay = add("sensor_delay", where, i, {{{at_.imu(i, first + 4), 1.0}}});
      delay.positive = true, delay.least = 0.5 * log_.sample_time, delay.high = 0.2;
      add("sensor_misalignment", where, i, list_axes(at_.imu(i, first + 5))).vector = true;
    };
    if (imu.accelerometer) add_all(force, kAccelerometerScaleColumn);
    if (imu.gyro) add_all(rate, kGyroScaleColumn);
    if (imu.attitude) {
      add("sensor_misalignment", {{"sensor", name + "/orientation"}}, i, list_axes(at_.imu(i, kAttitudeTurnColumn))).vector = true;
    }
    add_whole_imu(i, {{"sensor", name}});
  }

  // A housing that sits askew turns all that is in it; a late bus delays all of it.
  void add_whole_imu(int i, const Where& where) {
    const ImuSensor& imu = log_.imus[static_cast<size_t>(i)];
    if (imu.accelerometer + imu.gyro + imu.attitude < 2) return;
    std::vector<Terms> turn(3);
    Terms late;
    const auto put = [&](bool there, int turn_column, int delay_column) {
      for (int a = 0; there && a < 3; ++a) turn[static_cast<size_t>(a)].emplace_back(at_.imu(i, turn_column + a), 1.0);
      if (there) late.emplace_back(at_.imu(i, delay_column), 1.0);
    };
    put(imu.accelerometer, kAccelerometerTurnColumn, kAccelerometerDelayColumn);
    put(imu.gyro, kGyroTurnColumn, kGyroDelayColumn);
    put(imu.attitude, kAttitudeTurnColumn, kAttitudeDelayColumn);
    add("sensor_misalignment", where, i, turn).vector = true;
    Candidate& delay = add("sensor_delay", where, i, {late});
    delay.positive = true, delay.least = 0.5 * log_.sample_time, delay.high = 0.2;
  }

  void add_foot(int f) {
    const Foot& foot = log_.feet[static_cast<size_t>(f)];
    const Where where{{"foot", foot.name}};
    if (!foot.flat) {
      add("foot_compliance", where, f, {{{at_.foot(f, kSinkColumn), 1.0}}}).positive = true;
      return;
    }
    std::vector<Terms> terms;
    for (int c = 0; c < kFootColumns; ++c) terms.push_back({{at_.foot(f, c), 1.0}});
    add("foot_compliance", where, f, terms);
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  const ColumnLayout& at_;
  std::vector<Candidate> out_;
};

Estimate make_three(const std::string& name, const std::string& unit, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  Estimate e;
  e.name = name, e.unit = unit, e.vector = true;
  e.value.assign(x.data(), x.data() + x.size()), e.std.assign(std.data(), std.data() + std.size());
  return e;
}

std::vector<Estimate> make_bush(const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  std::vector<Estimate> out;
  const auto stiff = [&](const char* name, long at, const char* unit) {
    // A give that is not told apart from none has no stiffness to report.
    if (x(at) > 2 * std(at)) out.push_back(make_one(name, unit, 1 / x(at), std(at) / (x(at) * x(at))));
  };
  if (x.size() == 1) return stiff("kz", 0, "N/m"), out;
  for (long a = 0; a < 2; ++a) {
    const std::string axis = a == 0 ? "roll" : "pitch";
    stiff(("k_" + axis).c_str(), 2 * a, "N m/rad");
    if (x(2 * a) <= 2 * std(2 * a)) continue;
    const double damping = std::max(0.0, x(2 * a + 1) / x(2 * a));
    out.push_back(make_one("c_" + axis, "N m s/rad", damping, std(2 * a + 1) / x(2 * a)));
  }
  stiff("kz", 4, "N/m");
  // A damping that is not told apart from none is left out.
  const double damping = x(5) / (x(4) * x(4)), error = std(5) / (x(4) * x(4));
  if (x(4) > 2 * std(4) && damping > 2 * error) out.push_back(make_one("cz", "N s/m", damping, std::hypot(error, 2 * damping * std(4) / x(4))));
  return out;
}

}  // namespace

std::vector<Candidate> list_candidates(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout) {
  return Lister(log, contacts, layout).run();
}

namespace {

// Adds `scale` times a change of a link's inertia about its origin to terms.
void add_inertia(const ColumnLayout& layout, int link, const Matrix3d& I, double scale, Terms* terms) {
  const double values[] = {I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)};
  for (int p = 0; p < 6; ++p) terms->emplace_back(layout.link(link, 4 + p), scale * values[p]);
}

// Of c.c 1 - c c^T by c along axis i, twice that of a half: 2 c_i 1 - e_i c^T - c e_i^T.
Matrix3d calc_inertia_slope(const Vector3d& c, int i) {
  const Vector3d e = Vector3d::Unit(i);
  return 2 * c(i) * Matrix3d::Identity() - e * c.transpose() - c * e.transpose();
}

}  // namespace

// I = m (c.c 1 - c c^T) is of first degree in (m, m c): I = m dI/dm + m c . dI/d(m c), dI/dm = -(c.c 1 - c c^T).
Candidate make_load(const Candidate& payload, const ColumnLayout& layout, const Vector3d& c) {
  Candidate out = payload;
  for (Terms& t : out.terms) t.resize(1);
  const Matrix3d by_mass = c * c.transpose() - c.squaredNorm() * Matrix3d::Identity();
  add_inertia(layout, payload.place, by_mass, 1, &out.terms[0]);
  for (int i = 0; i < 3; ++i) add_inertia(layout, payload.place, calc_inertia_slope(c, i), 1, &out.terms[static_cast<size_t>(i) + 1]);
  return out;
}

// I(c + d) - I(c) = m d . slope at c + d / 2: of second degree in c, so this is exact.
Candidate make_moved(const Candidate& com_error, const ColumnLayout& layout, const Vector3d& offset) {
  Candidate out = com_error;
  for (int i = 0; i < 3; ++i) {
    Terms& t = out.terms[static_cast<size_t>(i)];
    t.resize(1);
    add_inertia(layout, com_error.place, calc_inertia_slope(com_error.center + 0.5 * offset, i), t[0].second, &t);
  }
  return out;
}

std::vector<Estimate> make_estimates(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  if (c.effect == "payload") {
    const Vector3d com = x.tail<3>() / x(0);
    const Vector3d s = ((std.tail<3>() / x(0)).array().square() + (com * std(0) / x(0)).array().square()).sqrt();
    return {make_one("mass", "kg", x(0), std(0)), make_three("com", "m", com, s)};
  }
  if (c.effect == "foot_compliance") return make_bush(x, std);
  if (c.effect == "parallel_spring") {
    return {make_one("stiffness", "N m/rad", x(0), std(0)), make_one("rest", "rad", -x(1) / x(0), std::hypot(std(1), x(1) / x(0) * std(0)) / x(0))};
  }
  if (c.effect == "ground_slope") return {make_one("roll", "rad", x(0), std(0)), make_one("pitch", "rad", x(1), std(1))};
  if (c.effect == "mass_error" || c.effect == "sensor_scale" || c.effect == "torque_constant_error") {
    return {make_one("scale", "1", 1 + x(0), std(0))};
  }
  if (c.effect == "com_error") return {make_three("offset", "m", x, std)};
  if (c.effect == "sensor_misalignment") return {make_three("rpy", "rad", x, std)};
  if (c.effect == "sensor_bias") {
    const std::string unit = c.where.dump().find("angular") != std::string::npos ? "rad/s" : c.where.dump().find("linear_acc") != std::string::npos ? "m/s^2" : c.where.dump().find("force") != std::string::npos || c.where.dump().find("\"/wrench\"") != std::string::npos ? "N" : "N m";
    if (c.vector) return {make_three("value", unit, x, std)};
    Estimate e = make_one("value", unit, x(0), std(0));
    return {e};
  }
  if (c.effect == "joint_elasticity") return {make_one("stiffness", "N m/rad", 1 / x(0), std(0) / (x(0) * x(0)))};
  static const std::map<std::string, std::pair<const char*, const char*>> scalars{
      {"backlash", {"gap", "rad"}}, {"viscous_friction", {"coefficient", "N m s/rad"}}, {"coulomb_friction", {"level", "N m"}},
      {"load_dependent_friction", {"ratio", "1"}}, {"rotor_inertia", {"inertia", "kg m^2"}},
      {"joint_offset", {"offset", "rad"}}, {"actuator_lag", {"time_constant", "s"}},
      {"command_delay", {"delay", "s"}}, {"sensor_delay", {"delay", "s"}}};
  const auto at = scalars.find(c.effect);
  if (at == scalars.end()) return {make_three("value", "1", x, std)};
  return {make_one(at->second.first, at->second.second, x(0), std(0))};
}

bool is_sensible(const Candidate& c, const Eigen::VectorXd& x, double reach) {
  if (!x.allFinite()) return false;
  if (c.positive && x(0) <= 0) return false;
  if (x(0) < c.low || x(0) > c.high) return false;
  if (c.effect == "payload") return x.tail<3>().norm() / x(0) < reach;
  if (c.effect == "com_error") return x.norm() < reach && (c.center + x).norm() < c.extent;
  if (c.effect == "foot_compliance") {
    if (x.size() == 1) return x(0) > kRigidHeight;
    return std::max(x(0), x(2)) > kRigidTilt && std::min(x(0), x(2)) > -kRigidTilt;
  }
  if (c.effect == "joint_offset" || c.effect == "ground_slope" || c.effect == "sensor_misalignment") return x.norm() < 0.5;
  return true;
}

bool is_expected(const std::string& effect) {
  static const char* const common[] = {"viscous_friction", "coulomb_friction", "load_dependent_friction", "rotor_inertia", "sensor_bias"};
  return std::find(std::begin(common), std::end(common), effect) != std::end(common);
}

std::string find_family(const std::string& effect) {
  static const std::map<std::string, std::string> families{
      {"coulomb_friction", "dry friction"}, {"load_dependent_friction", "dry friction"},
      {"viscous_friction", "speed-dependent loss"}, {"rotor_inertia", "reflected inertia"},
      {"payload", "mass and its place"}, {"mass_error", "mass and its place"}, {"com_error", "mass and its place"},
      {"torque_constant_error", "gain"}, {"sensor_scale", "gain"}, {"command_delay", "timing"},
      {"actuator_lag", "timing"}, {"sensor_delay", "timing"}, {"foot_compliance", "give and play"},
      {"backlash", "give and play"}, {"joint_elasticity", "give and play"},
      {"parallel_spring", "torque over position"}, {"joint_offset", "zero"}, {"sensor_bias", "zero"},
      {"ground_slope", "zero"}, {"ground_friction", "contact"}, {"restitution", "contact"},
      {"sensor_misalignment", "geometry of sensors"}};
  const auto at = families.find(effect);
  return at == families.end() ? "" : at->second;
}

std::string find_phrase(const Candidate& c) {
  static const std::map<std::string, std::string> phrases{
      {"coulomb_friction", "dry friction is missing: the drive's torque jumps with the direction of motion"},
      {"load_dependent_friction", "friction that grows with the load is missing"},
      {"viscous_friction", "friction in proportion to speed is missing"},
      {"rotor_inertia", "the rotor's reflected inertia is missing: the torque left over follows the acceleration"},
      {"payload", "an unmodelled mass is carried"},
      {"mass_error", "the link's mass is wrong by a factor"},
      {"com_error", "the link's centre of mass is elsewhere"},
      {"torque_constant_error", "the true torque is a fixed multiple of what is logged"},
      {"sensor_scale", "its reading is scaled"},
      {"command_delay", "commands reach the servo late"},
      {"actuator_lag", "the drive's torque lags behind what is logged"},
      {"sensor_delay", "its readings come late"},
      {"foot_compliance", "the sole gives under load"},
      {"parallel_spring", "a spring acts across the joint"},
      {"backlash", "its teeth have play: the link stays behind the encoder to the torque's side"},
      {"joint_elasticity", "its transmission gives: the link stays behind the encoder in proportion to the torque"},
      {"joint_offset", "the encoder's zero is off"},
      {"sensor_bias", "its reading is shifted by a constant"},
      {"ground_slope", "the ground is not level"},
      {"sensor_misalignment", "it is turned against its link"}};
  const auto at = phrases.find(c.effect);
  return at == phrases.end() ? c.effect : at->second;
}

}  // namespace hrp::diagnosis::floating

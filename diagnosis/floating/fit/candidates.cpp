// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/candidates.h"

#include <algorithm>
#include <limits>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/equations/joint_turns.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/least_squares.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kThick = 0.03;     // [m] of housings about joints, at least
constexpr double kMostSink = 0.05;  // [m] of a sole that gives, under half of the robot's weight

// Coefficients that multiply one column each.
std::vector<Terms> list_columns(int first, int count) {
  std::vector<Terms> out;
  for (int c = 0; c < count; ++c) out.push_back({{first + c, 1.0}});
  return out;
}

std::vector<Terms> list_axes(int first) { return list_columns(first, 3); }

class Lister {
 public:
  Lister(const LeggedLog& log, const ColumnLayout& layout) : log_(log), at_(layout) {}

  std::vector<Candidate> run() {
    for (int l = 0; l < at_.links; ++l) add_link(l);
    for (int j = 0; j < at_.joints; ++j) add_joint(j);
    add_all_efforts();
    for (int s = 0; s < at_.sensors; ++s) add_sensor(s);
    if (at_.sensors > 1) add_all_sensors();
    for (int i = 0; i < at_.imus; ++i) add_imu(i);
    for (int f = 0; f < at_.feet; ++f) add_foot(f);
    add(laws_.ground_slope, {{"ground", "ground"}}, -1, {{{at_.slope(0), 1.0}}, {{at_.slope(1), 1.0}}});
    add_free_laws();
    return std::move(out_);
  }

 private:
  Candidate& add(const CandidateLaw& law, Where where, int place, std::vector<Terms> terms) {
    Candidate c;
    c.law = &law;
    c.where = std::move(where);
    c.place = place;
    c.terms = std::move(terms);
    c.vector = law.vector && c.terms.size() > 1;
    c.least = law.least;
    out_.push_back(std::move(c));
    return out_.back();
  }

  Candidate& add_late(const CandidateLaw& law, const Where& where, int place, Terms terms) {
    Candidate& late = add(law, where, place, {std::move(terms)});
    // Nobody knows more exactly when the sensors of one row were read.
    late.least = 0.5 * log_.sample_time;
    late.known = kDetail * log_.sample_time;
    return late;
  }

  // [m] How far from its origin a link's mass may lie: twice as far as in the model, or out to its joints and soles.
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

  // [m] The largest lever about the axis of a leg's joint that a force under its sole has for certain: half of the
  // sole's length; 0: no leg.
  double find_lever(int j) const {
    double out = 0;
    for (const Foot& foot : log_.feet) {
      if (foot.flat && is_above(log_.tree, j + 1, foot.link)) out = std::max(out, 0.5 * foot.size.head<2>().maxCoeff());
    }
    return out;
  }

  void add_link(int l) {
    const LinkSpec& link = log_.tree.links[static_cast<size_t>(l)];
    const Where where{{"link", link.name}};
    Candidate& load = add(laws_.payload, where, l, list_columns(at_.link(l, 0), 4));
    load.least = kExactShare * log_.mass;
    load.prior = make_place_prior(log_.mass);
    const double stated = log_.experiment->robot.tree.links[static_cast<size_t>(l)].inertia.mass;
    if (link.inertia.mass < 1e-3 * log_.mass || stated <= 0) return;
    add_own_mass(l, link.inertia, where);
  }

  void add_own_mass(int l, const LinkInertia& own, const Where& where) {
    const Vector3d c = own.p_LLcm_L;
    const Matrix3d about = own.I_LLcm_L + own.mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
    const double values[] = {own.mass,    own.mass * c.x(), own.mass * c.y(), own.mass * c.z(), about(0, 0),
                             about(0, 1), about(0, 2),      about(1, 1),      about(1, 2),      about(2, 2)};
    Terms all;
    for (int p = 0; p < kInertialParameters; ++p) all.emplace_back(at_.link(l, p), values[p]);
    add(laws_.mass_error, where, l, {all}).least = std::max(kKnown, kExactShare * log_.mass / own.mass);
    std::vector<Terms> axes;
    for (int a = 0; a < 3; ++a) axes.push_back({{at_.link(l, 1 + a), own.mass}});
    Candidate& moved = add(laws_.com_error, where, l, std::move(axes));
    moved.center = c;
    moved.extent = find_extent(l);
    // Two deviations are the link's size: axes that a walk hardly tells stay within it.
    moved.prior.assign(3, kHalf * moved.extent);
    moved = make_moved(moved, at_, Vector3d::Zero());
  }

  void add_joint(int j) {
    const auto i = static_cast<size_t>(j);
    const JointSpec& joint = log_.tree.joint(j);
    const Where where{{"joint", joint.name}};
    const auto one = [&](const CandidateLaw& law, int column) { add(law, where, j, {{{at_.joint(j, column), 1.0}}}); };
    if (log_.has_position[i]) {
      one(laws_.joint_offset, kOffsetColumn);
      one(laws_.backlash, kPlayColumn);
      one(laws_.elasticity, kGiveColumn);
      if (find_lever(j) > 0) out_.back().prior = {find_most_turn(find_lever(j))};
    }
    if (!log_.is_driven(i) && joint.actuated) return;
    one(laws_.viscous, kViscousColumn);
    one(laws_.coulomb, kDryColumn);
    one(laws_.load_friction, kLoadColumn);
    one(laws_.rotor_inertia, kRotorColumn);
    if (joint.actuated) add_drive(j, where);
  }

  void add_drive(int j, const Where& where) {
    const auto i = static_cast<size_t>(j);
    const Where effort{{"sensor", "/joint_states/" + log_.tree.joint(j).name + "/effort"}};
    const Terms constant{{at_.joint(j, kConstantColumn), 1.0}}, gain{{at_.joint(j, kGainColumn), 1.0}};
    add(laws_.torque_constant, where, j, {gain}).lever = find_lever(j);
    add(laws_.spring, where, j, {{{at_.joint(j, kSpringColumn), 1.0}}, constant}).lever = find_lever(j);
    if (log_.has_effort[i]) {
      Candidate& bias = add(laws_.sensor_bias, effort, j, {constant});
      bias.unit = "N m";
      bias.lever = find_lever(j);
      add_late(laws_.lag, where, j, {{at_.joint(j, kLagColumn), 1.0}});
    }
    if (log_.has_law[i]) add_late(laws_.delay, where, j, {{at_.joint(j, kDelayColumn), 1.0}});
    if (log_.has_law[i] && log_.has_effort[i]) {
      add(laws_.sensor_scale, effort, j,
          {{{at_.joint(j, kEffortScaleColumn), 1.0}, {at_.joint(j, kGainColumn), -1.0}}});
    }
  }

  // One factor of all efforts. Where legs that stand carry a body, it looks like a wrong mass of all.
  void add_all_efforts() {
    Terms gain;
    for (int j = 0; j < at_.joints; ++j) {
      if (log_.has_effort[static_cast<size_t>(j)]) gain.emplace_back(at_.joint(j, kGainColumn), 1.0);
    }
    if (gain.size() > 1) add(laws_.effort_scale, {{"sensor", "/joint_states"}}, -1, {gain});
  }

  void add_sensor(int s) {
    const ForceSensor& sensor = log_.sensors[static_cast<size_t>(s)];
    const std::string name = "/wrench/" + sensor.name;
    const Where force{{"sensor", name + "/force"}}, torque{{"sensor", name + "/torque"}}, both{{"sensor", name}};
    add(laws_.sensor_scale, force, s, {{{at_.sensor(s, kForceScaleColumn), 1.0}}});
    if (sensor.has_force()) {
      add(laws_.sensor_bias, force, s, list_axes(at_.sensor(s, kForceBiasColumn))).unit = "N";
      Candidate& turn = add(laws_.sensor_misalignment, both, s, list_axes(at_.sensor(s, kWrenchTurnColumn)));
      turn.least = turn.known = kMountingError;
    } else if (sensor.axis[2]) {
      add(laws_.sensor_bias, force, s, {{{at_.sensor(s, kForceBiasColumn + 2), 1.0}}}).unit = "N";
    }
    add_late(laws_.sensor_delay, both, s, {{at_.sensor(s, kWrenchDelayColumn), 1.0}});
    if (!sensor.has_wrench()) return;
    add(laws_.sensor_bias, torque, s, list_axes(at_.sensor(s, kTorqueBiasColumn))).unit = "N m";
    add(laws_.sensor_scale, torque, s, {{{at_.sensor(s, kTorqueScaleColumn), 1.0}}});
  }

  // One factor, one zero or one delay of all force sensors, which often share an amplifier, a calibration or a bus. The
  // factor is that of their moments, too, so that it equals a factor of all masses.
  void add_all_sensors() {
    const Where all{{"sensor", "/wrench"}};
    Terms scale, zero, late;
    for (int s = 0; s < at_.sensors; ++s) {
      scale.emplace_back(at_.sensor(s, kForceScaleColumn), 1.0);
      zero.emplace_back(at_.sensor(s, kForceBiasColumn + 2), 1.0);
      late.emplace_back(at_.sensor(s, kWrenchDelayColumn), 1.0);
      if (log_.sensors[static_cast<size_t>(s)].has_wrench()) scale.emplace_back(at_.sensor(s, kTorqueScaleColumn), 1.0);
    }
    add(laws_.sensor_scale, all, -1, {scale});
    add(laws_.sensor_bias, all, -1, {zero}).unit = "N";
    add_late(laws_.sensor_delay, all, -1, late);
  }

  void add_imu(int i) {
    const ImuSensor& imu = log_.imus[static_cast<size_t>(i)];
    const std::string name = "/imu/" + imu.name;
    if (imu.accelerometer)
      add_imu_reading(i, {{"sensor", name + "/linear_acceleration"}}, kAccelerometerScaleColumn, "m/s^2");
    if (imu.gyro) add_imu_reading(i, {{"sensor", name + "/angular_velocity"}}, kGyroScaleColumn, "rad/s");
    if (imu.attitude) {
      add(laws_.sensor_misalignment, {{"sensor", name + "/orientation"}}, i,
          list_axes(at_.imu(i, kAttitudeTurnColumn)));
    }
    if (imu.accelerometer + imu.gyro + imu.attitude > 1) add_whole_imu(i, {{"sensor", name}});
  }

  // `first`: the column of the scale; those of zero, delay and turn follow it.
  void add_imu_reading(int i, const Where& where, int first, const char* unit) {
    const int zero = first + 1, delay = zero + 3, turn = delay + 1;
    add(laws_.sensor_scale, where, i, {{{at_.imu(i, first), 1.0}}});
    add(laws_.sensor_bias, where, i, list_axes(at_.imu(i, zero))).unit = unit;
    add_late(laws_.sensor_delay, where, i, {{at_.imu(i, delay), 1.0}});
    add(laws_.sensor_misalignment, where, i, list_axes(at_.imu(i, turn)));
  }

  // A housing that is turned turns all sensors in it; a late bus delays all of them.
  void add_whole_imu(int i, const Where& where) {
    const ImuSensor& imu = log_.imus[static_cast<size_t>(i)];
    std::vector<Terms> turn(3);
    Terms late;
    const auto put = [&](bool there, int turn_column, int delay_column) {
      for (int a = 0; there && a < 3; ++a) turn[static_cast<size_t>(a)].emplace_back(at_.imu(i, turn_column + a), 1.0);
      if (there) late.emplace_back(at_.imu(i, delay_column), 1.0);
    };
    put(imu.accelerometer, kAccelerometerTurnColumn, kAccelerometerDelayColumn);
    put(imu.gyro, kGyroTurnColumn, kGyroDelayColumn);
    put(imu.attitude, kAttitudeTurnColumn, kAttitudeDelayColumn);
    add(laws_.sensor_misalignment, where, i, turn);
    add_late(laws_.sensor_delay, where, i, late);
  }

  void add_foot(int f) {
    const Foot& foot = log_.feet[static_cast<size_t>(f)];
    const Where where{{"foot", foot.name}};
    // A force without its moment tells only how a flat sole sinks.
    const bool whole = foot.sensor >= 0 && log_.sensors[static_cast<size_t>(foot.sensor)].has_wrench();
    if (!foot.flat || !whole) {
      add(laws_.point_foot, where, f, {{{at_.foot(f, kSinkColumn), 1.0}}});
      return;
    }
    add(laws_.flat_sole, where, f, list_columns(at_.foot(f, 0), kHoldColumn)).prior = make_sole_prior(foot);
  }

  double find_half_weight() const { return 0.5 * log_.mass * log_.experiment->scenario.gravity_W.norm(); }
  // Of a sole that gives, or a joint of a leg, under half of the robot's weight at the sole's edge.
  double find_most_turn(double lever) const { return kLargestAngle / (find_half_weight() * lever); }  // [rad/(N m)]

  // Soles are told about the axes that a motion presses them about. Robots that lean forward tell pitch alone.
  std::vector<double> make_sole_prior(const Foot& foot) const {
    std::vector<double> out(kHoldColumn, 0.0);
    const double force = find_half_weight();
    const auto put = [&](int give, int damp, int shift, double lever) {
      const double most = find_most_turn(lever);
      out[static_cast<size_t>(give)] = most;
      out[static_cast<size_t>(damp)] = kLatest;
      out[static_cast<size_t>(shift)] = out[static_cast<size_t>(shift) + 1] = most * lever;
    };
    put(kRollGiveColumn, kRollDampColumn, kRollShiftColumn, 0.5 * foot.size.y());
    put(kPitchGiveColumn, kPitchDampColumn, kPitchShiftColumn, 0.5 * foot.size.x());
    out[kSinkColumn] = kMostSink / force;
    out[kSinkDampColumn] = kLatest * kMostSink / force;
    return out;
  }

  // Physics outside the table of effects, with as many coefficients as the equations can tell. Where they explain more
  // than an effect does, the report names no effect.
  void add_free_laws() {
    for (int j = 0; j < at_.joints; ++j) {
      if (!log_.has_position[static_cast<size_t>(j)] || !may_bend(log_, j)) continue;
      add(laws_.bend, {{"joint", log_.tree.joint(j).name}}, j, list_columns(at_.joint(j, kBendColumn), 2));
    }
    for (int l : list_pulled_links(log_)) {
      const std::string& link = log_.tree.links[static_cast<size_t>(l)].name;
      add(laws_.pull, {{"link", link}}, l, list_columns(at_.pull(l, 0), kPullColumns));
    }
    for (int f = 0; f < at_.feet; ++f) {
      add(laws_.hold, {{"foot", log_.feet[static_cast<size_t>(f)].name}}, f,
          list_columns(at_.foot(f, kHoldColumn), kHolds));
    }
  }

  const LeggedLog& log_;
  const ColumnLayout& at_;
  const LawTable& laws_ = get_laws();
  std::vector<Candidate> out_;
};

}  // namespace

std::vector<int> list_pulled_links(const LeggedLog& log) {
  std::vector<int> children(log.tree.links.size(), 0), out;
  for (size_t l = 1; l < children.size(); ++l) ++children[static_cast<size_t>(log.tree.links[l].parent)];
  for (size_t l = 0; l < children.size(); ++l) {
    if (l == 0 || children[l] != 1) out.push_back(static_cast<int>(l));
  }
  return log.tree.floating_base ? out : std::vector<int>{};
}

std::vector<Candidate> list_candidates(const LeggedLog& log, const ColumnLayout& layout) {
  return Lister(log, layout).run();
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

// Two deviations are the reach.
std::vector<double> make_place_prior(double mass) {
  const double axis = kHalf * kReach * mass;
  return {std::numeric_limits<double>::infinity(), axis, axis, axis};
}

// I = m (c.c 1 - c c^T) is of first degree in (m, m c): I = m dI/dm + m c . dI/d(m c), dI/dm = -(c.c 1 - c c^T).
Candidate make_load(const Candidate& payload, const ColumnLayout& layout, const Vector3d& c) {
  Candidate out = payload;
  for (Terms& t : out.terms) t.resize(1);
  const Matrix3d by_mass = c * c.transpose() - c.squaredNorm() * Matrix3d::Identity();
  add_inertia(layout, payload.place, by_mass, 1, &out.terms[0]);
  for (int i = 0; i < 3; ++i)
    add_inertia(layout, payload.place, calc_inertia_slope(c, i), 1, &out.terms[static_cast<size_t>(i) + 1]);
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

bool Candidate::is_listed() const { return law->unlisted == nullptr; }

const EffectInfo& Candidate::info() const { return law->info(); }

std::vector<long> find_core(const Candidate& c) { return c.law->core.empty() ? std::vector<long>{0} : c.law->core; }

std::vector<Estimate> make_estimates(const Candidate& c, const Eigen::VectorXd& x, const Eigen::VectorXd& std) {
  return c.law->make_estimates(c, x, std);
}

bool is_sensible(const Candidate& c, const Eigen::VectorXd& x) {
  if (!x.allFinite()) return false;
  if (c.law->positive && x(0) <= 0) return false;
  if (x(0) < c.law->low || x(0) > c.law->high) return false;
  return !c.law->is_sensible || c.law->is_sensible(c, x);
}

bool is_expected(const EffectInfo& effect) {
  switch (effect.family) {
    case EffectFamily::kDryFriction:
    case EffectFamily::kSpeedLoss:
    case EffectFamily::kReflectedInertia: return true;
    case EffectFamily::kZero: return effect.place == PlaceKind::kSensor;
    default: return false;
  }
}

}  // namespace hrp::diagnosis::floating

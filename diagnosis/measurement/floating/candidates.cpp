// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/candidates.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/measurement/floating/candidate_laws.h"
#include "diagnosis/measurement/floating/joint_turns.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kMounting = 0.01;    // [rad] to which force sensors are screwed on
constexpr double kSpringShare = 0.02;  // of a joint's torque's spread that a spring must give: rigid models miss a little that follows the position
constexpr double kInstant = 0.1;       // of a period: within it, nobody knows when the sensors of one row were read
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
    Candidate& slope = add(EffectId::kGroundSlope, {{"ground", "ground"}}, -1, {{{at_.slope(0), 1.0}}, {{at_.slope(1), 1.0}}});
    slope.vector = true, slope.law = &get_angle_law();
    add_unlisted();
    return std::move(out_);
  }

 private:
  // Free laws: physics outside the table, with as many coefficients as equations can tell. No effect is named for what they
  // explain better.
  void add_unlisted() {
    const auto add_all = [&](const CandidateLaw& law, const Where& where, int place, int first, int count) {
      Candidate free;
      free.law = &law, free.where = where, free.place = place, free.vector = true;
      for (int c = 0; c < count; ++c) free.terms.push_back({{first + c, 1.0}});
      out_.push_back(std::move(free));
    };
    for (int j = 0; j < at_.joints; ++j) {
      if (log_.has_position[static_cast<size_t>(j)] && may_bend(log_, j)) add_all(get_bend_law(), {{"joint", log_.tree.joint(j).name}}, j, at_.joint(j, kBendColumn), 2);
    }
    for (int l : list_pulled_links(log_)) add_all(get_pull_law(), {{"link", log_.tree.links[static_cast<size_t>(l)].name}}, l, at_.pull(l, 0), kPullColumns);
    for (int f = 0; f < at_.feet; ++f) add_all(get_hold_law(), {{"foot", log_.feet[static_cast<size_t>(f)].name}}, f, at_.foot(f, kHoldColumn), kHolds);
  }

  Candidate& add(EffectId effect, Where where, int place, std::vector<Terms> terms) {
    Candidate c;
    c.effect = effect, c.law = &get_plain_law(), c.where = std::move(where), c.place = place, c.terms = std::move(terms);
    out_.push_back(std::move(c));
    return out_.back();
  }

  void be_late(Candidate* c) const {
    c->positive = true, c->least = 0.5 * log_.sample_time, c->high = 0.2, c->known = kInstant * log_.sample_time;
  }

  void add_zero(const Where& where, int place, int first, const char* unit) {
    Candidate& zero = add(EffectId::kSensorBias, where, place, list_axes(first));
    zero.vector = true, zero.unit = unit;
  }

  void add_turn(const Where& where, int place, std::vector<Terms> axes) {
    Candidate& turn = add(EffectId::kSensorMisalignment, where, place, std::move(axes));
    turn.vector = true, turn.law = &get_angle_law();
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

  // [m] At least so far from the axis of a leg's joint a force under the sole may act: half of its length; 0: no leg.
  double find_lever(int j) const {
    double out = 0;
    for (const Foot& foot : log_.feet) {
      for (int l = foot.link; foot.flat && l > 0; l = log_.tree.links[static_cast<size_t>(l)].parent) {
        if (l == j + 1) out = std::max(out, 0.5 * foot.size.head<2>().maxCoeff());
      }
    }
    return out;
  }

  void add_link(int l) {
    const LinkSpec& link = log_.tree.links[static_cast<size_t>(l)];
    const LinkInertia& I = log_.experiment->robot.tree.links[static_cast<size_t>(l)].inertia;
    const Where where{{"link", link.name}};
    Candidate& load = add(EffectId::kPayload, where, l, {{{at_.link(l, 0), 1.0}}, {{at_.link(l, 1), 1.0}}, {{at_.link(l, 2), 1.0}}, {{at_.link(l, 3), 1.0}}});
    load.law = &get_load_law(), load.positive = true, load.least = kSmallScale * log_.mass;
    const LinkInertia& own = link.inertia;
    if (own.mass < 1e-3 * log_.mass || I.mass <= 0) return;
    const Vector3d c = own.p_LLcm_L;
    const Matrix3d about = own.I_LLcm_L + own.mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
    const double values[] = {own.mass, own.mass * c.x(), own.mass * c.y(), own.mass * c.z(), about(0, 0), about(0, 1), about(0, 2), about(1, 1), about(1, 2), about(2, 2)};
    Terms all;
    for (int p = 0; p < kLinkColumns; ++p) all.emplace_back(at_.link(l, p), values[p]);
    Candidate& scale = add(EffectId::kMassError, where, l, {all});
    scale.low = -0.9, scale.least = std::max(0.02, kSmallScale * log_.mass / own.mass), scale.high = 4;
    Candidate& moved = add(EffectId::kComError, where, l, {});
    for (int a = 0; a < 3; ++a) moved.terms.push_back({{at_.link(l, 1 + a), own.mass}});
    moved.law = &get_moved_law(), moved.vector = true, moved.center = c, moved.extent = find_extent(l);
    moved = make_moved(moved, at_, Vector3d::Zero());
  }

  void add_joint(int j) {
    const auto i = static_cast<size_t>(j);
    const JointSpec& joint = log_.tree.joint(j);
    const Where where{{"joint", joint.name}};
    const auto one = [&](EffectId effect, int column) -> Candidate& {
      return add(effect, where, j, {{{at_.joint(j, column), 1.0}}});
    };
    if (log_.has_position[i]) {
      Candidate& zero = one(EffectId::kJointOffset, kOffsetColumn);
      zero.least = 0.002, zero.law = &get_angle_law();
      Candidate& gap = one(EffectId::kBacklash, kPlayColumn);
      gap.positive = true, gap.least = 0.002, gap.high = 0.2;
      Candidate& give = one(EffectId::kElasticity, kGiveColumn);
      give.positive = true, give.law = &get_give_law();
    }
    if (!log_.is_driven(i) && joint.actuated) return;
    one(EffectId::kViscous, kViscousColumn).positive = true;
    one(EffectId::kCoulomb, kDryColumn).positive = true;
    one(EffectId::kLoadFriction, kLoadColumn).positive = true;
    one(EffectId::kRotorInertia, kRotorColumn).positive = true;
    if (!joint.actuated) return;
    Candidate& gain = one(EffectId::kTorqueConstant, kGainColumn);
    gain.low = -0.9, gain.high = 4, gain.least = 0.02, gain.lever = find_lever(j);
    Candidate& spring = add(EffectId::kSpring, where, j, {{{at_.joint(j, kSpringColumn), 1.0}}, {{at_.joint(j, kConstantColumn), 1.0}}});
    spring.positive = true, spring.worth = kSpringShare, spring.law = &get_spring_law(), spring.lever = find_lever(j);
    const std::string effort = "/joint_states/" + joint.name + "/effort";
    if (log_.has_effort[i]) {
      Candidate& bias = add(EffectId::kSensorBias, {{"sensor", effort}}, j, {{{at_.joint(j, kConstantColumn), 1.0}}});
      bias.unit = "N m", bias.lever = find_lever(j);
      Candidate& lag = one(EffectId::kLag, kLagColumn);
      be_late(&lag);
    }
    if (log_.has_law[i]) {
      Candidate& delay = one(EffectId::kDelay, kDelayColumn);
      be_late(&delay);
    }
    if (log_.has_law[i] && log_.has_effort[i]) {
      Candidate& scale = add(EffectId::kSensorScale, {{"sensor", effort}}, j, {{{at_.joint(j, kEffortScaleColumn), 1.0}, {at_.joint(j, kGainColumn), -1.0}}});
      scale.low = -0.9, scale.high = 4, scale.least = kSmallScale;
    }
  }

  void add_sensor(int s) {
    const auto i = static_cast<size_t>(s);
    const ForceSensor& sensor = log_.sensors[i];
    const std::string name = "/wrench/" + sensor.name;
    const Where force{{"sensor", name + "/force"}}, torque{{"sensor", name + "/torque"}}, both{{"sensor", name}};
    Candidate& scale = add(EffectId::kSensorScale, force, s, {{{at_.sensor(s, kForceScaleColumn), 1.0}}});
    scale.low = -0.9, scale.high = 4, scale.least = kSmallScale;
    if (sensor.has_force()) {
      add_zero(force, s, at_.sensor(s, kForceBiasColumn), "N");
      Candidate& turn = add(EffectId::kSensorMisalignment, both, s, list_axes(at_.sensor(s, kWrenchTurnColumn)));
      turn.vector = true, turn.least = turn.known = kMounting, turn.law = &get_angle_law();
    } else if (sensor.axis[2]) {
      add(EffectId::kSensorBias, force, s, {{{at_.sensor(s, kForceBiasColumn + 2), 1.0}}}).unit = "N";
    }
    Candidate& delay = add(EffectId::kSensorDelay, both, s, {{{at_.sensor(s, kWrenchDelayColumn), 1.0}}});
    be_late(&delay);
    if (!sensor.has_wrench()) return;
    add_zero(torque, s, at_.sensor(s, kTorqueBiasColumn), "N m");
    Candidate& gain = add(EffectId::kSensorScale, torque, s, {{{at_.sensor(s, kTorqueScaleColumn), 1.0}}});
    gain.low = -0.9, gain.high = 4, gain.least = kSmallScale;
  }

  // One factor, one zero or one delay of all force sensors: they often share an amplifier, a calibration or a bus. The
  // factor is of their moments, too: as much as if all masses were wrong by it. Where the weight goes from foot to foot, one
  // sensor that is late alone would miss some of it, and all together miss none.
  void add_all_sensors() {
    Terms scale, zero, late;
    for (int s = 0; s < at_.sensors; ++s) {
      scale.emplace_back(at_.sensor(s, kForceScaleColumn), 1.0), zero.emplace_back(at_.sensor(s, kForceBiasColumn + 2), 1.0);
      late.emplace_back(at_.sensor(s, kWrenchDelayColumn), 1.0);
      if (log_.sensors[static_cast<size_t>(s)].has_wrench()) scale.emplace_back(at_.sensor(s, kTorqueScaleColumn), 1.0);
    }
    if (at_.sensors < 2) return;
    Candidate& all = add(EffectId::kSensorScale, {{"sensor", "/wrench"}}, -1, {scale});
    all.low = -0.9, all.high = 4, all.least = kSmallScale;
    add(EffectId::kSensorBias, {{"sensor", "/wrench"}}, -1, {zero}).unit = "N";
    Candidate& delay = add(EffectId::kSensorDelay, {{"sensor", "/wrench"}}, -1, {late});
    be_late(&delay);
  }

  void add_imu(int i) {
    const ImuSensor& imu = log_.imus[static_cast<size_t>(i)];
    const std::string name = "/imu/" + imu.name;
    const Where force{{"sensor", name + "/linear_acceleration"}}, rate{{"sensor", name + "/angular_velocity"}};
    const auto add_all = [&](const Where& where, int first, const char* unit) {
      Candidate& scale = add(EffectId::kSensorScale, where, i, {{{at_.imu(i, first), 1.0}}});
      scale.low = -0.9, scale.high = 4, scale.least = kSmallScale;
      add_zero(where, i, at_.imu(i, first + 1), unit);
      Candidate& delay = add(EffectId::kSensorDelay, where, i, {{{at_.imu(i, first + 4), 1.0}}});
      be_late(&delay);
      add_turn(where, i, list_axes(at_.imu(i, first + 5)));
    };
    if (imu.accelerometer) add_all(force, kAccelerometerScaleColumn, "m/s^2");
    if (imu.gyro) add_all(rate, kGyroScaleColumn, "rad/s");
    if (imu.attitude) {
      add_turn({{"sensor", name + "/orientation"}}, i, list_axes(at_.imu(i, kAttitudeTurnColumn)));
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
    add_turn(where, i, turn);
    Candidate& delay = add(EffectId::kSensorDelay, where, i, {late});
    be_late(&delay);
  }

  void add_foot(int f) {
    const Foot& foot = log_.feet[static_cast<size_t>(f)];
    const Where where{{"foot", foot.name}};
    if (!foot.flat) {
      Candidate& sink = add(EffectId::kFootCompliance, where, f, {{{at_.foot(f, kSinkColumn), 1.0}}});
      sink.positive = true, sink.law = &get_point_law();
      return;
    }
    std::vector<Terms> terms;
    for (int c = 0; c < kHoldColumn; ++c) terms.push_back({{at_.foot(f, c), 1.0}});
    Candidate& sole = add(EffectId::kFootCompliance, where, f, terms);
    sole.law = &get_bush_law(), sole.core = {kRollGiveColumn, kPitchGiveColumn};
  }

  const LeggedLog& log_;
  const Contacts& contacts_;
  const ColumnLayout& at_;
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

bool is_expected(EffectId effect) {
  const EffectInfo& row = get_effect(effect);
  switch (row.family) {
    case EffectFamily::kDryFriction:
    case EffectFamily::kSpeedLoss:
    case EffectFamily::kReflectedInertia: return true;
    case EffectFamily::kZero: return row.place == PlaceKind::kSensor;
    default: return false;
  }
}

}  // namespace hrp::diagnosis::floating

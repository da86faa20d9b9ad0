// SPDX-License-Identifier: BSD-3-Clause
// Terms of one joint, in its own rows of the missing torque.
#include "diagnosis/measurement/torque/term_rows.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/effort_limits.h"
#include "diagnosis/measurement/ripple.h"
#include "diagnosis/model/memory.h"
#include "diagnosis/model/nominal.h"

namespace hrp::diagnosis {

const char* const kReversals = "short, fast reversals of this joint alone";
const char* const kSweeps = "slow sweeps of the joint over its whole range, in postures of different load";
const char* const kPostures = "postures held, and slow motion of every joint, with a known mass hung on and without";

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using R = TorqueRecording;

constexpr double kMostLoss = 0.6;                    // share of the load; no transmission loses more
constexpr double kLeastGain = 0.5, kMostGain = 2.0;  // of a torque constant; beyond, it is the unit (effort_units.h)

// Stribeck velocities as shares of the joint's fast speed (its 90th percentile).
constexpr double kStribeckShares[] = {0.03, 0.06, 0.12, 0.25};
// Yield angles [rad] by factors of kYieldStep up to a fifth of the joint's range; the uncertainty is half a step. Below
// the smallest one, pre-sliding of dry friction looks the same.
constexpr double kFirstYield = 0.004, kYieldStep = 1.4, kYieldTravel = 0.2, kYieldStd = 0.25;
// [s] Delays near which the torque is linearised. With r'' of 10 rad/s^2 and 200 N m/rad, the quadratic term of 12 ms
// is 0.14 N m.
constexpr double kDelays[] = {0.003, 0.006, 0.012, 0.024, 0.048};

const char* const kEfforts = "the same motion slower, and with a smaller load: efforts that stay below the limit";
const char* const kBraking = "motions that the drive brakes, with small and with large efforts";
const char* const kSpeeds = "constant speeds, slow and fast, in both directions, in postures of different load";

// Columns of the table that are smooth functions of the motion at one sample.
Matrix calc_smooth(const TorqueData&, const R& r, const Term& t) {
  Matrix out(r.kept(), t.columns());
  double columns[2];
  for (long k = 0; k < r.kept(); ++k) {
    const long row = r.full_row(k);
    const JointSample sample{r.q(row, t.place),      r.v(row, t.place),          r.a(row, t.place), 0.0,
                             r.effort(row, t.place), r.effort_rate(row, t.place)};
    t.effect().torque.calc_columns(sample, &t.shape, columns);
    for (long c = 0; c < out.cols(); ++c) out(k, c) = columns[c];
  }
  return out;
}

Matrix calc_nominal(const TorqueData&, const R& r, const Term& t) {
  Matrix out(r.kept(), 1);
  for (long k = 0; k < r.kept(); ++k) out(k, 0) = r.tau(r.full_row(k), t.place);
  return out;
}

// The direction of motion is not smooth, so it passes the same filter as the torque.
Matrix calc_direction(const TorqueData& data, const R& r, const Term& t) { return data.calc_direction(r, t.place); }

Matrix calc_load(const TorqueData& data, const R& r, const Term& t) {
  return data.condition(r, data.calc_sign(r, t.place).cwiseProduct(r.load.col(t.place).cwiseAbs()));
}

// Torque of a load that drives a gear backwards: tau against the motion.
Matrix calc_backwards(const TorqueData& data, const R& r, const Term& t) {
  const Vector sign = data.calc_sign(r, t.place);
  const Eigen::ArrayXd tau = r.tau.col(t.place).array(), driven = (sign.array() * tau < 0.0).cast<double>();
  return data.condition(r, (-(sign.array().abs() * tau) * driven).matrix());
}

Matrix calc_excess(const TorqueData& data, const R& r, const Term& t) {
  const Eigen::ArrayXd sign = data.calc_sign(r, t.place).array();
  return data.condition(r, (sign * (-(r.speed.col(t.place).array() / t.shape).square()).exp()).matrix());
}

Matrix calc_late_command(const TorqueData& data, const R& r, const Term& t) {
  const CalcLate late = find_late(data, t.place);
  Matrix out(r.kept(), 1);
  for (long k = 0; k < r.kept(); ++k) out(k, 0) = late(r, t.place, r.full_row(k), t.shape);
  return out;
}

Matrix calc_late_log(const TorqueData&, const R& r, const Term& t) {
  Matrix out(r.kept(), 1);
  for (long k = 0; k < r.kept(); ++k) out(k, 0) = -calc_coming(r, t.place, r.full_row(k), t.shape);
  return out;
}

Matrix calc_memory(const TorqueData& data, const R& r, const Term& t) {
  return data.condition(r, calc_memory_state(t.effect(), r.q.col(t.place), t.shape));
}

Matrix calc_ripple(const TorqueData& data, const R& r, const Term& t) {
  Matrix out(r.kept(), 2);
  out.col(0) = data.condition(r, (t.shape * r.q.col(t.place).array()).sin().matrix());
  out.col(1) = data.condition(r, (t.shape * r.q.col(t.place).array()).cos().matrix());
  return out;
}

std::vector<double> list_stribeck_velocities(const TorqueData& data, int joint) {
  const double fast = find_fast_speed(data, joint);
  std::vector<double> list;
  for (double share : kStribeckShares) {
    if (share * fast > data.slow[static_cast<size_t>(joint)]) list.push_back(share * fast);
  }
  return list;
}

// Yield angles that the joint exceeds; with a larger one it acts as a spring.
std::vector<double> list_yield_angles(const TorqueData& data, int joint) {
  double low = 1e300, high = -1e300;
  for (const R& r : data.recordings) {
    low = std::min(low, r.q.col(joint).minCoeff());
    high = std::max(high, r.q.col(joint).maxCoeff());
  }
  std::vector<double> list;
  for (double yield = kFirstYield; yield < kYieldTravel * (high - low); yield *= kYieldStep) list.push_back(yield);
  return list;
}

std::vector<double> list_loads(const TorqueData& data, int joint) {
  return {data.loaded_by_drive[static_cast<size_t>(joint)] ? kLoadOfDrive : kLoadOfBodies};
}

std::vector<double> list_springs(const TorqueData& data, int) {
  return data.behind_gears ? std::vector<double>{} : std::vector<double>{0.0};
}

// Of servos whose law gives the effort, and of drives that are told an effort.
std::vector<double> list_own_delays(const TorqueData& data, int joint) {
  const bool by_law = data.source[static_cast<size_t>(joint)] == EffortSource::kServoLaw;
  return by_law || is_effort_driven(*data.experiment) ? list_delays() : std::vector<double>{};
}

std::vector<double> list_log_delays(const TorqueData& data, int joint) {
  return data.source[static_cast<size_t>(joint)] == EffortSource::kRecorded ? list_delays() : std::vector<double>{};
}

// The coefficient is 1 - k.
TermValues make_gain(const Term&, const Vector& x, const Vector& s) { return {{1.0 - x[0]}, {s[0]}}; }
Vector take_gain(const std::vector<double>& p) { return Vector::Constant(1, 1.0 - p[0]); }

TermValues make_gain_of_model(const Term&, const Vector& x, const Vector& s) {
  return {{1.0 / (1.0 + x[0])}, {s[0] / std::pow(1.0 + x[0], 2)}};
}

// k q - k rest
TermValues make_spring(const Term&, const Vector& x, const Vector& s) {
  const double rest = x[0] != 0.0 ? -x[1] / x[0] : 0.0;
  return {{x[0], rest}, {s[0], std::hypot(s[1], rest * s[0]) / std::max(1e-12, std::abs(x[0]))}};
}
Vector take_spring(const std::vector<double>& p) { return Eigen::Vector2d(p[0], -p[0] * p[1]); }

// The ripple acts on the joint, so the missing torque has the opposite sign: -A cos(phase) sin(N q) - A sin(phase)
// cos(N q).
TermValues make_cogging(const Term& t, const Vector& x, const Vector& s) {
  return {{x.norm(), t.shape, std::atan2(-x[1], -x[0])}, {s[0], 0.1 * t.shape, s[0] / std::max(1e-12, x.norm())}};
}
Vector take_cogging(const std::vector<double>& p) {
  return Eigen::Vector2d(-p[0] * std::cos(p[2]), -p[0] * std::sin(p[2]));
}

// The coefficient is the share of the effort beyond the limit that is not there: all of it. The limit is known as the
// effort is.
TermValues make_limit(const Term& t, const Vector&, const Vector&) { return {{t.shape}, {kKnown * t.shape}}; }
Vector take_whole(const std::vector<double>&) { return Vector::Ones(1); }

// The coefficient is the share of the effort within the zone that is not there. Larger efforts lose the whole width,
// whatever the filter makes of its corners.
TermValues make_dead_zone(const Term& t, const Vector& x, const Vector& s) {
  return {{x[0] * t.shape}, {std::hypot(s[0], kKnown) * t.shape}};
}

// The coefficient is the torque of the yielded element: stiffness times yield angle.
TermValues make_hysteresis(const Term& t, const Vector& x, const Vector& s) {
  return {{x[0] / t.shape, t.shape}, {std::hypot(s[0], kYieldStd * x[0]) / t.shape, kYieldStd * t.shape}};
}
Vector take_hysteresis(const std::vector<double>& p) { return Vector::Constant(1, p[0] * p[1]); }

}  // namespace

double find_fast_speed(const TorqueData& data, int joint) {
  std::vector<double> speeds;
  for (const R& r : data.recordings) {
    for (long k = 0; k < r.kept(); ++k) {
      if (r.use(k, joint)) speeds.push_back(std::abs(r.v(r.full_row(k), joint)));
    }
  }
  return find_quantile(std::move(speeds), kNearlyAll);
}

std::vector<double> list_delays() { return {std::begin(kDelays), std::end(kDelays)}; }

std::vector<TermRow> make_joint_rows() {
  using T = TermRow;
  return {Row("viscous_friction", 0.5, kSpeeds).column(&calc_smooth).positive().is(&T::usual).is(&T::of_motor_and_gear),
          Row("coulomb_friction", 0.5, kSpeeds)
              .column(&calc_direction)
              .positive()
              .is(&T::usual)
              .is(&T::of_motor_and_gear)
              .is(&T::level),
          Row("load_dependent_friction", 2.0, kSpeeds)
              .column(&calc_load)
              .shapes(&list_loads)
              .within(0.0, kMostLoss)
              .is(&T::of_motor_and_gear)
              .is(&T::by_load),
          Row("backdriving_friction", 2.0, kSpeeds)
              .column(&calc_backwards)
              .within(0.0, kMostHeld)
              .is(&T::needs_drive)
              .is(&T::of_motor_and_gear)
              .is(&T::backwards)
              .is(&T::only_beside_all),
          Row("rotor_inertia", 0.5, kReversals).column(&calc_smooth).positive().is(&T::usual).is(&T::of_motor_and_gear),
          // Cost ln 2: a torque constant is as often wrong as right. Its size has a cost, too (calc_factor_cost).
          Row("torque_constant_error", 0.7, kPostures)
              .column(&calc_smooth)
              .within(1.0 - kMostGain, 1.0 - kLeastGain)
              .parameters(&make_gain, &take_gain)
              .worth_saying_from(kMaterialFactor)
              .is(&T::needs_drive)
              .is(&T::scales_effort),
          Row("torque_constant_error", 0.7, kPostures)
              .column(&calc_nominal)
              .parameters(&make_gain_of_model, nullptr)
              .is(&T::needs_drive)
              .is(&T::scales_model),
          Row("constant_torque", 2.0, kSweeps).column(&calc_smooth).constant_in(0),
          Row("actuator_lag", 3.0, kReversals).column(&calc_smooth).within(0.0, kLongest).is(&T::needs_drive),
          // A late bus or filter affects all joints; a delay of a single joint is rare.
          Row("sensor_delay", 6.0, kReversals)
              .column(&calc_late_log)
              .shapes(&list_log_delays)
              .within(0.0, kLongest)
              .is(&T::needs_drive)
              .is(&T::scanned)
              .is(&T::of_log),
          Row("parallel_spring", 3.0, kSweeps)
              .column(&calc_smooth, 2)
              .shapes(&list_springs)
              .positive()
              .parameters(&make_spring, &take_spring)
              .constant_in(1),
          Row("command_delay", 3.0, kReversals)
              .column(&calc_late_command)
              .shapes(&list_own_delays)
              .within(0.0, kLongest)
              .is(&T::scanned)
              .is(&T::late),
          Row("stribeck_friction", 2.0, kSpeeds)
              .column(&calc_excess)
              .shapes(&list_stribeck_velocities)
              .positive()
              .shaped_by(2)
              .is(&T::excess),
          Row("cogging", 3.0, kSweeps)
              .column(&calc_ripple, 2)
              .shapes(&find_ripples)
              .parameters(&make_cogging, &take_cogging)
              .shaped_by(1)
              .is(&T::needs_drive),
          Row("torque_saturation", 3.0, kEfforts)
              .column(&calc_smooth)
              .shapes(&find_limits)
              .within(kMostly, 1.0 / kMostly)
              .parameters(&make_limit, &take_whole)
              .shaped_by(0)
              .is(&T::needs_drive),
          Row("dead_zone", 3.0, kBraking)
              .column(&calc_smooth)
              .shapes(&find_dead_zones)
              .within(kMostly, 1.0 / kMostly)
              .parameters(&make_dead_zone, &take_whole)
              .shaped_by(0)
              .is(&T::needs_drive),
          Row("hysteresis", 3.0, kReversals)
              .column(&calc_memory)
              .shapes(&list_yield_angles)
              .positive()
              .parameters(&make_hysteresis, &take_hysteresis)
              .shaped_by(1)
              .shape_above(kFirstYield)
              .is(&T::memory)
              .is(&T::only_beside_all)};
}

bool TermRow::allows(const Vector& coefficients, double reach) const {
  if (load) return coefficients[0] > 0.0 && coefficients.tail<3>().norm() < reach * coefficients[0];
  if (within_reach) return coefficients.norm() < reach;
  const double size = by_norm ? coefficients.norm() : coefficients[0];
  return size >= low && size <= high;
}

const std::vector<TermRow>& list_term_rows() {
  static const std::vector<TermRow> rows = [] {
    std::vector<TermRow> all = make_joint_rows();
    for (const TermRow& row : make_whole_rows()) all.push_back(row);
    return all;
  }();
  return rows;
}

const TermRow& find_term_row(bool TermRow::*property) {
  const std::vector<TermRow>& rows = list_term_rows();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const TermRow& r) { return r.*property; });
  HRP_CHECK(row != rows.end(), "no term has a property that code asks for");
  return *row;
}

}  // namespace hrp::diagnosis

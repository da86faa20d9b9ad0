// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/term_rows.h"

#include <cmath>

namespace hrp::diagnosis {
namespace {

using Matrix = Eigen::MatrixXd;
using R = TorqueRecording;

constexpr double kLongest = 0.1;     // [s] of a drive's lag or delay
constexpr double kMostLoss = 0.6;    // of the load: no transmission loses so much
constexpr double kMostHeld = 0.8;    // of the load: a gear that holds more is not seen to be turned back by it
constexpr double kLeastGain = 0.5, kMostGain = 2.0;
constexpr double kLeastMass = 0.3, kMostMass = 3.0;  // of a link's nominal mass
constexpr double kMostAngle = 0.3;   // [rad] that a linear term of a zero or a tilt reaches
constexpr double kLeastCarried = 0.3, kMostCarried = 1.1;  // of gravity: less is a mass that is wrong
constexpr double kMaterialFactor = 0.03, kMaterialAngle = 0.003;  // [rad]

const char* const kSpeeds = "constant speeds, slow and fast, in both directions, in postures of different load";
const char* const kReversals = "short, fast reversals of this joint alone";
const char* const kSweeps = "slow sweeps of the joint over its whole range, in postures of different load";
const char* const kPostures = "postures held, and slow motion of every joint, with a known mass hung on and without";
const char* const kLook = "look whether the log's effort is the whole of the drive's torque, and whether a spring or a counterweight carries the arm";

// Kept samples of a series of the full grid.
Matrix keep(const R& r, const Eigen::VectorXd& full) {
  Matrix out(r.kept(), 1);
  for (long k = 0; k < r.kept(); ++k) out(k, 0) = full[r.full_row(k)];
  return out;
}

Matrix calc_speed(const TorqueData&, const R& r, const Term& t) { return keep(r, r.v.col(t.place)); }
Matrix calc_acceleration(const TorqueData&, const R& r, const Term& t) { return keep(r, r.a.col(t.place)); }
Matrix calc_effort(const TorqueData&, const R& r, const Term& t) { return keep(r, r.effort.col(t.place)); }
Matrix calc_effort_rate(const TorqueData&, const R& r, const Term& t) { return keep(r, r.effort_rate.col(t.place)); }
Matrix calc_nominal(const TorqueData&, const R& r, const Term& t) { return keep(r, r.tau.col(t.place)); }
Matrix calc_one(const TorqueData&, const R& r, const Term&) { return Matrix::Ones(r.kept(), 1); }

Matrix calc_direction(const TorqueData& data, const R& r, const Term& t) { return data.condition(r, data.calc_sign(r, t.place)); }

Matrix calc_load(const TorqueData& data, const R& r, const Term& t) {
  return data.condition(r, data.calc_sign(r, t.place).cwiseProduct(r.tau.col(t.place).cwiseAbs()));
}

// What the load does to a gear that it drives backwards: tau against the motion.
Matrix calc_backwards(const TorqueData& data, const R& r, const Term& t) {
  const Eigen::VectorXd sign = data.calc_sign(r, t.place);
  const Eigen::ArrayXd tau = r.tau.col(t.place).array(), driven = (sign.array() * tau < 0.0).cast<double>();
  return data.condition(r, (-(sign.array().abs() * tau) * driven).matrix());
}

Matrix calc_excess(const TorqueData& data, const R& r, const Term& t) {
  const Eigen::ArrayXd sign = data.calc_sign(r, t.place).array();
  return data.condition(r, (sign * (-(r.v.col(t.place).array() / t.shape).square()).exp()).matrix());
}

Matrix calc_spring(const TorqueData&, const R& r, const Term& t) {
  Matrix out = Matrix::Ones(r.kept(), 2);
  out.col(0) = keep(r, r.q.col(t.place));
  return out;
}

Matrix calc_late_command(const TorqueData&, const R& r, const Term& t) {
  Matrix out(r.kept(), 1);
  for (long k = 0; k < r.kept(); ++k) out(k, 0) = calc_late(r, t.place, r.full_row(k), t.shape);
  return out;
}

Matrix calc_ripple(const TorqueData& data, const R& r, const Term& t) {
  Matrix out(r.kept(), 2);
  out.col(0) = data.condition(r, (t.shape * r.q.col(t.place).array()).sin().matrix());
  out.col(1) = data.condition(r, (t.shape * r.q.col(t.place).array()).cos().matrix());
  return out;
}

// For a row to be written in one expression.
struct Row : TermRow {
  Row(TermKind kind_in, const char* name, double nats, const char* motion_in) {
    kind = kind_in, effect = find_effect(name)->id, cost = nats, motion = motion_in;
  }
  Row& column(decltype(TermRow::calc_columns) calc, int count = 1) { return calc_columns = calc, columns = count, *this; }
  Row& in_all_rows(PlaceKind at, int count) { return whole = true, place = at, columns = count, *this; }
  Row& within(double least, double most) { return low = least, high = most, *this; }
  Row& positive() { return low = 0.0, *this; }
  Row& small_angle() { return by_norm = true, material = kMaterialAngle, within(0.0, kMostAngle); }
  Row& worth_saying_from(double size) { return material = size, *this; }
  Row& of_drives() { return needs_drive = true, *this; }
  Row& of_all_drives() { return usual = true, *this; }
  Row& loss_or_rotor() { return of_motor_and_gear = true, *this; }
  Row& in_shapes() { return scanned = true, *this; }
  Row& of_timing() { return late = true, *this; }
  Row& as_factor() { return factor = true, *this; }
};

std::vector<TermRow> make_joint_rows() {
  using K = TermKind;
  return {
      Row(K::kViscous, "viscous_friction", 0.5, kSpeeds).column(calc_speed).positive().of_all_drives().loss_or_rotor(),
      Row(K::kDry, "coulomb_friction", 0.5, kSpeeds).column(calc_direction).positive().of_all_drives().loss_or_rotor(),
      Row(K::kLoadDry, "load_dependent_friction", 2.0, kSpeeds).column(calc_load).within(0.0, kMostLoss).loss_or_rotor(),
      Row(K::kBackdriven, "backdriving_friction", 2.0, kSpeeds).column(calc_backwards).within(0.0, kMostHeld).of_drives().loss_or_rotor(),
      Row(K::kStribeck, "stribeck_friction", 2.0, kSpeeds).column(calc_excess).positive().in_shapes(),
      Row(K::kRotor, "rotor_inertia", 0.5, kReversals).column(calc_acceleration).positive().of_drives().of_all_drives().loss_or_rotor(),
      // ln 2: as many torque constants are off as right; by how much costs, too. The coefficient is 1 - k.
      Row(K::kGain, "torque_constant_error", 0.7, kPostures).column(calc_effort).within(1.0 - kMostGain, 1.0 - kLeastGain)
          .worth_saying_from(kMaterialFactor).of_drives(),
      Row(K::kGainOfModel, "torque_constant_error", 0.7, kPostures).column(calc_nominal).of_drives(),
      Row(K::kConstant, "constant_torque", 2.0, kSweeps).column(calc_one),
      Row(K::kSpring, "parallel_spring", 3.0, kSweeps).column(calc_spring, 2).positive(),
      Row(K::kLag, "actuator_lag", 3.0, kReversals).column(calc_effort_rate).within(0.0, kLongest).of_drives(),
      Row(K::kCommandDelay, "command_delay", 3.0, kReversals).column(calc_late_command).within(0.0, kLongest).in_shapes().of_timing(),
      Row(K::kCogging, "cogging", 3.0, kSweeps).column(calc_ripple, 2).in_shapes().of_drives()};
}

// The costs of terms with several parameters are those of the parameters, too.
std::vector<TermRow> make_whole_rows() {
  using K = TermKind;
  return {
      Row(K::kPayload, "payload", 9.0, kPostures).in_all_rows(PlaceKind::kLink, 4),
      Row(K::kMassError, "mass_error", 4.0, kPostures).in_all_rows(PlaceKind::kLink, 1).within(kLeastMass - 1.0, kMostMass - 1.0)
          .worth_saying_from(kMaterialFactor).as_factor(),
      Row(K::kComError, "com_error", 7.0, kPostures).in_all_rows(PlaceKind::kLink, 3),
      Row(K::kForce, "external_force", 7.0, kPostures).in_all_rows(PlaceKind::kLink, 3),
      Row(K::kOffset, "joint_offset", 4.0, kSweeps).in_all_rows(PlaceKind::kJoint, 1).small_angle(),
      Row(K::kTilt, "base_tilt", 5.0, kPostures).in_all_rows(PlaceKind::kNone, 2).small_angle(),
      Row(K::kCarried, "gravity_compensation", 5.0, kLook).in_all_rows(PlaceKind::kNone, 1).within(kLeastCarried, kMostCarried),
      Row(K::kBusDelay, "command_delay", 4.0, kReversals).in_all_rows(PlaceKind::kJoint, 1).within(0.0, kLongest).of_timing()};
}

}  // namespace

bool TermRow::allows(const Eigen::VectorXd& coefficients) const {
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

const TermRow& get_term_row(TermKind kind) { return list_term_rows()[static_cast<size_t>(kind)]; }

}  // namespace hrp::diagnosis

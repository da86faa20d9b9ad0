// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/links/rows.h"

#include <algorithm>
#include <cmath>

#include "common/spatial/rpy.h"
#include "common/spatial/turn.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/evidence/links/columns.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMostAngle = 1.0;  // [rad] largest encoder zero or sensor rotation
constexpr double kNear = 1e-3;      // [m], [rad] smaller moves of the linearisation point do not matter

const char* const kPostures = "many postures of the links beyond the sensor, held still";

LinkTermRow make_row(const EffectInfo& effect, PlaceKind place, int columns,
                     void (LinkColumns::*fill)(const LinkTerm&, Eigen::MatrixXd*)) {
  LinkTermRow row;
  row.effect = &effect;
  row.place = place;
  row.columns = columns;
  row.fill = fill;
  return row;
}

LinkTermRow make_load() {
  LinkTermRow row = make_row(get_effect(EffectId::kPayload), PlaceKind::kLink, 4, &LinkColumns::fill_load);
  row.cost = 9.0;  // four parameters
  row.load = true;
  row.find_start = [](const Experiment& e, int link) {
    return Vector3d(e.robot.tree.links[static_cast<size_t>(link)].inertia.p_LLcm_L);
  };
  row.move = [](const Eigen::VectorXd& p, Vector3d* near) {
    if (p[0] <= 0.0) return false;
    const Vector3d step = p.tail<3>() / p[0];
    *near += step;
    return step.norm() > kNear;
  };
  row.make_values = [](const LinkTerm& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s,
                       std::vector<double>* value, std::vector<double>* std) {
    const double mass = std::max(1e-12, p[0]);
    for (long i = 1; i < 4; ++i) {
      (*value)[static_cast<size_t>(i)] = term.near[i - 1] + p[i] / mass;
      (*std)[static_cast<size_t>(i)] = s[i] / mass;
    }
  };
  return row;
}

// A factor above 5 or below 0.2 means a wrong unit or another robot.
LinkTermRow as_factor(LinkTermRow row) {
  row.factor = true;
  row.low = 0.2 - 1.0;
  row.high = 5.0 - 1.0;
  return row;
}

LinkTermRow make_mass() {
  LinkTermRow row = as_factor(make_row(get_effect(EffectId::kMassError), PlaceKind::kLink, 1, &LinkColumns::fill_mass));
  row.needs_mass = true;
  return row;
}

LinkTermRow make_com() {
  LinkTermRow row = make_row(get_effect(EffectId::kComError), PlaceKind::kLink, 3, &LinkColumns::fill_com);
  row.cost = 7.0;
  row.needs_mass = row.by_norm = row.within_reach = true;
  return row;
}

LinkTermRow make_force() {
  LinkTermRow row = make_row(get_effect(EffectId::kExternalForce), PlaceKind::kLink, 3, &LinkColumns::fill_force);
  row.cost = 8.0;
  return row;
}

LinkTermRow make_offset() {
  LinkTermRow row = make_row(get_effect(EffectId::kJointOffset), PlaceKind::kJoint, 1, &LinkColumns::fill_offset);
  row.by_norm = row.of_encoder = row.moves_robot = true;
  row.high = kMostAngle;
  row.motion = kPostures;
  return row;
}

LinkTermRow make_spring() {
  LinkTermRow row = make_row(get_effect(EffectId::kSpring), PlaceKind::kJoint, 2, &LinkColumns::fill_spring);
  row.cost = 6.0;
  row.needs_torque = true;
  row.low = 0.0;
  row.make_values = [](const LinkTerm&, const Eigen::VectorXd& p, const Eigen::VectorXd& s, std::vector<double>* value,
                       std::vector<double>* std) {
    const double k = std::max(1e-12, p[0]);
    (*value)[1] = -p[1] / k;
    (*std)[1] = std::hypot(s[1], (*value)[1] * s[0]) / k;
  };
  return row;
}

LinkTermRow make_tilt() {
  LinkTermRow row = make_row(*find_effect("base_tilt"), PlaceKind::kLink, 2, &LinkColumns::fill_tilt);
  row.cost = 6.0;
  row.of_base = row.moves_robot = true;
  return row;
}

// Delay of a sensor's readings, or of the positions of all joints.
LinkTermRow make_delay(PlaceKind place, void (LinkColumns::*fill)(const LinkTerm&, Eigen::MatrixXd*)) {
  LinkTermRow row = make_row(get_effect(EffectId::kSensorDelay), place, 1, fill);
  row.low = 0.0;
  row.high = kLatest;
  row.motion = "short, fast reversals";
  row.move = [](const Eigen::VectorXd& p, Vector3d* near) {
    const bool moved = std::abs(near->x() - p[0]) > kKnown * p[0];
    near->x() = p[0];
    return moved;
  };
  return row;
}

LinkTermRow make_bias() {
  LinkTermRow row = make_row(get_effect(EffectId::kSensorBias), PlaceKind::kSensor, 1, &LinkColumns::fill_bias);
  row.cost = 2.0;
  row.cost_per_column = 1.5;
  row.by_group = row.each_axis = true;
  row.motion = kPostures;
  return row;
}

LinkTermRow make_scale() {
  LinkTermRow row =
      as_factor(make_row(get_effect(EffectId::kSensorScale), PlaceKind::kSensor, 1, &LinkColumns::fill_scale));
  row.by_group = true;
  return row;
}

LinkTermRow make_misalignment() {
  LinkTermRow row = make_row(get_effect(EffectId::kSensorMisalignment), PlaceKind::kSensor, 3, &LinkColumns::fill_turn);
  row.cost = 8.0;
  row.of_vectors = row.by_norm = true;
  row.high = kMostAngle;
  row.move = [](const Eigen::VectorXd& p, Vector3d* near) {
    const bool moved = (*near - p).norm() > kNear;
    *near = p;
    return moved;
  };
  row.make_values = [](const LinkTerm&, const Eigen::VectorXd& p, const Eigen::VectorXd&, std::vector<double>* value,
                       std::vector<double>*) {
    const Vector3d rpy = calc_rpy(make_turn(Vector3d(p)).toRotationMatrix());
    *value = {rpy.x(), rpy.y(), rpy.z()};
  };
  return row;
}

}  // namespace

const EffectInfo& LinkTerm::effect() const {
  return of_link_encoder ? get_effect(EffectId::kSensorBias) : *row->effect;
}

bool LinkTermRow::allows(const LinkTerm& term, const Eigen::VectorXd& p, double reach) const {
  if (load) return p[0] > 0.0 && (term.near + p.tail<3>() / p[0]).norm() < reach;
  const double size = by_norm ? p.norm() : p[0];
  return size > low && size < (within_reach ? reach : high);
}

const std::vector<LinkTermRow>& list_link_rows() {
  static const std::vector<LinkTermRow> rows = {make_load(),
                                                make_mass(),
                                                make_com(),
                                                make_force(),
                                                make_offset(),
                                                make_spring(),
                                                make_tilt(),
                                                make_delay(PlaceKind::kNone, &LinkColumns::fill_late_positions),
                                                make_bias(),
                                                make_scale(),
                                                make_delay(PlaceKind::kSensor, &LinkColumns::fill_late_sensor),
                                                make_misalignment()};
  return rows;
}

void find_link_values(const LinkTerm& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s,
                      std::vector<double>* value, std::vector<double>* std) {
  value->assign(p.data(), p.data() + p.size());
  std->assign(s.data(), s.data() + s.size());
  if (term.row->factor) (*value)[0] = 1.0 + p[0];
  if (term.row->make_values) term.row->make_values(term, p, s, value, std);
}

}  // namespace hrp::diagnosis

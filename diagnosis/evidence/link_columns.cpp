// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/link_columns.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/low_pass.h"

namespace hrp::diagnosis {
namespace {

constexpr double kAngleStep = 1e-4;  // [rad] differences of predictions over a position or over the base's attitude

// A sensor that is turned by the rotation vector phi reads exp(-phi x) x = x + a (x x phi) - b phi x (x x phi), with
// a = sin|phi| / |phi| and b = (1 - cos|phi|) / |phi|^2. Linear in phi where the first phi of the last term is `near`.
Vector3d calc_turn_column(const Vector3d& x, const Vector3d& near, int axis) {
  const double angle = near.norm();
  const double a = angle > 1e-6 ? std::sin(angle) / angle : 1.0, b = angle > 1e-6 ? (1.0 - std::cos(angle)) / (angle * angle) : 0.5;
  const Vector3d first = x.cross(Vector3d::Unit(axis));
  return a * first - b * near.cross(first);
}

class Lister {
 public:
  Lister(const LinkData& data, const LinkSensors& sensors, const LinkReadings& readings, const LinkPoints& points)
      : e_(*data.experiment), sensors_(sensors), readings_(readings), points_(points) {}

  std::vector<LinkTerm> list() {
    for (size_t link = 1; link < e_.robot.tree.links.size(); ++link) add_link(static_cast<int>(link));
    for (int j = 0; j < e_.num_joints(); ++j) {
      add(EffectId::kJointOffset, PlaceKind::kJoint, j, -1, 1);
      if (sensors_.has_torque(j)) add(EffectId::kSpring, PlaceKind::kJoint, j, -1, 2);
    }
    if (e_.scenario.gravity_W.norm() > 0.0) add(find_effect("base_tilt")->id, PlaceKind::kLink, 0, -1, 2);
    add(EffectId::kSensorDelay, PlaceKind::kNone, 0, -1, 1);
    for (size_t s = 0; s < sensors_.sensors.size(); ++s) add_sensor(static_cast<int>(s));
    return std::move(terms_);
  }

 private:
  void add(EffectId id, PlaceKind place, int index, int group, int columns) {
    LinkTerm term{id, place, index, group, columns, Vector3d::Zero(), width_, false};
    if (id == EffectId::kPayload) term.near = points_.loads.empty() ? Vector3d(e_.robot.tree.links[static_cast<size_t>(index)].inertia.p_LLcm_L) : points_.loads[static_cast<size_t>(index)];
    if (id == EffectId::kSensorMisalignment && !points_.turns.empty()) term.near = points_.turns[static_cast<size_t>(index)];
    if (id == EffectId::kSensorDelay && !points_.delays.empty())
      term.near.x() = points_.delays[place == PlaceKind::kNone ? 0 : static_cast<size_t>(index) + 1];
    term.of_link_encoder = id == EffectId::kJointOffset && sensors_.has_encoder(index);
    terms_.push_back(term);
    width_ += columns;
  }

  void add_link(int link) {
    bool felt = false;
    for (size_t s = 0; s < sensors_.sensors.size(); ++s) felt = felt || readings_.is_beyond(s, link);
    if (!felt) return;
    add(EffectId::kPayload, PlaceKind::kLink, link, -1, 4);
    if (e_.robot.tree.links[static_cast<size_t>(link)].inertia.mass > 0.0) {
      add(EffectId::kMassError, PlaceKind::kLink, link, -1, 1);
      add(EffectId::kComError, PlaceKind::kLink, link, -1, 3);
    }
    add(EffectId::kExternalForce, PlaceKind::kLink, link, -1, 3);
  }

  void add_sensor(int s) {
    const bool vector = sensors_.sensors[static_cast<size_t>(s)].kind != LinkSensorKind::kTorque;
    for (size_t g = 0; g < readings_.groups().size(); ++g) {
      if (readings_.groups()[g].sensor != static_cast<size_t>(s)) continue;
      add(EffectId::kSensorBias, PlaceKind::kSensor, s, static_cast<int>(g), vector ? 3 : 1);
      add(EffectId::kSensorScale, PlaceKind::kSensor, s, static_cast<int>(g), 1);
    }
    add(EffectId::kSensorDelay, PlaceKind::kSensor, s, -1, 1);
    if (vector) add(EffectId::kSensorMisalignment, PlaceKind::kSensor, s, -1, 3);
  }

  const Experiment& e_;
  const LinkSensors& sensors_;
  const LinkReadings& readings_;
  const LinkPoints& points_;
  std::vector<LinkTerm> terms_;
  long width_ = 0;
};

// Gravity as a base sees it that is turned by an angle about x (roll) or y (pitch).
Vector3d turn_gravity(const Experiment& e, int axis, double angle) {
  return Eigen::AngleAxisd(-angle, Vector3d::Unit(axis)) * e.scenario.gravity_W;
}

// Columns of one recording, moment by moment.
class Maker {
 public:
  Maker(const LinkRecording& r, const std::vector<LinkTerm>& terms, const Experiment& e, LinkReadings* readings)
      : r_(r), terms_(terms), readings_(*readings) {
    for (int axis = 0; axis < 2; ++axis) {
      for (double sign : {1.0, -1.0}) turned_.push_back(readings->turn(turn_gravity(e, axis, sign * kAngleStep)));
    }
    for (const LinkTerm& term : terms) width_ += term.columns;
    rate_.resize(r.predicted.rows(), r.predicted.cols());
    for (long c = 0; c < rate_.cols(); ++c) rate_.col(c) = differentiate(r.predicted.col(c), r.step);
  }

  Eigen::MatrixXd make(long row) {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(readings_.size(), width_);
    q_ = r_.q.row(row), v_ = r_.v.row(row), a_ = r_.a.row(row);
    readings_.move(q_, v_, a_);
    for (const LinkTerm& term : terms_) {
      if (term.place == PlaceKind::kLink && term.index > 0) fill_link(term, &out);
      if (term.place == PlaceKind::kSensor) fill_sensor(term, row, &out);
      if (term.place == PlaceKind::kNone) out.col(term.first) = calc_change(row, -term.near.x());
      if (term.id == EffectId::kSpring) fill_spring(term, &out);
    }
    for (const LinkTerm& term : terms_) {  // these move the robot: last
      if (term.id == EffectId::kJointOffset) fill_offset(term, &out);
      if (term.place == PlaceKind::kLink && term.index == 0) fill_tilt(term, &out);
    }
    return out;
  }

 private:
  // Mean rate of the predicted readings over the `delay` [s] before the row, or after it where that is negative.
  Eigen::VectorXd calc_change(long row, double delay) const {
    if (std::abs(delay) < r_.step) return rate_.row(row).transpose();
    const double at = std::clamp(static_cast<double>(row) - delay / r_.step, 0.0, static_cast<double>(rate_.rows() - 1));
    const long low = std::min(static_cast<long>(at), rate_.rows() - 2);
    const double part = at - static_cast<double>(low);
    const Eigen::VectorXd then = ((1.0 - part) * r_.predicted.row(low) + part * r_.predicted.row(low + 1)).transpose();
    return (r_.predicted.row(row).transpose() - then) / ((static_cast<double>(row) - at) * r_.step);
  }

  void fill_link(const LinkTerm& term, Eigen::MatrixXd* out) const {
    auto columns = out->middleCols(term.first, term.columns);
    if (term.id == EffectId::kPayload) columns = readings_.calc_load_columns({term.index, term.near});
    if (term.id == EffectId::kMassError) columns = readings_.calc_mass_column(term.index);
    if (term.id == EffectId::kComError) columns = readings_.calc_com_columns(term.index);
    if (term.id == EffectId::kExternalForce) columns = readings_.calc_force_columns(term.index);
  }

  void fill_sensor(const LinkTerm& term, long row, Eigen::MatrixXd* out) const {
    for (size_t g = 0; g < readings_.groups().size(); ++g) {
      const ReadingGroup& group = readings_.groups()[g];
      if (group.sensor != static_cast<size_t>(term.index) || (term.group >= 0 && term.group != static_cast<int>(g))) continue;
      auto block = out->block(group.first, term.first, group.size, term.columns);
      if (term.id == EffectId::kSensorBias) block.setIdentity();
      if (term.id == EffectId::kSensorScale) block = r_.predicted.row(row).segment(group.first, group.size).transpose();
      if (term.id == EffectId::kSensorDelay) block = -calc_change(row, term.near.x()).segment(group.first, group.size);
      if (term.id != EffectId::kSensorMisalignment) continue;
      const Vector3d x = r_.predicted.row(row).segment(group.first, 3);  // reads R(rpy)^T x
      for (int axis = 0; axis < 3; ++axis) block.col(axis) = calc_turn_column(x, term.near, axis);
    }
  }

  // The spring beside the gear carries what the gear does not: read = needed + k (q - rest).
  void fill_spring(const LinkTerm& term, Eigen::MatrixXd* out) const {
    for (const ReadingGroup& group : readings_.groups()) {
      if (readings_.sensors()[group.sensor].joint != term.index) continue;
      (*out)(group.first, term.first) = q_[term.index], (*out)(group.first, term.first + 1) = 1.0;
    }
  }

  // True position = reading - offset.
  void fill_offset(const LinkTerm& term, Eigen::MatrixXd* out) {
    const double q = q_[term.index];
    q_[term.index] = q + kAngleStep;
    readings_.move(q_, v_, a_);
    const Eigen::VectorXd ahead = readings_.calc();
    q_[term.index] = q - kAngleStep;
    readings_.move(q_, v_, a_);
    out->col(term.first) = (readings_.calc() - ahead) / (2.0 * kAngleStep);
    q_[term.index] = q;
  }

  // Central: what is left of gravity's size would stand for a weight of any size.
  void fill_tilt(const LinkTerm& term, Eigen::MatrixXd* out) {
    for (LinkReadings& turned : turned_) turned.move(q_, v_, a_);
    for (size_t axis = 0; axis < 2; ++axis)
      out->col(term.first + static_cast<long>(axis)) = (turned_[2 * axis].calc() - turned_[2 * axis + 1].calc()) / (2.0 * kAngleStep);
  }

  const LinkRecording& r_;
  const std::vector<LinkTerm>& terms_;
  LinkReadings& readings_;
  std::vector<LinkReadings> turned_;  // by axis: forwards, backwards
  Eigen::MatrixXd rate_;  // of the predicted readings
  Eigen::VectorXd q_, v_, a_;
  long width_ = 0;
};

}  // namespace

std::vector<LinkTerm> list_link_terms(const LinkData& data, const LinkSensors& sensors, const LinkReadings& readings,
                                      const LinkPoints& points) {
  return Lister(data, sensors, readings, points).list();
}

std::vector<Eigen::MatrixXd> calc_link_columns(const LinkRecording& r, const std::vector<LinkTerm>& terms,
                                               const Experiment& e, LinkReadings* readings) {
  std::vector<Eigen::MatrixXd> out;
  Maker maker(r, terms, e, readings);
  for (long row = r.trim; row < r.q.rows() - r.trim; row += r.stride) out.push_back(maker.make(row));
  return out;
}

}  // namespace hrp::diagnosis

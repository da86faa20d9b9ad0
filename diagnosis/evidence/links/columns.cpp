// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/links/columns.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/low_pass.h"
#include "diagnosis/measurement/torque/term_rows.h"

namespace hrp::diagnosis {
namespace {

// A sensor that is turned by the rotation vector phi reads exp(-phi x) x = x + a (x x phi) - b phi x (x x phi), with a
// = sin|phi| / |phi| and b = (1 - cos|phi|) / |phi|^2. The column is linear in phi: a, b and the first phi of the last
// term are taken at `near`.
Vector3d calc_turn_column(const Vector3d& x, const Vector3d& near, int axis) {
  const double angle = near.norm();
  const double a = angle > 1e-6 ? std::sin(angle) / angle : 1.0,
               b = angle > 1e-6 ? (1.0 - std::cos(angle)) / (angle * angle) : 0.5;
  const Vector3d first = x.cross(Vector3d::Unit(axis));
  return a * first - b * near.cross(first);
}

class Lister {
 public:
  Lister(const LinkData& data, const LinkSensors& sensors, const LinkReadings& readings, const LinkPoints& points)
      : e_(*data.experiment), sensors_(sensors), readings_(readings), points_(points) {}

  std::vector<LinkTerm> list() {
    for (size_t link = 1; link < e_.robot.tree.links.size(); ++link) add_link(static_cast<int>(link));
    for (int j = 0; j < e_.num_joints(); ++j) add_joint(j);
    for (const LinkTermRow& row : list_link_rows()) {
      if (row.of_base && e_.scenario.gravity_W.norm() > 0.0) add(row, 0);
    }
    for (const LinkTermRow& row : list_link_rows()) {
      if (row.place == PlaceKind::kNone) add(row, 0);
    }
    for (size_t s = 0; s < sensors_.sensors.size(); ++s) add_sensor(static_cast<int>(s));
    return std::move(terms_);
  }

 private:
  void add(const LinkTermRow& row, int index, int group = -1, int axes = 1) {
    LinkTerm term;
    term.row = &row;
    term.index = index;
    term.group = group;
    term.first = width_;
    term.columns = row.each_axis ? axes : row.columns;
    const LinkPoint* point = find_point(points_, row, index);
    if (point)
      term.near = point->near;
    else if (row.find_start)
      term.near = row.find_start(e_, index);
    term.of_link_encoder = row.of_encoder && sensors_.has_encoder(index);
    terms_.push_back(term);
    width_ += term.columns;
  }

  void add_link(int link) {
    bool felt = false;
    for (size_t s = 0; s < sensors_.sensors.size(); ++s) felt = felt || readings_.is_beyond(s, link);
    const bool has_mass = e_.robot.tree.links[static_cast<size_t>(link)].inertia.mass > 0.0;
    for (const LinkTermRow& row : list_link_rows()) {
      if (row.place == PlaceKind::kLink && !row.of_base && felt && (has_mass || !row.needs_mass)) add(row, link);
    }
  }

  void add_joint(int joint) {
    for (const LinkTermRow& row : list_link_rows()) {
      if (row.place == PlaceKind::kJoint && (!row.needs_torque || sensors_.has_torque(joint))) add(row, joint);
    }
  }

  void add_sensor(int s) {
    const bool vector = sensors_.sensors[static_cast<size_t>(s)].kind != LinkSensorKind::kTorque;
    for (size_t g = 0; g < readings_.groups().size(); ++g) {
      if (readings_.groups()[g].sensor != static_cast<size_t>(s)) continue;
      for (const LinkTermRow& row : list_link_rows()) {
        if (row.place == PlaceKind::kSensor && row.by_group) add(row, s, static_cast<int>(g), vector ? 3 : 1);
      }
    }
    for (const LinkTermRow& row : list_link_rows()) {
      if (row.place == PlaceKind::kSensor && !row.by_group && (vector || !row.of_vectors)) add(row, s);
    }
  }

  const Experiment& e_;
  const LinkSensors& sensors_;
  const LinkReadings& readings_;
  const LinkPoints& points_;
  std::vector<LinkTerm> terms_;
  long width_ = 0;
};

// Gravity as a base sees it that is rotated about x (axis 0, roll) or y (axis 1, pitch) by `angle` [rad].
Vector3d turn_gravity(const Experiment& e, int axis, double angle) {
  return Eigen::AngleAxisd(-angle, Vector3d::Unit(axis)) * e.scenario.gravity_W;
}

}  // namespace

LinkColumns::LinkColumns(const LinkRecording& r, const std::vector<LinkTerm>& terms, const Experiment& e,
                         LinkReadings* readings)
    : r_(r), terms_(terms), readings_(*readings) {
  for (int axis = 0; axis < 2; ++axis) {
    for (double sign : {1.0, -1.0}) turned_.push_back(readings->turn(turn_gravity(e, axis, sign * kAngleStep)));
  }
  for (const LinkTerm& term : terms) width_ += term.columns;
  rate_.resize(r.predicted.rows(), r.predicted.cols());
  for (long c = 0; c < rate_.cols(); ++c) rate_.col(c) = differentiate(r.predicted.col(c), r.step);
}

Eigen::MatrixXd LinkColumns::make(long moment) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(readings_.size(), width_);
  moment_ = moment;
  q_ = r_.q.row(moment);
  v_ = r_.v.row(moment);
  a_ = r_.a.row(moment);
  readings_.move(q_, v_, a_);
  for (bool moves : {false, true}) {
    for (const LinkTerm& term : terms_) {
      if (term.row->moves_robot == moves) (this->*term.row->fill)(term, &out);
    }
  }
  return out;
}

// Mean rate of the predicted readings over the `delay` [s] before the sample, or after it if the delay is negative.
Eigen::VectorXd LinkColumns::calc_change(double delay) const {
  if (std::abs(delay) < r_.step) return rate_.row(moment_).transpose();
  const double at =
      std::clamp(static_cast<double>(moment_) - delay / r_.step, 0.0, static_cast<double>(rate_.rows() - 1));
  const long low = std::min(static_cast<long>(at), rate_.rows() - 2);
  const double part = at - static_cast<double>(low);
  const Eigen::VectorXd then = ((1.0 - part) * r_.predicted.row(low) + part * r_.predicted.row(low + 1)).transpose();
  return (r_.predicted.row(moment_).transpose() - then) / ((static_cast<double>(moment_) - at) * r_.step);
}

std::vector<const ReadingGroup*> LinkColumns::list_groups(const LinkTerm& term) const {
  std::vector<const ReadingGroup*> list;
  for (size_t g = 0; g < readings_.groups().size(); ++g) {
    const ReadingGroup& group = readings_.groups()[g];
    if (group.sensor == static_cast<size_t>(term.index) && (term.group < 0 || term.group == static_cast<int>(g)))
      list.push_back(&group);
  }
  return list;
}

void LinkColumns::fill_load(const LinkTerm& term, Eigen::MatrixXd* out) {
  out->middleCols(term.first, term.columns) = readings_.calc_load_columns({term.index, term.near});
}

void LinkColumns::fill_mass(const LinkTerm& term, Eigen::MatrixXd* out) {
  out->col(term.first) = readings_.calc_mass_column(term.index);
}

void LinkColumns::fill_com(const LinkTerm& term, Eigen::MatrixXd* out) {
  out->middleCols(term.first, term.columns) = readings_.calc_com_columns(term.index);
}

void LinkColumns::fill_force(const LinkTerm& term, Eigen::MatrixXd* out) {
  out->middleCols(term.first, term.columns) = readings_.calc_force_columns(term.index);
}

// True position = reading - offset.
void LinkColumns::fill_offset(const LinkTerm& term, Eigen::MatrixXd* out) {
  const double q = q_[term.index];
  q_[term.index] = q + kAngleStep;
  readings_.move(q_, v_, a_);
  const Eigen::VectorXd ahead = readings_.calc();
  q_[term.index] = q - kAngleStep;
  readings_.move(q_, v_, a_);
  out->col(term.first) = (readings_.calc() - ahead) / (2.0 * kAngleStep);
  q_[term.index] = q;
}

// A spring parallel to the gear carries the difference: read = needed + k (q - rest). Columns: k and -k rest.
void LinkColumns::fill_spring(const LinkTerm& term, Eigen::MatrixXd* out) {
  for (const ReadingGroup& group : readings_.groups()) {
    if (readings_.sensors()[group.sensor].joint != term.index) continue;
    (*out)(group.first, term.first) = q_[term.index];
    (*out)(group.first, term.first + 1) = 1.0;
  }
}

// Central difference. A one-sided difference would also change the size of gravity, which looks like a wrong mass.
void LinkColumns::fill_tilt(const LinkTerm& term, Eigen::MatrixXd* out) {
  for (LinkReadings& turned : turned_) turned.move(q_, v_, a_);
  for (size_t axis = 0; axis < 2; ++axis)
    out->col(term.first + static_cast<long>(axis)) =
        (turned_[2 * axis].calc() - turned_[2 * axis + 1].calc()) / (2.0 * kAngleStep);
}

void LinkColumns::fill_late_positions(const LinkTerm& term, Eigen::MatrixXd* out) {
  out->col(term.first) = calc_change(-term.near.x());
}

void LinkColumns::fill_bias(const LinkTerm& term, Eigen::MatrixXd* out) {
  for (const ReadingGroup* g : list_groups(term)) out->block(g->first, term.first, g->size, term.columns).setIdentity();
}

void LinkColumns::fill_scale(const LinkTerm& term, Eigen::MatrixXd* out) {
  for (const ReadingGroup* g : list_groups(term))
    out->col(term.first).segment(g->first, g->size) = r_.predicted.row(moment_).segment(g->first, g->size).transpose();
}

void LinkColumns::fill_late_sensor(const LinkTerm& term, Eigen::MatrixXd* out) {
  for (const ReadingGroup* g : list_groups(term))
    out->col(term.first).segment(g->first, g->size) = -calc_change(term.near.x()).segment(g->first, g->size);
}

// A misaligned sensor reads R(rpy)^T x.
void LinkColumns::fill_turn(const LinkTerm& term, Eigen::MatrixXd* out) {
  for (const ReadingGroup* g : list_groups(term)) {
    const Vector3d x = r_.predicted.row(moment_).segment(g->first, 3);
    for (int axis = 0; axis < 3; ++axis)
      out->block<3, 1>(g->first, term.first + axis) = calc_turn_column(x, term.near, axis);
  }
}

std::vector<LinkTerm> list_link_terms(const LinkData& data, const LinkSensors& sensors, const LinkReadings& readings,
                                      const LinkPoints& points) {
  return Lister(data, sensors, readings, points).list();
}

std::vector<Eigen::MatrixXd> calc_link_columns(const LinkRecording& r, const std::vector<LinkTerm>& terms,
                                               const Experiment& e, LinkReadings* readings) {
  std::vector<Eigen::MatrixXd> out;
  LinkColumns columns(r, terms, e, readings);
  for (long row = r.trim; row < r.q.rows() - r.trim; row += r.stride) out.push_back(columns.make(row));
  return out;
}

}  // namespace hrp::diagnosis

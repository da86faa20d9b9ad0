// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/torque_rows.h"

#include <algorithm>
#include <set>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// Seconds of training in which a joint is judged.
double calc_time(const TorqueData& data, int joint) {
  double time = 0.0;
  for (const TorqueRecording& r : data.recordings) {
    if (r.train) time += static_cast<double>(r.use.col(joint).count()) * r.step * static_cast<double>(r.stride);
  }
  return time;
}

void collect(const TorqueSide& side, std::vector<std::set<size_t>>* own, std::set<size_t>* whole) {
  for (size_t i = 0; i < own->size(); ++i) (*own)[i].insert(side.model.own[i].begin(), side.model.own[i].end());
  whole->insert(side.model.whole.begin(), side.model.whole.end());
}

}  // namespace

TorqueRows::TorqueRows(const OpenTerms& terms) : terms_(terms) {
  const TorqueDesign& design = terms.design;
  std::vector<std::set<size_t>> own(design.joints.size());
  std::set<size_t> whole;
  collect(terms.best, &own, &whole);
  for (const OpenQuestion& q : terms.questions) {
    collect(q.truth, &own, &whole);
    collect(q.rival, &own, &whole);
  }
  whole_.assign(whole.begin(), whole.end());
  for (size_t i = 0; i < own.size(); ++i) {
    const JointDesign& joint = design.joints[i];
    own_.emplace_back(own[i].begin(), own[i].end());
    columns_.emplace_back();
    for (size_t t : own_[i]) {
      for (long c : list_columns(joint, t)) columns_[i].push_back(c);
    }
    for (size_t t : whole_) {
      for (long c : list_whole_columns(design, joint, t)) columns_[i].push_back(c);
    }
    per_second_.push_back(joint.effective / std::max(1e-3, calc_time(*design.data, joint.joint)));
    left_.push_back(std::max(terms.best.fit.cross[i], kFloor * joint.spread * joint.spread));
  }
}

bool TorqueRows::measure(const Experiment& motion, MotionRows* rows) const {
  TorqueData data = make_torque_data(motion);
  if (data.recordings.empty()) return false;
  data.load_p_L = terms_.design.data->load_p_L;
  const TorqueRecording& r = data.recordings[0];
  std::vector<Term> whole;
  for (size_t t : whole_) whole.push_back(terms_.design.whole[t]);
  const std::vector<Eigen::MatrixXd> common = calc_whole_columns(data, r, whole);
  rows->step = r.step * static_cast<double>(r.stride);
  for (long k = 0; k < r.kept(); ++k) rows->time.push_back(r.time(k));
  for (size_t i = 0; i < columns_.size(); ++i) {
    const JointDesign& joint = terms_.design.joints[i];
    Eigen::MatrixXd x(r.kept(), static_cast<long>(columns_[i].size()));
    long at = 0;
    for (size_t t : own_[i]) {
      const Term& term = joint.terms[t];
      x.middleCols(at, term.columns()) = calc_joint_columns(data, r, term);
      at += term.columns();
    }
    if (at < x.cols()) x.rightCols(x.cols() - at) = common[static_cast<size_t>(joint.joint)];
    Eigen::VectorXd nominal(r.kept());
    for (long k = 0; k < r.kept(); ++k) nominal[k] = r.effort(r.full_row(k), joint.joint) - r.missing(k, joint.joint);
    for (long k = 0; k < r.kept(); ++k) {
      if (!r.use(k, joint.joint)) x.row(k).setZero();
    }
    rows->x.push_back(std::move(x));
    rows->nominal.push_back(std::move(nominal));
  }
  return true;
}

std::vector<long> TorqueRows::list_slots_of(const TorqueSide& side, size_t i) const {
  std::vector<long> slots;
  const auto add = [&](const Term& term, size_t t, const std::vector<size_t>& model, const std::vector<long>& first) {
    const auto at = std::find(model.begin(), model.end(), t);
    for (int c = 0; c < term.columns(); ++c)
      slots.push_back(at == model.end() ? -1 : first[static_cast<size_t>(at - model.begin())] + c);
  };
  for (size_t t : own_[i]) add(terms_.design.joints[i].terms[t], t, side.model.own[i], side.slots.own[i]);
  for (size_t t : whole_) add(terms_.design.whole[t], t, side.model.whole, side.slots.whole);
  return slots;
}

Eigen::VectorXd TorqueRows::list_coefficients(const TorqueSide& side, size_t i) const {
  const std::vector<long> slots = list_slots_of(side, i);
  Eigen::VectorXd list = Eigen::VectorXd::Zero(static_cast<long>(slots.size()));
  for (size_t c = 0; c < slots.size(); ++c) {
    if (slots[c] >= 0) list[static_cast<long>(c)] = side.fit.theta[slots[c]];
  }
  return list;
}

Eigen::VectorXd TorqueRows::predict(const MotionRows& rows, const TorqueSide& side, size_t i) const {
  return rows.nominal[i] + rows.x[i] * list_coefficients(side, i);
}

Eigen::VectorXd TorqueRows::calc_range(const MotionRows& rows, const TorqueSide& side, size_t i) const {
  const Eigen::MatrixXd known = calc_known(side);
  // A parameter that the recordings do not show may be twice what it is, or nothing.
  const Eigen::VectorXd largest = (side.fit.theta.cwiseAbs() / kNinetyFive).cwiseMax(1e-9);
  const Eigen::VectorXd std = known.size() > 0 ? calc_expected_std(known, largest) : Eigen::VectorXd();
  const std::vector<long> slots = list_slots_of(side, i);
  Eigen::VectorXd range = Eigen::VectorXd::Zero(rows.x[i].rows());
  for (size_t c = 0; c < slots.size(); ++c) {
    if (slots[c] >= 0) range += kNinetyFive * std[slots[c]] * rows.x[i].col(static_cast<long>(c)).cwiseAbs();
  }
  return range;
}

Comparison TorqueRows::compare(const MotionRows& rows, const TorqueSide& truth, const TorqueSide& rival) const {
  Comparison out;
  out.along = Eigen::VectorXd::Zero(rival.slots.size);
  out.fisher = Eigen::MatrixXd::Zero(rival.slots.size, rival.slots.size);
  for (size_t i = 0; i < columns_.size(); ++i) {
    const std::vector<long> slots = list_slots_of(rival, i);
    const double weight = per_second_[i] * rows.step / left_[i];
    const Eigen::MatrixXd G = weight * (rows.x[i].transpose() * rows.x[i]);
    const Eigen::VectorXd d = list_coefficients(truth, i) - list_coefficients(rival, i), Gd = G * d;
    out.power += d.dot(Gd);
    if (!d.isZero(0.0)) out.count += per_second_[i] * rows.step * static_cast<double>(rows.x[i].rows());
    for (size_t a = 0; a < slots.size(); ++a) {
      if (slots[a] < 0) continue;
      out.along[slots[a]] += Gd[static_cast<long>(a)];
      for (size_t b = 0; b < slots.size(); ++b) {
        if (slots[b] >= 0) out.fisher(slots[a], slots[b]) += G(static_cast<long>(a), static_cast<long>(b));
      }
    }
  }
  return out;
}

double TorqueRows::calc_sample_time(size_t i) const {
  const JointDesign& joint = terms_.design.joints[i];
  return calc_time(*terms_.design.data, joint.joint) / std::max(1.0, joint.total.n);
}

Eigen::MatrixXd TorqueRows::calc_known(const TorqueSide& side) const {
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(side.slots.size, side.slots.size);
  for (size_t i = 0; i < columns_.size(); ++i) {
    const JointDesign& joint = terms_.design.joints[i];
    const std::vector<long> slots = list_slots_of(side, i);
    const double weight = joint.effective / std::max(1.0, joint.total.n) / left_[i];
    for (size_t a = 0; a < slots.size(); ++a) {
      for (size_t b = 0; b < slots.size(); ++b) {
        if (slots[a] >= 0 && slots[b] >= 0)
          known(slots[a], slots[b]) += weight * joint.total.get(columns_[i][a], columns_[i][b]);
      }
    }
  }
  return known;
}

}  // namespace hrp::diagnosis

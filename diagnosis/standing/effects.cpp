// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/effects.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/standing/sole.h"

namespace hrp::diagnosis::standing {
namespace {

const std::vector<StandRow>& list_rows() {
  static const std::vector<StandRow> rows = make_rows();
  return rows;
}

// True for scale factors: one coefficient with neutral value 1.
bool is_factor(const StandRow& row) { return row.neutral == std::vector<double>{1}; }

class Lister {
 public:
  Lister(const StandProblem& problem, const Hypothesis& base, const StandHints& hints)
      : p_(problem), base_(base), hints_(hints) {}

  std::vector<Effect> run() {
    for (int j = 0; j < p_.tree.num_joints(); ++j) {
      add_all(PlaceKind::kJoint, j);
      add_readings(j, &is_joint_sensor);
    }
    for (size_t link = 0; link < p_.tree.links.size(); ++link) {
      if (p_.tree.links[link].inertia.mass >= 1e-6) add_all(PlaceKind::kLink, static_cast<int>(link));
    }
    add_all(PlaceKind::kFoot, 0);
    add_all(PlaceKind::kGround, 0);
    for (size_t foot = 0; foot < p_.feet.size(); ++foot) add_readings(static_cast<int>(foot), &is_wrench);
    add_readings(0, &is_imu);
    return std::move(list_);
  }

 private:
  void add_all(PlaceKind kind, int index) {
    for (const StandRow& row : list_rows()) {
      const Effect none{row.id, {kind, index, Reading::kAll}, row.neutral};
      if (get_effect(row.id).place == kind && can_show(row, none)) add(row, none);
    }
  }

  void add_readings(int index, bool (*is_wanted)(const Effect&)) {
    for (const StandRow& row : list_rows()) {
      const Effect none{row.id, at_sensor(index, row.reading), row.neutral};
      if (row.reading != Reading::kAll && is_wanted(none) && can_show(row, none)) add(row, none);
    }
  }

  // True if the recordings can show the effect.
  bool can_show(const StandRow& row, const Effect& e) const {
    const auto i = static_cast<size_t>(e.place.index);
    const auto flat = [](const StandFoot& foot) { return foot.kind == SoleKind::kFlat; };
    if (is_joint(e))
      return (p_.is_driven(i) || (!row.at_drive && !row.bends_leg)) && (!row.by_command || p_.command[i]);
    if (is_foot(e) || row.tilts_feet) return std::all_of(p_.feet.begin(), p_.feet.end(), flat);
    if (e.place.reading == Reading::kOrientation) return p_.attitude;  // an estimated attitude has no sensor fault
    if (!is_joint_sensor(e)) return true;
    const bool effort = p_.is_driven(i) && p_.effort[i];
    if (e.place.reading == Reading::kEffort) return effort;
    if (e.place.reading == Reading::kVelocity) return p_.velocity[i];
    // A zero of the position log differs from an offset that the servo also has only if efforts and commands were
    // recorded.
    return get_effect(e.id).change.constant == 0.0 || (effort && p_.command[i]);
  }

  void add(const StandRow& row, const Effect& none) {
    for (const Effect& e : base_) {
      if (e.id == none.id && e.place == none.place) return;
      if (is_foot(none) && is_foot(e)) return;
    }
    std::vector<Start> starts(1);
    if (row.list_starts) starts = row.list_starts(p_, hints_, static_cast<size_t>(none.place.index));
    for (const Start& start : starts) {
      list_.push_back(none);
      std::vector<double>& p = list_.back().p;
      for (size_t f = 1; is_foot(none) && f < p_.feet.size(); ++f) p.insert(p.end(), none.p.begin(), none.p.end());
      for (const auto& [at, value] : start) p[at] = value;
    }
  }

  const StandProblem& p_;
  const Hypothesis& base_;
  const StandHints& hints_;
  std::vector<Effect> list_;
};

}  // namespace

const StandRow& get_row(const Effect& e) {
  const std::vector<StandRow>& rows = list_rows();
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const StandRow& r) { return r.id == e.id && r.reading == e.place.reading; });
  HRP_CHECK(row != rows.end(), "a standing robot's equations do not show this effect");
  return *row;
}

std::vector<Effect> list_candidates(const StandProblem& p, const Hypothesis& base, const StandHints& hints) {
  return Lister(p, base, hints).run();
}

bool is_sensible(const StandProblem& problem, const Effect& e) {
  const StandRow& row = get_row(e);
  for (double v : e.p) {
    if (!std::isfinite(v)) return false;
  }
  if (row.positive && e.p[0] <= row.neutral[0]) return false;
  if (is_foot(e)) {
    const size_t size = row.step.size();
    for (size_t at = 0; at < e.p.size(); at += size) {
      if (e.p[at] <= 0 || e.p[at + 2] <= 0) return false;
      if (size > kFootParameters && e.p[at + kFootParameters] <= 0) return false;
    }
    return true;
  }
  // A log may have another unit; a link's mass may not.
  if (is_factor(row)) return e.p[0] > 0.1 && e.p[0] < 5 && (!is_link(e) || std::abs(std::log(e.p[0])) <= kFactor);
  return !row.is_sensible || row.is_sensible(problem, e);
}

bool are_sensible(const StandProblem& problem, const Hypothesis& hypothesis) {
  return std::all_of(hypothesis.begin(), hypothesis.end(), [&](const Effect& e) { return is_sensible(problem, e); });
}

std::vector<Effect> list_richer(const StandProblem& problem, const Effect& e) {
  return get_row(e).list_richer ? get_row(e).list_richer(problem, e) : std::vector<Effect>{};
}

bool starts_away(const Effect& e) {
  const StandRow& row = get_row(e);
  return row.away || (row.drifts && e.p[0] != row.neutral[0]);
}

bool is_vector(const Effect& e) { return get_effect(e.id).vector && get_row(e).neutral.size() > 1; }

Effect make_soft_soles(const StandProblem& problem) {
  const auto& rows = list_rows();
  const auto is_sole = [](const StandRow& row) { return get_effect(row.id).place == PlaceKind::kFoot; };
  const EffectId id = std::find_if(rows.begin(), rows.end(), is_sole)->id;  // the simpler one comes first
  return {id, {PlaceKind::kFoot, 0, Reading::kAll}, std::vector<double>(kFootParameters * problem.feet.size(), 0.0)};
}

bool is_main(const Effect& e, size_t parameter) {
  const StandRow& row = get_row(e);
  if (is_foot(e)) {
    const size_t at = parameter % row.step.size();
    return at == 0 || at == 2;  // stiffness of roll and pitch
  }
  return parameter == 0 || row.all_count;
}

double find_give(const StandFoot& foot, int axis) {
  const Vector3d half = 0.5 * foot.size;
  if (half.head<2>().maxCoeff() > 100) return kRigidTilt;  // [m] no sole was described
  return kRigidTilt * std::pow(half.head<2>().maxCoeff() / (axis == 0 ? half.y() : half.x()), 2);
}

double find_sinking(const StandFoot& foot) {
  const double half = 0.5 * foot.size.head<2>().maxCoeff();
  return half > 100 ? 0 : kRigidTilt * half * half;
}

double find_bound(const StandProblem& problem, const Effect& e, size_t parameter) {
  if (is_foot(e)) {
    const size_t size = get_row(e).step.size(), at = parameter % size;
    return at == 0 || at == 2 ? find_give(problem.feet[parameter / size], at == 0 ? 0 : 1) : 0;
  }
  if (!get_row(e).bends_leg || parameter != 0) return 0;
  for (const StandFoot& foot : problem.feet) {
    Matrix3d R_LF = Matrix3d::Identity();  // orientation of the foot in the link, joints at zero
    for (int link = foot.link; link > 0; link = problem.tree.links[static_cast<size_t>(link)].parent) {
      const JointSpec& joint = problem.tree.links[static_cast<size_t>(link)].joint;
      const Vector3d axis = (R_LF.transpose() * joint.axis_F).cwiseAbs();
      if (link == e.place.index + 1) return axis.x() * find_give(foot, 0) + axis.y() * find_give(foot, 1);
      R_LF = joint.X_PF.R * R_LF;
    }
  }
  return 0;
}

double find_doubt(const StandProblem& problem, const Effect& e) {
  if (!is_link(e)) return 0;
  double most = 0;
  for (const LinkSpec& link : problem.tree.links) most = std::max(most, link.inertia.mass);
  const double mass = problem.tree.links[static_cast<size_t>(e.place.index)].inertia.mass;
  return std::log(most / std::max(1e-6, mass)) + (get_row(e).find_doubt ? get_row(e).find_doubt(e) : 0);
}

double find_prior(const StandProblem& problem, const Effect& e, size_t parameter) {
  return get_row(e).find_prior ? get_row(e).find_prior(problem, e, parameter) : 0;
}

}  // namespace hrp::diagnosis::standing

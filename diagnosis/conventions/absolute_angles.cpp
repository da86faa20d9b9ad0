// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/absolute_angles.h"

#include <cmath>
#include <utility>

#include "common/base/diagnostics.h"
#include "common/base/join_words.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/estimate/odds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

// What friction and rotors leave if these angles are absolute.
double calc_left(const LoggedMotion& motion, const AbsoluteAngles& angles) {
  const SampledMotion& rows = motion.rows;
  Eigen::MatrixXd q = rows.q, v = rows.v, a = rows.a;
  for (const AbsoluteAngle& at : angles.joints) {
    q.col(at.joint) -= at.sense * rows.q.col(at.before);
    v.col(at.joint) -= at.sense * rows.v.col(at.before);
    a.col(at.joint) -= at.sense * rows.a.col(at.before);
  }
  Eigen::MatrixXd tau = calc_efforts(motion.plant, q, v, a);
  const Eigen::MatrixXd of_joints = tau;
  for (const AbsoluteAngle& at : angles.joints) {
    if (angles.of_efforts) tau.col(at.before) -= at.sense * of_joints.col(at.joint);
  }
  return rows.calc_left(rows.effort - tau);
}

// One joint, or all, with either kind of effort.
std::vector<AbsoluteAngles> list_sets(const TreeSpec& tree) {
  const std::vector<AbsoluteAngle> parallel = list_parallel_joints(tree);
  std::vector<AbsoluteAngles> out;
  for (const bool of_efforts : {false, true}) {
    for (const AbsoluteAngle& at : parallel) out.push_back({{at}, of_efforts});
    if (parallel.size() > 1) out.push_back({parallel, of_efforts});
  }
  return out;
}

// The set that leaves a detail of the mismatch; an empty one if there is none.
AbsoluteAngles find_set(const TreeSpec& tree, const LoggedMotion& motion) {
  if (motion.share < kTrace) return {};  // friction and rotors explain all
  const std::vector<AbsoluteAngles> sets = list_sets(tree);
  const std::optional<size_t> best =
      find_reading(motion, sets.size(), [&](size_t i) { return calc_left(motion, sets[i]); });
  return best ? sets[*best] : AbsoluteAngles{};
}

std::vector<double>& get(Quantity of, JointColumns* joint) { return joint->signal[static_cast<size_t>(of)]; }

void subtract(double factor, const std::vector<double>& other, std::vector<double>* x) {
  if (x->size() != other.size()) return x->clear();  // of one of the two it was not recorded
  for (size_t k = 0; k < x->size(); ++k) (*x)[k] -= factor * other[k];
}

// A motor on the base turns its link against the base, so it does work on the angles of the joints before, too: each
// joint's torque is the sum of the efforts from it to the tip.
void add_reactions(const AbsoluteAngles& angles, Recording* r) {
  for (auto at = angles.joints.rbegin(); at != angles.joints.rend(); ++at) {
    const std::vector<double>& own = get(Quantity::kEffort, &r->joints[static_cast<size_t>(at->joint)]);
    if (!own.empty()) subtract(-at->sense, own, &get(Quantity::kEffort, &r->joints[static_cast<size_t>(at->before)]));
  }
}

}  // namespace

std::vector<AbsoluteAngle> list_parallel_joints(const TreeSpec& tree) {
  std::vector<AbsoluteAngle> out;
  for (int j = 0; j < tree.num_joints(); ++j) {
    const LinkSpec& link = tree.links[static_cast<size_t>(j) + 1];
    if (link.parent <= 0) continue;  // on the base
    const JointSpec &own = link.joint, &before = tree.joint(link.parent - 1);
    if (own.kind != JointKind::kRevolute || before.kind != JointKind::kRevolute) continue;
    const Vector3d axis = own.X_PF.R * own.axis_F;
    // To the digits of a drawing.
    if (axis.cross(before.axis_F).norm() < kAgreement)
      out.push_back({j, link.parent - 1, axis.dot(before.axis_F) > 0.0 ? 1.0 : -1.0});
  }
  return out;
}

AbsoluteAngles find_absolute_angles(const TorqueData& data, const LoggedMotion& motion, int jobs) {
  const Experiment& e = *data.experiment;
  const AbsoluteAngles set = find_set(e.robot.tree, motion);
  const double cost = kWholeGain + kOneValue * static_cast<double>(set.joints.size());
  if (!set.any() ||
      compare(fit_list(convert_angles(e, set), jobs), fit_list(make_torque_design(TorqueData(data)), jobs)) < cost)
    return {};
  if (is_effort_driven(e)) return set;
  refuse_input(e.recordings.front().find_place(e.signal_name(set.joints.front().joint, Quantity::kPosition)),
               describe(e, set) + ". State 'drive: effort', or subtract the angles before the servos' law is compared");
}

Experiment convert_angles(Experiment e, const AbsoluteAngles& angles) {
  for (Recording& r : e.recordings) {
    const std::vector<JointColumns> logged = r.joints;
    for (const AbsoluteAngle& at : angles.joints) {
      JointColumns& own = r.joints[static_cast<size_t>(at.joint)];
      JointColumns before = logged[static_cast<size_t>(at.before)];
      for (const Quantity q : {Quantity::kPosition, Quantity::kVelocity})
        subtract(at.sense, get(q, &before), &get(q, &own));
      subtract(at.sense, before.command, &own.command);
      subtract(at.sense, before.command_rate, &own.command_rate);
    }
    if (angles.of_efforts) add_reactions(angles, &r);
  }
  for (const AbsoluteAngle& at : angles.joints) {
    for (const Quantity of : {Quantity::kPosition, Quantity::kVelocity}) {
      const auto q = static_cast<size_t>(of);
      Noise& own = e.joint_noise[static_cast<size_t>(at.joint)][q];
      own.sigma = std::hypot(own.sigma, e.joint_noise[static_cast<size_t>(at.before)][q].sigma);
    }
  }
  return e;
}

std::string describe(const Experiment& e, const AbsoluteAngles& angles) {
  std::vector<std::string> names, before;
  for (const AbsoluteAngle& at : angles.joints) {
    names.push_back(e.signal_name(at.joint, Quantity::kPosition));
    before.push_back(e.robot.tree.joint(at.before).name);
  }
  return join_words(names) + (names.size() > 1 ? ": are angles" : ": is an angle") + " against the base: the model's " +
         "angle plus that of " + join_words(before) +
         (angles.of_efforts ? ", and the efforts do work on these angles (motors on the base)" : "");
}

}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/servo_damping.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/data/servo_gains.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/evidence/torque/samples.h"
#include "diagnosis/measurement/torque/effort.h"

namespace hrp::diagnosis {
namespace {

// kd (r' - v) [N m] at the kept samples.
Eigen::VectorXd calc_damping(const TorqueData& data, const TorqueRecording& r, int j, double kd) {
  const Recording& in = data.experiment->recordings[r.index];
  JointLaws laws;
  laws.kd = kd;
  const std::vector<double> given =
      calc_servo(in, static_cast<size_t>(j), laws, std::vector<double>(in.size(), 0.0)).effort;
  return data.condition(r, resample(in.time, given, r.begin, r.step, r.v.rows()) - kd * r.v.col(j));
}

bool has_command_rates(const TorqueData& data, int j) {
  return std::any_of(data.experiment->recordings.begin(), data.experiment->recordings.end(), [&](const Recording& r) {
    const std::vector<double>& rate = r.joints[static_cast<size_t>(j)].command_rate;
    return std::any_of(rate.begin(), rate.end(), [](double v) { return v != 0.0; });
  });
}

Eigen::MatrixXd stack(const JointRows& rows, const FoundLaws& laws) {
  Eigen::MatrixXd X(static_cast<long>(rows.list().size()), 0);
  for (long c = 0; c < laws.columns[0].cols(); ++c)
    X = append(X, rows.stack([&](size_t r) -> Eigen::VectorXd { return laws.columns[r].col(c); }));
  return X;
}

}  // namespace

std::string find_other_damping(const TorqueDesign& design, const TorqueModel& model, size_t i) {
  const TorqueData& data = *design.data;
  const int j = design.joints[i].joint;
  const JointSpec& joint = data.experiment->robot.tree.joint(j);
  const double kd = get_servo_gains(data.experiment->scenario, joint.name).kd;
  if (data.source[static_cast<size_t>(j)] != EffortSource::kServoLaw || !(kd > 0.0) || !has_command_rates(data, j))
    return "";
  const JointRows rows(data, j);
  const Eigen::VectorXd y = rows.stack([&](size_t r) -> Eigen::VectorXd { return data.recordings[r].missing.col(j); });
  const Eigen::VectorXd damping = rows.stack([&](size_t r) { return calc_damping(data, data.recordings[r], j, kd); });
  const Eigen::MatrixXd laws = stack(rows, list_laws(design, model, i)), X = append(laws, damping);
  if (std::min(rows.train(), rows.held()) < kRowsPerColumn * X.cols()) return "";
  const double k = 1.0 - rows.solve(y, X)[X.cols() - 1], left = rows.judge(y, X);
  if (!(left < kHalf * rows.judge(y, laws)) || !(std::abs(k - 1.0) > kMinority) || k < 0.0) return "";
  return "With a damping gain kd of " + number(k * kd, 2) + " " + get_joint_unit(joint, "N m s/rad") +
         " in place of the stated " + number(kd, 3) + ", " +
         number(std::sqrt(left / static_cast<double>(rows.held())), 3) + " " + get_joint_unit(joint, "N m") +
         " remain: the stated gain may be wrong. No effect describes that, and what is listed may stand in for it.";
}

}  // namespace hrp::diagnosis

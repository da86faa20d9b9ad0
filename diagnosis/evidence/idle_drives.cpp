// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/idle_drives.h"

#include "diagnosis/data/drives.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/gear_ratios.h"
#include "diagnosis/measurement/passive_torque.h"
#include "diagnosis/measurement/torque/load.h"

namespace hrp::diagnosis {
namespace {

// Share of a joint's squared effort that its motion predicts across stretches; negative if worse than its mean.
double predict_effort(const TorqueData& data, int joint) {
  std::vector<Gram> parts;
  Spread spread;
  long width = 0;
  for (const TorqueRecording& r : data.recordings) {
    const Eigen::MatrixXd drive = make_drive_columns(data, r, joint);
    width = drive.cols() + 1;
    for (long part = 0; part < kStretches; ++part) {
      parts.emplace_back(width);
      for (long k = part * r.kept() / kStretches; k < (part + 1) * r.kept() / kStretches; ++k) {
        if (!r.use(k, joint)) continue;
        const long row = r.full_row(k);
        Eigen::VectorXd x(width);
        x << r.tau(row, joint), drive.row(row).transpose();
        const double effort = r.effort(row, joint);
        parts.back().add_row(x, effort);
        spread.add(effort);
      }
    }
  }
  const double square = spread.get() * spread.get();
  if (!(square > 0.0)) return 0.0;
  Columns all(static_cast<size_t>(width));
  for (long c = 0; c < width; ++c) all[static_cast<size_t>(c)] = c;
  return 1.0 - cross_validate(parts, sum(parts, width), all) / square;
}

// True if somebody carries and accelerates the links: the motion takes at least half of the squares that weight and
// inertia take one by one. In free motion the two cancel. A joint whose effort was not logged may be moved by anybody,
// and tells nothing of the others: a cart that a hand pushes does not hold its pole.
bool is_driven(const TorqueData& data) {
  const std::vector<double> squares = calc_passive_squares(data);
  double taken = 0.0, parts = 0.0;
  for (size_t j = 0; j < squares.size(); ++j) {
    if (data.source[j] == EffortSource::kNone) continue;
    for (const TorqueRecording& r : data.recordings) {
      taken += r.tau.col(static_cast<long>(j)).squaredNorm();
      parts += squares[j] * static_cast<double>(r.tau.rows());
    }
  }
  return taken > kHalf * parts;
}

// Links that nothing drives swing freely, unless their angles are in another unit: then weight and inertia do not
// cancel.
std::string explain_undriven(const TorqueData& data) {
  Experiment in_degrees = *data.experiment;
  for (int j = 0; j < in_degrees.num_joints(); ++j) {
    if (in_degrees.robot.tree.joint(j).kind == JointKind::kRevolute)
      in_degrees = convert_ratio(std::move(in_degrees), {j, kDegrees});
  }
  if (!is_driven(make_torque_data(in_degrees)))
    return "Nothing drives the joints of this robot. Its links swing freely only if the recorded angles are degrees: "
           "write them in rad.";
  return "Nothing drives the joints of this robot, but its links do not swing freely: another force moved them (a "
         "hand?), or a drive is missing in the experiment.";
}

}  // namespace

bool are_drives_idle(const TorqueData& data) {
  if (data.experiment->scenario.floating_base) return false;
  const TreeSpec& tree = data.experiment->robot.tree;
  bool any = false;
  for (size_t j = 0; j < data.source.size(); ++j) {
    if (data.source[j] != EffortSource::kRecorded) continue;
    if (has_drive(tree) && !tree.joint(static_cast<int>(j)).actuated) continue;  // an effort of 0 by its kind, no log
    if (predict_effort(data, static_cast<int>(j)) > kDetail) return false;
    any = true;
  }
  return any && is_driven(data);
}

void doubt_idle_drives(const TorqueData& data, Evidence* evidence) {
  if (!are_drives_idle(data)) return;
  for (Finding& f : evidence->findings) {
    if (f.where.contains("sensor") || f.grade != Grade::kSupported) continue;
    make_ambiguous(&f);
    f.statement += " No recorded effort follows the motion, so another force may have moved the robot.";
  }
  evidence->warnings.push_back(
      !has_drive(data.experiment->robot.tree)
          ? explain_undriven(data)
          : "No recorded effort follows the motion of its joint: the drives did not move this robot, somebody else did "
            "(by hand?), or the log holds no efforts. "
            "Friction, rotors and masses need a recording in which the drives move the robot.");
}

}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/foot_loads.h"

#include <algorithm>

#include "common/base/has.h"
#include "diagnosis/data/smooth.h"

namespace hrp::diagnosis {
namespace {

bool is_foot(const Experiment& e, const std::string& link) {
  return has(e.scenario.feet, link) || std::any_of(e.recordings.begin(), e.recordings.end(),
                                                   [&](const Recording& r) { return has(r.spec.feet_attached, link); });
}

}  // namespace

std::vector<const std::vector<double>*> find_wrench_columns(const Recording& recording, const std::string& sensor) {
  std::vector<const std::vector<double>*> out;
  for (const char* part : {"/force/", "/torque/"}) {
    for (char axis : {'x', 'y', 'z'}) {
      const auto at = recording.other.find("/wrench/" + sensor + part + axis);
      out.push_back(at == recording.other.end() ? nullptr : &at->second);
    }
  }
  return out;
}

std::vector<LoadedFoot> list_loaded_feet(const Experiment& e) {
  std::vector<LoadedFoot> feet;
  if (e.scenario.floating_base) return feet;
  for (const WrenchSpec& spec : e.scenario.sensors.wrenches) {
    const int frame = e.robot.tree.find_frame(spec.link);
    const bool measured = std::all_of(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) {
      const auto columns = find_wrench_columns(r, spec.name);
      return columns[0] && columns[1] && columns[2];
    });
    if (frame < 0 || !measured || !is_foot(e, spec.link)) continue;
    const auto axes = e.keys.wrench_frame.find(spec.name);
    feet.push_back({spec.name, frame, axes != e.keys.wrench_frame.end() && axes->second == "world"});
  }
  return feet;
}

Eigen::VectorXd calc_load_torques(const Model& model, const Data& data, const std::vector<LoadedFoot>& feet,
                                  const Eigen::VectorXd& wrench) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(model.nv());
  Eigen::MatrixXd J(6, model.nv());  // [angular; linear]
  for (size_t f = 0; f < feet.size(); ++f) {
    const auto reading = wrench.segment<6>(static_cast<long>(6 * f));
    const Matrix3d R = feet[f].world ? Matrix3d(Matrix3d::Identity()) : calc_frame_pose(model, data, feet[f].frame).R;
    Vector6d F_W;
    F_W << R * reading.tail<3>(), R * reading.head<3>();
    calc_frame_jacobian(model, data, feet[f].frame, J);
    out += J.transpose() * F_W;
  }
  return out;
}

std::vector<double> close_chain(const Experiment& e, const Recording& recording, int joint) {
  const int frame =
      recording.spec.feet_attached.empty() ? -1 : e.robot.tree.find_frame(recording.spec.feet_attached[0]);
  if (frame < 0 || e.robot.tree.joint(joint).kind != JointKind::kPrismatic) return {};
  Model model(e.robot.tree, e.scenario.gravity_W);
  Data data(model);
  State state = make_state(model);
  Eigen::MatrixXd J(6, model.nv());
  std::vector<std::vector<double>> known;
  for (const JointColumns& columns : recording.joints)
    known.push_back(columns.has(Quantity::kPosition) ? fill_gaps(columns.signal[0]) : std::vector<double>{});
  std::vector<double> position(recording.size());
  Vector3d p_WA = Vector3d::Zero();  // position of the held foot
  for (size_t k = 0; k < position.size(); ++k) {
    for (int j = 0; j < model.num_joints(); ++j)
      state.q(j) = known[static_cast<size_t>(j)].empty() ? 0.0 : known[static_cast<size_t>(j)][k];
    update_kinematics(model, state, &data);
    calc_frame_jacobian(model, data, frame, J);
    const Vector3d along = J.block<3, 1>(3, joint), p_WF = calc_frame_pose(model, data, frame).p;
    if (k == 0) p_WA = p_WF;
    position[k] = along.dot(p_WA - p_WF) / std::max(1e-9, along.squaredNorm());
  }
  return position;
}

}  // namespace hrp::diagnosis

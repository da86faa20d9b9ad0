// SPDX-License-Identifier: BSD-3-Clause
// hrp-diagnose-baseline EXPERIMENT.yaml: what anybody would do first, for comparison with the tool. Plain linear least
// squares of viscous and Coulomb friction and rotor inertia at every driven joint (Gautier and Khalil's inverse dynamic
// identification in its simplest form), judged by the tool's own score on the recordings it did not see. Prints JSON.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/diagnostics.h"
#include "common/base/version.h"
#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/search/fit.h"

namespace {

using namespace hrp;
using namespace hrp::diagnosis;

constexpr double kStill = 0.02;  // [rad/s] slower samples have no clear direction of friction

// Normal equations of one joint: columns velocity, sign of velocity, acceleration.
struct Normal {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d projection = Eigen::Vector3d::Zero();
};

// Least squares with no negative coefficient: the most negative one is dropped until none is left.
Eigen::Vector3d solve(const Normal& normal) {
  bool use[3] = {true, true, true};
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d gram = normal.gram;
    Eigen::Vector3d projection = normal.projection;
    for (int i = 0; i < 3; ++i) {
      if (use[i]) continue;
      gram.row(i).setZero(), gram.col(i).setZero();
      gram(i, i) = 1, projection(i) = 0;
    }
    gram.diagonal().array() += 1e-12 * (1 + gram.diagonal().array());
    const Eigen::Vector3d x = gram.ldlt().solve(projection);
    Eigen::Index worst = 0;
    if (x.minCoeff(&worst) >= 0) return x;
    use[worst] = false;
  }
  return Eigen::Vector3d::Zero();
}

// Effort that drove the joint: recorded, else what the servo law says.
double find_effort(const Problem& problem, int recording, int j, size_t k) {
  const Experiment& e = *problem.experiment;
  const SmoothRecording& smooth = problem.smooth[static_cast<size_t>(recording)];
  const auto i = static_cast<size_t>(j);
  if (!smooth.effort[i].empty()) return smooth.effort[i][k];
  const JointColumns& columns = e.recordings[static_cast<size_t>(recording)].joints[i];
  if (columns.command.empty()) return std::nan("");
  const JointLaws laws = make_plant(e, {}).laws[i];
  const double rate = columns.command_rate.empty() ? 0.0 : columns.command_rate[k];
  const double u = laws.kp * (columns.command[k] - smooth.joints[i].q[k]) + laws.kd * (rate - smooth.joints[i].qd[k]);
  return std::max(-laws.effort_limit, std::min(laws.effort_limit, u));
}

void add_recording(const Problem& problem, int r, std::vector<Normal>* normals) {
  const Experiment& e = *problem.experiment;
  const Plant plant = make_plant(e, {});
  const SmoothRecording& smooth = problem.smooth[static_cast<size_t>(r)];
  Data data(*plant.model);
  State state = make_state(*plant.model);
  Eigen::VectorXd acceleration(e.num_joints()), effort(e.num_joints());
  const size_t count = e.recordings[static_cast<size_t>(r)].size();
  for (size_t k = smooth.start; k < count; ++k) {
    for (int j = 0; j < e.num_joints(); ++j) {
      const SmoothJoint& joint = smooth.joints[static_cast<size_t>(j)];
      state.q(j) = joint.q[k], state.qd(j) = joint.qd[k], acceleration(j) = joint.qdd[k];
    }
    update_kinematics(*plant.model, state, &data);
    calc_inverse_dynamics(*plant.model, acceleration, nullptr, &data, &effort);
    for (int j = 0; j < e.num_joints(); ++j) {
      const double missing = find_effort(problem, r, j, k) - effort(j), v = state.qd(j);
      if (!std::isfinite(missing) || std::abs(v) < kStill) continue;
      const Eigen::Vector3d row(v, v > 0 ? 1.0 : -1.0, acceleration(j));
      (*normals)[static_cast<size_t>(j)].gram += row * row.transpose();
      (*normals)[static_cast<size_t>(j)].projection += row * missing;
    }
  }
}

nlohmann::ordered_json identify(const std::string& path) {
  const Experiment e = load_experiment(path);
  const Problem problem = make_problem(e, 2);
  if (e.num_joints() == 0) return {{"joints", nullptr}};  // nothing that could have friction
  std::vector<Normal> normals(static_cast<size_t>(e.num_joints()));
  for (int r : problem.train) add_recording(problem, r, &normals);
  Hypothesis hypothesis;
  nlohmann::ordered_json joints;
  for (int j = 0; j < e.num_joints(); ++j) {
    const Eigen::Vector3d x = solve(normals[static_cast<size_t>(j)]);
    hypothesis.push_back({EffectId::kViscous, j, {x(0)}});
    hypothesis.push_back({EffectId::kCoulomb, j, {x(1), 0.0}});
    hypothesis.back().p.resize(list_infos(EffectId::kCoulomb).size(), 0.002);  // [rad/s] stick speed
    hypothesis.push_back({EffectId::kRotorInertia, j, {x(2)}});
    joints[e.robot.tree.joint(j).name] = {{"viscous", x(0)}, {"coulomb", x(1)}, {"rotor_inertia", x(2)}};
  }
  nlohmann::ordered_json out{{"joints", joints}};
  for (const auto& [name, which] : {std::pair{"train", &problem.train}, std::pair{"validate", &problem.validate}}) {
    if (which->empty()) continue;
    const Score before = calc_score(problem, {}, *which), after = calc_score(problem, hypothesis, *which);
    if (before.ok && after.ok)
      out["fit"][name] = {{"before", before.rms()}, {"after", after.rms()}};  // else it diverges
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const char usage[] =
      "Usage: hrp-diagnose-baseline EXPERIMENT.yaml\n"
      "Least-squares identification of friction and rotor inertia, to compare hrp-diagnose with; prints JSON.";
  if (hrp::answer_questions(argc, argv, "hrp-diagnose-baseline", usage)) return 0;
  if (argc != 2) return std::fprintf(stderr, "%s\n", usage), 2;
  try {
    std::printf("%s\n", identify(argv[1]).dump(1).c_str());
    return 0;
  } catch (const hrp::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-diagnose-baseline: %s\n", error.what());
    return 1;
  }
}

// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held_feet/rows.h"

#include <algorithm>
#include <cmath>

#include "common/effects/effect_target.h"
#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/held_feet/data.h"

namespace hrp::diagnosis::held_feet {
namespace {

constexpr double kStill = 0.02;  // [rad/s or m/s] slower, the direction of friction is not known

// The hypothesis, sorted by where it acts.
struct Terms {
  std::vector<JointLaws> joints;
  std::vector<SensorErrors> efforts;  // readings, by joint
  std::vector<SensorErrors> sensors;
  std::vector<RowEffect> columns;     // effects that are coefficients of the table's columns of torque
  TreeSpec tree;

  Terms(const RowProblem& problem, const RowHypothesis& hypothesis)
      : joints(problem.nominal.laws),
        efforts(joints.size()),
        sensors(problem.sensors.size()),
        tree(problem.nominal.tree) {
    for (const RowEffect& e : hypothesis) {
      if (has_columns(e.id))
        columns.push_back(e);
      else
        get_effect(e.id).apply(make_values(e).data(), find_target(e.place));
    }
  }

  EffectTarget find_target(const Place& place) {
    EffectTarget target;
    const auto i = static_cast<size_t>(place.index);
    if (place.kind == PlaceKind::kJoint) target.joint = &joints[i];
    if (place.kind == PlaceKind::kLink) target.link = {&tree.links[i].inertia};
    if (place.kind == PlaceKind::kSensor) target.sensor = is_of_joint(place.reading) ? &efforts[i] : &sensors[i];
    return target;
  }

  // Torque [N m] of what is written in columns.
  double calc_columns(int joint, const JointSample& sample) const {
    double sum = 0.0;
    for (const RowEffect& e : columns) {
      if (e.place.index != joint) continue;
      std::vector<double> c(e.p.size());
      get_effect(e.id).torque.calc_columns(sample, nullptr, c.data());
      for (size_t i = 0; i < c.size(); ++i) sum += e.p[i] * c[i];
    }
    return sum;
  }
};

class Calculator {
 public:
  Calculator(const RowProblem& problem, const RowHypothesis& hypothesis, size_t recording)
      : problem_(problem),
        r_(problem.recordings[recording]),
        terms_(problem, hypothesis),
        model_(terms_.tree, problem.experiment->scenario.gravity_W),
        data_(model_),
        state_(make_state(model_)),
        wrenches_(terms_.tree.links.size(), Vector6d::Zero()),
        vdot_(model_.nv()),
        tau_(model_.nv()) {}

  std::vector<double> run() {
    std::vector<double> out;
    for (long k = 0; k < static_cast<long>(r_.time.size()); ++k) add_sample(k, &out);
    return out;
  }

 private:
  void read_wrenches(long k) {
    for (Vector6d& w : wrenches_) w.setZero();
    for (size_t s = 0; s < problem_.sensors.size(); ++s) {
      const RowSensor& sensor = problem_.sensors[s];
      const SensorErrors& t = terms_.sensors[s];
      const Vector6d read = (r_.wrench[s].row(k) + t.delay * r_.wrench_rate[s].row(k)).transpose();
      const Matrix3d R_turn = make_rotation_from_rpy(t.misalignment);
      const Vector3d force = R_turn * Vector3d((read.head<3>() - t.bias) / t.scale.x()),
                     torque = R_turn * Vector3d(read.tail<3>() / t.scale.x());
      const Matrix3d R = sensor.world ? Matrix3d::Identity() : get_pose(data_, sensor.link).R;
      const FrameSpec& frame = terms_.tree.frames[static_cast<size_t>(
          problem_.experiment->robot.tree.find_frame(problem_.experiment->scenario.sensors.wrenches[s].link))];
      Vector6d at_frame;
      at_frame << R * torque, R * force;
      const Vector3d p_WF = get_pose(data_, sensor.link) * frame.X_LF.p;
      wrenches_[static_cast<size_t>(sensor.link)] += calc_wrench_about_origin(data_, sensor.link, p_WF, at_frame);
    }
  }

  // What the drive gives after friction, less what the motion needs.
  double calc_row(long k, int j) const {
    const auto i = static_cast<size_t>(j);
    const JointLaws& laws = terms_.joints[i];
    const double q = r_.q(k, j), v = r_.qd(k, j), direction = calc_direction(v);
    const bool driven = terms_.tree.joint(j).actuated;
    const double given = driven ? calc_given_torque(laws, r_.effort(k, j) - terms_.efforts[i].bias.x(), v) : 0.0;
    const double dry = direction * calc_friction_level(laws, std::abs(v), given, direction);
    const JointSample sample{q, v, r_.qdd(k, j), direction, given, 0.0};
    return given - dry - calc_taken_torque(laws, q, v, sample.a) - terms_.calc_columns(j, sample) - tau_(j);
  }

  void add_sample(long k, std::vector<double>* out) {
    for (int j = 0; j < model_.num_joints(); ++j) {
      state_.q(j) = r_.q(k, j) - terms_.joints[static_cast<size_t>(j)].joint_offset;
      state_.qd(j) = r_.qd(k, j), vdot_(j) = r_.qdd(k, j);
    }
    update_kinematics(model_, state_, &data_);
    read_wrenches(k);
    calc_inverse_dynamics(model_, vdot_, &wrenches_, &data_, &tau_);
    for (int j = 0; j < model_.num_joints(); ++j) {
      const bool still = std::abs(r_.qd(k, j)) < kStill;
      const bool used = r_.rows[static_cast<size_t>(j)] && r_.clipped(k, j) == 0.0 &&
                        !r_.sudden[static_cast<size_t>(k)] && !(still && terms_.tree.joint(j).actuated);
      out->push_back(used ? calc_row(k, j) : std::nan(""));
    }
  }

  const RowProblem& problem_;
  const RowRecording& r_;
  Terms terms_;
  Model model_;
  Data data_;
  State state_;
  LinkWrenches wrenches_;
  Eigen::VectorXd vdot_, tau_;
};

}  // namespace

namespace {

// Laws of a joint that the equations know: linear in torque, of one instant, and not of the effort's rate, which is not
// kept; and the encoder's zero, which turns the levers of weight and foot force.
bool knows_joint_effect(const EffectInfo& effect) {
  const bool linear = effect.torque.num_columns > 0 && effect.torque.shapes.empty() && !effect.torque.shape_from_data;
  return (linear && effect.family != EffectFamily::kTiming) || effect.family == EffectFamily::kZero;
}

bool is_driven(const RowProblem& problem, int joint) {
  return problem.experiment->robot.tree.joint(joint).actuated && problem.sigma[static_cast<size_t>(joint)] > 0.0;
}

}  // namespace

std::vector<RowEffect> list_row_effects(const RowProblem& problem) {
  std::vector<RowEffect> out;
  const auto add = [&](const EffectInfo& effect, int place, Reading reading) {
    out.push_back(make_absent(effect.id, {effect.place, place, reading}));
  };
  for (const EffectInfo& effect : list_effects()) {
    if (!effect.reported) continue;
    if (effect.place == PlaceKind::kJoint && knows_joint_effect(effect)) {
      for (int j = 0; j < problem.experiment->num_joints(); ++j) {
        if (is_driven(problem, j)) add(effect, j, Reading::kAll);
      }
    }
    if (effect.place == PlaceKind::kLink && effect.of_whole_link && effect.family == EffectFamily::kMass) {
      for (int link = 1; link <= problem.experiment->num_joints(); ++link) add(effect, link, Reading::kAll);
    }
    if (effect.id == EffectId::kSensorBias) {
      for (int j = 0; j < problem.experiment->num_joints(); ++j) {
        if (is_driven(problem, j)) add(effect, j, Reading::kEffort);
      }
    }
    if (effect.place == PlaceKind::kSensor && effect.id != EffectId::kClockSkew) {
      const Reading reading = effect.id == EffectId::kSensorBias ? Reading::kForce : Reading::kAll;
      for (size_t s = 0; s < problem.sensors.size(); ++s) add(effect, static_cast<int>(s), reading);
    }
  }
  return out;
}

std::vector<double> calc_rows(const RowProblem& problem, const RowHypothesis& hypothesis, size_t recording) {
  return Calculator(problem, hypothesis, recording).run();
}

bool make_row_problem(const Experiment& e, RowProblem* problem, std::string* why) {
  problem->experiment = &e;
  problem->nominal = make_nominal(e);
  if (e.scenario.floating_base) return *why = "the base floats", false;
  for (const WrenchSpec& spec : e.scenario.sensors.wrenches) {
    const int frame = e.robot.tree.find_frame(spec.link);
    if (frame < 0) return *why = "the link of " + spec.name + " is not of the robot", false;
    RowSensor sensor;
    sensor.name = spec.name, sensor.link = e.robot.tree.frames[static_cast<size_t>(frame)].link;
    const auto axes = e.keys.wrench_frame.find(spec.name);
    sensor.world = axes != e.keys.wrench_frame.end() && axes->second == "world";
    problem->sensors.push_back(sensor);
  }
  if (problem->sensors.empty()) return *why = "no force sensor at the feet", false;
  for (const Recording& recording : e.recordings) {
    RowRecording out;
    if (!read_row_recording(*problem, recording, &out, why)) return false;
    problem->recordings.push_back(std::move(out));
  }
  find_row_noise(problem);
  return true;
}

}  // namespace hrp::diagnosis::held_feet

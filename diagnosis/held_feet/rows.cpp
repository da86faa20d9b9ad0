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

struct SensorTerms {
  Vector3d bias{0, 0, 0}, rpy{0, 0, 0};
  double scale = 1, delay = 0;
};

Vector3d get3(const std::vector<double>& p) { return {p[0], p[1], p[2]}; }

// The hypothesis, sorted by where it acts.
struct Terms {
  std::vector<JointLaws> joints;
  std::vector<double> stiffness, moment, bias;  // by joint
  std::vector<SensorTerms> sensors;
  TreeSpec tree;

  Terms(const RowProblem& problem, const RowHypothesis& hypothesis)
      : joints(problem.nominal.laws),
        stiffness(joints.size(), 0.0),
        moment(joints.size(), 0.0),
        bias(joints.size(), 0.0),
        sensors(problem.sensors.size()),
        tree(problem.nominal.tree) {
    for (const RowEffect& e : hypothesis) {
      if (e.id <= RowEffectId::kEffortBias)
        add_joint(e);
      else if (e.id <= RowEffectId::kComError)
        add_link(e, &tree.links[static_cast<size_t>(e.place)].inertia);
      else
        add_sensor(e, &sensors[static_cast<size_t>(e.place)]);
    }
  }

  // Springs are written in stiffness and moment, in which rows are linear; all others as the table has them.
  void add_joint(const RowEffect& e) {
    const auto j = static_cast<size_t>(e.place);
    if (e.id == RowEffectId::kSpring) {
      stiffness[j] += e.p[0], moment[j] += e.p[1];
    } else if (e.id == RowEffectId::kEffortBias) {
      bias[j] = e.p[0];
    } else {
      std::vector<double> values = e.p;
      const EffectInfo& effect = *find_effect(get_row_info(e.id).effect);
      for (size_t i = values.size(); i < effect.parameters.size(); ++i) values.push_back(effect.parameters[i].value);
      EffectTarget target;
      target.joint = &joints[j];
      effect.apply(values.data(), target);
    }
  }

  static void add_link(const RowEffect& e, LinkInertia* link) {
    const double scale = std::max(0.01, e.p[0]);  // a search may ask for less than nothing
    if (e.id == RowEffectId::kMassError)
      link->mass *= scale, link->I_LLcm_L *= scale;
    else
      link->p_LLcm_L += get3(e.p);
  }

  static void add_sensor(const RowEffect& e, SensorTerms* s) {
    switch (e.id) {
      case RowEffectId::kForceBias:
        s->bias = get3(e.p);
        break;
      case RowEffectId::kForceScale:
        s->scale = e.p[0];
        break;
      case RowEffectId::kForceDelay:
        s->delay = e.p[0];
        break;
      default:
        s->rpy = get3(e.p);
    }
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
      const SensorTerms& t = terms_.sensors[s];
      const Vector6d read = (r_.wrench[s].row(k) + t.delay * r_.wrench_rate[s].row(k)).transpose();
      const Matrix3d R_turn = make_rotation_from_rpy(t.rpy);
      const Vector3d force = R_turn * Vector3d((read.head<3>() - t.bias) / t.scale),
                     torque = R_turn * Vector3d(read.tail<3>() / t.scale);
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
    const double given = driven ? calc_given_torque(laws, r_.effort(k, j) - terms_.bias[i], v) : 0.0;
    const double dry = direction * calc_friction_level(laws, std::abs(v), given, direction);
    const double taken = calc_taken_torque(laws, q, v, r_.qdd(k, j)) + terms_.stiffness[i] * q + terms_.moment[i];
    return given - dry - taken - tau_(j);
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

const RowInfo& get_row_info(RowEffectId id) {
  static const std::vector<RowInfo> table{
      {"viscous_friction",
       "joint",
       "",
       {{"coefficient", "N m s/rad", 0, 1e-3, true}},
       "the effort left over is in proportion to speed"},
      {"coulomb_friction",
       "joint",
       "",
       {{"level", "N m", 0, 1e-3, true}},
       "the effort left over jumps with the direction of motion"},
      {"load_dependent_friction",
       "joint",
       "",
       {{"ratio", "1", 0, 1e-2, true}},
       "the effort left over jumps with the direction of motion, the more the joint carries"},
      {"rotor_inertia",
       "joint",
       "",
       {{"inertia", "kg m^2", 0, 1e-5, true}},
       "the effort left over follows the acceleration"},
      {"torque_constant_error",
       "joint",
       "",
       {{"scale", "1", 1, 1e-2, false}},
       "the true torque is a fixed multiple of the logged effort"},
      {"joint_offset",
       "joint",
       "",
       {{"offset", "rad", 0, 1e-3, false}},
       "the encoder's zero is off: foot force and weight act at other levers"},
      {"parallel_spring",
       "joint",
       "",
       {{"stiffness", "N m/rad", 0, 1e-2, true}, {"moment", "N m", 0, 1e-2, false}},
       "a spring acts across the joint"},
      {"sensor_bias",
       "sensor",
       "effort",
       {{"value", "N m", 0, 1e-2, false}},
       "the logged effort is shifted by a constant"},
      {"mass_error", "link", "", {{"scale", "1", 1, 1e-2, false}}, "the link's mass is wrong by a factor"},
      {"com_error",
       "link",
       "",
       {{"offset_x", "m", 0, 1e-3, false}, {"offset_y", "m", 0, 1e-3, false}, {"offset_z", "m", 0, 1e-3, false}},
       "the link's centre of mass is elsewhere"},
      {"sensor_bias",
       "sensor",
       "force",
       {{"value_x", "N", 0, 1e-1, false}, {"value_y", "N", 0, 1e-1, false}, {"value_z", "N", 0, 1e-1, false}},
       "the force reading is shifted by a constant"},
      {"sensor_scale", "sensor", "", {{"scale", "1", 1, 1e-2, false}}, "the force reading is scaled"},
      {"sensor_delay", "sensor", "", {{"delay", "s", 0, 1e-3, false}}, "the force sensor's readings come late"},
      {"sensor_misalignment",
       "sensor",
       "",
       {{"rpy_x", "rad", 0, 1e-2, false}, {"rpy_y", "rad", 0, 1e-2, false}, {"rpy_z", "rad", 0, 1e-2, false}},
       "the force sensor is turned"}};
  return table[static_cast<size_t>(id)];
}

RowEffect make_neutral(RowEffectId id, int place) {
  RowEffect effect{id, place, {}};
  for (const RowParameter& p : get_row_info(id).parameters) effect.p.push_back(p.neutral);
  return effect;
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

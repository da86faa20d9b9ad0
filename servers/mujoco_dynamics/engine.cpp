// SPDX-License-Identifier: BSD-3-Clause
#include "servers/mujoco_dynamics/engine.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "servers/mujoco_dynamics/ground_law.h"
#include "servers/mujoco_dynamics/mjcf.h"

namespace hrp {
namespace {

using ConstVector = Eigen::Map<const Vector3d>;
using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

mjModel* load_model(const std::string& xml, const Scenario& scenario) {
  mjVFS vfs;
  mj_defaultVFS(&vfs);
  mj_makeEmptyFileVFS(&vfs, "model.xml", static_cast<int>(xml.size()));
  std::copy(xml.begin(), xml.end(), static_cast<char*>(vfs.filedata[vfs.nfile - 1]));
  char text[1000] = "";
  mjModel* model = mj_loadXML("model.xml", &vfs, text, sizeof text);
  mj_deleteVFS(&vfs);
  if (model == nullptr) {
    throw InputError(scenario.make_diagnostic("robot", std::string("MuJoCo refuses the robot: ") + text));
  }
  return model;
}

// Gives the soles the scenario's contact where that is a spring and a damper. What is stood on has no say in it.
void set_ground_law(const Scenario& scenario, mjModel* model) {
  if (scenario.contact.model != "spring_damper" || scenario.feet.empty()) return;
  const double weight = mj_getTotalmass(model) * scenario.gravity_W.norm();
  const double load = weight / static_cast<double>(scenario.feet.size()) / scenario.contact.shared_points;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (model->geom_contype[geom] != 1) {
      model->geom_solmix[geom] = 0;
      continue;
    }
    const double mass = 1.0 / model->body_invweight0[2 * model->geom_bodyid[geom]];
    const GroundLaw law = calc_ground_law(scenario.contact, load, mass, scenario.time_step);
    mjtNum* reference = model->geom_solref + mjNREF * geom;
    mjtNum* impedance = model->geom_solimp + mjNIMP * geom;
    reference[0] = -law.k * law.impedance;  // MuJoCo divides both by the impedance
    reference[1] = -law.b * law.impedance;
    impedance[0] = impedance[1] = law.impedance;
  }
}

// MuJoCo writes warnings into a file of the working folder unless told otherwise; what matters is asked of mjData.
void ignore_warning(const char*) {}

}  // namespace

MujocoDynamicsEngine::MujocoDynamicsEngine(const RobotDescription& robot, const Scenario& scenario)
    : robot_(robot),
      scenario_(scenario),
      reference_(parse_interpolation(scenario.interpolation), scenario.control_period, scenario.time_step,
                 std::vector<double>(static_cast<size_t>(robot.tree.num_joints()), 0.0)) {
  mju_user_warning = ignore_warning;
  model_ = load_model(make_mjcf(robot, scenario), scenario);
  set_ground_law(scenario, model_);
  data_ = mj_makeData(model_);
  for (int i = 0; i < robot.tree.num_joints(); ++i) {
    const int id = mj_name2id(model_, mjOBJ_JOINT, ("j" + std::to_string(i)).c_str());
    positions_.push_back(model_->jnt_qposadr[id]);
    dofs_.push_back(model_->jnt_dofadr[id]);
  }
  for (const std::string& foot : scenario.feet) {
    const int frame = robot.tree.find_frame(foot);
    if (frame < 0) throw InputError(scenario.make_diagnostic("feet", "no link '" + foot + "'"));
    foot_links_.push_back(robot.tree.frames[static_cast<size_t>(frame)].link);
  }
  const auto n = static_cast<Eigen::Index>(positions_.size());
  state_.q = state_.qd = efforts_ = Eigen::VectorXd::Zero(n);
  reset();
  pushes_ = std::make_unique<Pushes>(robot, scenario, state_);
}

MujocoDynamicsEngine::~MujocoDynamicsEngine() {
  mj_deleteData(data_);
  mj_deleteModel(model_);
}

void MujocoDynamicsEngine::reset() {
  mj_resetData(model_, data_);
  set_initial_state();
  read_state();
  step_ = 0;
  if (pushes_) pushes_->let_go();
  reference_.reset(state_.q);
  set_controls();
  mj_forward(model_, data_);
  efforts_.setZero();
  forces_.clear();
  foot_forces_.assign(foot_links_.size(), 0.0);
  read_sensors();
}

void MujocoDynamicsEngine::set_initial_state() {
  for (const auto& [name, position] : scenario_.initial_joints) {
    const int joint = robot_.tree.find_joint(name);
    if (joint < 0) throw InputError(scenario_.make_diagnostic("initial.joints." + name, "no joint '" + name + "'"));
    data_->qpos[positions_[static_cast<size_t>(joint)]] = position;
  }
  for (int i = 0; i < robot_.tree.num_joints(); ++i) {
    const MimicSpec& mimic = robot_.tree.joint(i).mimic;
    if (mimic.joint < 0) continue;
    data_->qpos[positions_[static_cast<size_t>(i)]] =
        mimic.multiplier * data_->qpos[positions_[static_cast<size_t>(mimic.joint)]] + mimic.offset;
  }
  const Eigen::Quaterniond R_WB(make_rotation_from_rpy(scenario_.initial_rpy));
  if (!robot_.tree.floating_base) {  // the model has its base there
    state_.p_WB = scenario_.initial_position;
    state_.R_WB = R_WB;
    return;
  }
  const Vector3d& p = scenario_.initial_position;
  const double pose[7] = {p.x(), p.y(), p.z(), R_WB.w(), R_WB.x(), R_WB.y(), R_WB.z()};
  std::copy(pose, pose + 7, data_->qpos);
  if (scenario_.initial_height_given || !scenario_.ground.present) return;
  data_->qpos[2] = 0;
  mj_kinematics(model_, data_);
  data_->qpos[2] = -find_lowest_sole();
}

// Height of the lowest sole point above the ground under it, over the box that MuJoCo keeps around every shape [m].
double MujocoDynamicsEngine::find_lowest_sole() const {
  const GroundSpec& ground = scenario_.ground;
  const Vector3d normal = make_rotation_from_rpy({ground.roll, ground.pitch, 0}) * Vector3d::UnitZ();
  double lowest = std::numeric_limits<double>::infinity();
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    if (model_->geom_bodyid[geom] == 0 || model_->geom_contype[geom] != 1) continue;
    const Eigen::Map<const RowMatrix> R(data_->geom_xmat + 9 * geom);
    const ConstVector p(data_->geom_xpos + 3 * geom), size(model_->geom_size + 3 * geom);
    const Vector3d n = R.transpose() * normal;
    double reach = 0;  // from the centre towards the ground
    switch (model_->geom_type[geom]) {
      case mjGEOM_SPHERE: reach = size.x(); break;
      case mjGEOM_CYLINDER: reach = size.x() * std::hypot(n.x(), n.y()) + size.y() * std::abs(n.z()); break;
      default: reach = size.dot(n.cwiseAbs());
    }
    lowest = std::min(lowest, ((p - Vector3d(0, 0, ground.height)).dot(normal) - reach) / normal.z());
  }
  return std::isfinite(lowest) ? lowest : 0.0;
}

// References of the end of the step, which the servo is to reach.
void MujocoDynamicsEngine::set_controls() {
  for (size_t i = 0; i < positions_.size(); ++i) {
    const mjtNum* bias = model_->actuator_biasprm + mjNBIAS * i;  // 0, -kp, -kd
    const ReferenceSample sample = reference_.get(static_cast<int>(i), 1.0);
    data_->ctrl[i] = -bias[1] * sample.q - bias[2] * sample.qd + sample.effort;
  }
}

// Of the step that begins. MuJoCo takes the force on a body's centre of mass C, the moment about C, world axes.
void MujocoDynamicsEngine::set_pushes() {
  std::fill_n(data_->xfrc_applied, 6 * model_->nbody, 0.0);
  for (const ExternalWrench& push : pushes_->find(static_cast<double>(step_) * scenario_.time_step, state_)) {
    const int body = mj_name2id(model_, mjOBJ_BODY, ("b" + std::to_string(push.link)).c_str());
    const Vector3d p_LC_W = ConstVector(data_->xipos + 3 * body) - ConstVector(data_->xpos + 3 * body),
                   force_W = push.F_W.tail<3>();
    Eigen::Map<Vector6d> applied(data_->xfrc_applied + 6 * body);
    applied.head<3>() += force_W;
    applied.tail<3>() += push.F_W.head<3>() - p_LC_W.cross(force_W);
  }
}

std::string MujocoDynamicsEngine::step(const ContactSet&, const JointCommand& command) {
  if (command.q.size() != static_cast<Eigen::Index>(positions_.size())) return "wrong number of joint commands";
  set_pushes();
  reference_.start_step(step_++, command);
  set_controls();
  mj_step(model_, data_);
  for (const int kind : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
    if (data_->warning[kind].number == 0) continue;
    char text[200];
    std::snprintf(text, sizeof text, "MuJoCo's state is not finite or too large (coordinate %d)",
                  data_->warning[kind].lastinfo);
    return text;
  }
  reference_.finish_step();
  // The constraint forces of the step are still in place; the next mj_forward would replace them.
  read_contacts();
  for (size_t i = 0; i < dofs_.size(); ++i) {
    efforts_[static_cast<Eigen::Index>(i)] = data_->qfrc_actuator[dofs_[i]] + data_->qfrc_passive[dofs_[i]];
  }
  mj_forward(model_, data_);
  read_state();
  read_sensors();
  return "";
}

void MujocoDynamicsEngine::read_state() {
  for (size_t i = 0; i < positions_.size(); ++i) {
    state_.q[static_cast<Eigen::Index>(i)] = data_->qpos[positions_[i]];
    state_.qd[static_cast<Eigen::Index>(i)] = data_->qvel[dofs_[i]];
  }
  if (!robot_.tree.floating_base) return;
  const mjtNum* pose = data_->qpos;
  state_.p_WB = ConstVector(pose);
  state_.R_WB = Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).normalized();
  // MuJoCo's free joint: linear velocity in world axes, then angular velocity in body axes.
  state_.V_WB << state_.R_WB * ConstVector(data_->qvel + 3), ConstVector(data_->qvel);
}

Vector3d MujocoDynamicsEngine::read_sensor(const std::string& name) const {
  const int id = mj_name2id(model_, mjOBJ_SENSOR, name.c_str());
  return ConstVector(data_->sensordata + model_->sensor_adr[id]);
}

void MujocoDynamicsEngine::read_sensors() {
  sensors_.q = state_.q;
  sensors_.qd = state_.qd;
  sensors_.effort = Eigen::Map<const Eigen::VectorXd>(data_->actuator_force, static_cast<Eigen::Index>(dofs_.size()));
  sensors_.imus.resize(scenario_.sensors.imus.size());
  for (size_t i = 0; i < sensors_.imus.size(); ++i) {
    const std::string name = "imu" + std::to_string(i);
    const int site = mj_name2id(model_, mjOBJ_SITE, name.c_str());
    sensors_.imus[i].R_WS = Eigen::Quaterniond(Matrix3d(Eigen::Map<const RowMatrix>(data_->site_xmat + 9 * site)));
    sensors_.imus[i].angular_velocity = read_sensor(name + "_gyro");
    sensors_.imus[i].linear_acceleration = read_sensor(name + "_accelerometer");
  }
  // MuJoCo's force sensor reads what the parent exerts on its child (seen on a standing robot); ours is the reaction.
  sensors_.wrenches.resize(scenario_.sensors.wrenches.size());
  for (size_t i = 0; i < sensors_.wrenches.size(); ++i) {
    sensors_.wrenches[i].force = -read_sensor("wrench" + std::to_string(i) + "_force");
    sensors_.wrenches[i].torque = -read_sensor("wrench" + std::to_string(i) + "_torque");
  }
  sensors_.has_base_pose = scenario_.sensors.base_pose;
  sensors_.X_WB = state_.X_WB();
  sensors_.V_WB = state_.V_WB;
}

PairForce& MujocoDynamicsEngine::find_pair(int body_a, int body_b) {
  for (PairForce& pair : forces_) {
    if (pair.body_a == body_a && pair.body_b == body_b) return pair;
  }
  forces_.emplace_back();
  forces_.back().body_a = body_a;
  forces_.back().body_b = body_b;
  return forces_.back();
}

void MujocoDynamicsEngine::read_contacts() {
  forces_.clear();
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    if (contact.efc_address < 0) continue;
    const bool robot_first = model_->geom_bodyid[contact.geom1] != 0;
    const int geom_a = robot_first ? contact.geom1 : contact.geom2;
    const int geom_b = robot_first ? contact.geom2 : contact.geom1;
    const int body = model_->geom_bodyid[geom_a];
    const int link = std::stoi(mj_id2name(model_, mjOBJ_BODY, body) + 1);  // "b12"
    const std::string other = mj_id2name(model_, mjOBJ_GEOM, geom_b);
    const int other_index = other == "ground" ? kGround : make_obstacle_index(std::stoi(other.substr(8)));
    PairForce& pair = find_pair(link, other_index);
    if (pair.points.empty()) pair.p_WR = ConstVector(data_->xpos + 3 * body);

    mjtNum force[6], velocity[6];
    mj_contactForce(model_, data_, i, force);  // in the contact's frame, on geom2
    mj_objectVelocity(model_, data_, mjOBJ_XBODY, body, velocity, 0);
    const double sign = robot_first ? -1.0 : 1.0;
    const Eigen::Map<const RowMatrix> axes(contact.frame);  // rows: normal from geom1 to geom2, two tangents
    PointForce point;
    point.p_WC = ConstVector(contact.pos);
    point.n_BA_W = sign * axes.row(0).transpose();
    point.depth = -contact.dist;
    point.spring = sign * force[0] * axes.row(0).transpose();
    point.friction = sign * (force[1] * axes.row(1) + force[2] * axes.row(2)).transpose();
    point.total = point.spring + point.damper + point.friction;
    const Vector3d v = ConstVector(velocity + 3) + ConstVector(velocity).cross(point.p_WC - pair.p_WR);
    point.slip = v - point.n_BA_W * point.n_BA_W.dot(v);
    // A sliding point is on the cone to the accuracy of MuJoCo's solver.
    point.clipped = point.friction.norm() >= 0.999 * contact.friction[0] * std::abs(force[0]) && force[0] > 0;
    const Vector3d arm = point.p_WC - pair.p_WR;
    pair.spring.head<3>() += arm.cross(point.spring);
    pair.spring.tail<3>() += point.spring;
    pair.friction.head<3>() += arm.cross(point.friction);
    pair.friction.tail<3>() += point.friction;
    pair.clipped = pair.clipped || point.clipped;
    pair.points.push_back(point);
  }
  std::sort(forces_.begin(), forces_.end(), [](const PairForce& l, const PairForce& r) {
    return l.body_a != r.body_a ? l.body_a < r.body_a : l.body_b < r.body_b;
  });
  foot_forces_.assign(foot_links_.size(), 0.0);
  for (PairForce& pair : forces_) {
    pair.total = pair.spring + pair.damper + pair.friction;
    for (size_t i = 0; i < foot_links_.size(); ++i) {
      if (pair.body_a == foot_links_[i]) foot_forces_[i] += pair.total[5];
    }
  }
}

std::unique_ptr<DynamicsEngine> make_mujoco_engine(const RobotDescription& robot, const Scenario& scenario) {
  return std::make_unique<MujocoDynamicsEngine>(robot, scenario);
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/diagnosis/legged/biped.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "common/spatial/turn.h"
#include "diagnosis/floating/diagnose.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kFootMass = 0.5;  // [kg] below each force sensor

std::string make_joint(const std::string& name, const std::string& parent, const std::string& child,
                       const std::string& xyz) {
  return "<joint name=\"" + name + "\" type=\"revolute\"><parent link=\"" + parent + "\"/><child link=\"" + child +
         "\"/><origin xyz=\"" + xyz +
         "\"/><axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"500\" velocity=\"20\"/></joint>";
}

class Maker {
 public:
  Maker(const Hidden& hidden, const Recorded& recorded) : hidden_(hidden), recorded_(recorded) {
    e_.scenario = parse_scenario(kBipedScenario, "biped.yaml");
    e_.robot = parse_robot(make_biped_urdf(), "biped.urdf", e_.scenario);
    e_.path = "biped.yaml";
    e_.sample_time = kStep;
    level_ = e_.scenario.gravity_W;
    e_.scenario.gravity_W = turn_y(hidden.slope) * level_;  // seen from the ground
    tree_ = e_.robot.tree;
    for (const char* foot : {"l_foot", "r_foot"}) {  // below the sensors
      if (recorded.whole_feet) continue;
      tree_.links[static_cast<size_t>(tree_.find_link(foot))].inertia = {1e-9, Vector3d::Zero(),
                                                                         1e-12 * Matrix3d::Identity()};
    }
    tree_.links[static_cast<size_t>(tree_.find_link("l_thigh"))].inertia.p_LLcm_L.z() -= hidden.lower;
    LinkInertia& carrier = tree_.links[static_cast<size_t>(tree_.find_link(hidden.carrier))].inertia;
    const Vector3d c = (carrier.mass * carrier.p_LLcm_L + hidden.load * hidden.place) / (carrier.mass + hidden.load);
    const auto about = [&](double m, const Vector3d& p) {
      const Vector3d d = p - c;
      return Matrix3d(m * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose()));
    };
    carrier.I_LLcm_L += about(carrier.mass, carrier.p_LLcm_L) + about(hidden.load, hidden.place);
    carrier.mass += hidden.load;
    carrier.p_LLcm_L = c;
    for (LinkSpec& link : tree_.links) {
      link.inertia.mass *= hidden.heavier;
      link.inertia.I_LLcm_L *= hidden.heavier;
    }
  }

  Experiment run() {
    for (int r = 0; r < 3; ++r) add_recording(r);
    e_.scenario.gravity_W = level_;
    return e_;
  }

 private:
  static constexpr double kStep = 0.004, kDuration = 8;

  // Angles of the joints, attitude and place of the base: a few sinusoids each.
  // Ankles keep the feet level.
  double angle(int j, double t) const {
    if (recorded_.leans) return lean(j % 3, t);
    if (j % 3 == 2) return -angle(j - 2, t) - angle(j - 1, t);
    return 0.25 * std::sin((2.1 + 0.7 * j + 0.3 * turn_) * t + j) + 0.1 * std::sin(5.3 * t + 2 * j);
  }
  // Hip, knee, ankle of both legs: a body that leans and squats over feet that stand.
  double lean(int part, double t) const {
    const double at[] = {-0.3, 0.6, -0.3}, size[] = {0.15, 0.12, 0.06}, rate[] = {1.7 + 0.2 * turn_, 1.1, 2.3};
    return at[part] + size[part] * std::sin(rate[part] * t + part) + (part == 0 ? recorded_.creep * t : 0);
  }
  static Matrix3d turn_y(double angle) { return Eigen::AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix(); }
  Matrix3d attitude(double t) const {
    if (recorded_.leans) return turn_y(-lean(0, t) - lean(1, t) - lean(2, t));
    return make_rotation_from_rpy(
        {0.05 * std::sin(2.3 * t + turn_), 0.08 * std::sin(1.7 * t), 0.05 * std::sin(1.1 * t)});
  }
  Vector3d place(double t) const {
    const Vector3d leg(0, 0, -0.3);
    if (recorded_.leans) return -(attitude(t) * (turn_y(lean(0, t)) * (leg + turn_y(lean(1, t)) * leg)));
    return {0.05 * std::sin(1.9 * t + turn_), 0.06 * std::sin(2.6 * t), 0.8 + 0.02 * std::sin(3.1 * t)};
  }

  void add_recording(int r) {
    turn_ = r;
    Recording out;
    out.spec.name = "walk_" + std::to_string(r) + ".csv";
    out.spec.train = r < 2;
    out.joints.resize(6);
    const Model model(tree_, e_.scenario.gravity_W);
    Data data(model);
    State state = make_state(model);
    Eigen::VectorXd vdot(model.nv()), tau(model.nv());
    constexpr double h = 1e-4;
    for (double t = 0; t < kDuration; t += kStep) {
      const Matrix3d R = attitude(t);
      const auto rate_at = [&](double s) -> Vector3d {  // world axes
        const Eigen::AngleAxisd turn(Matrix3d(attitude(s + h) * attitude(s - h).transpose()));
        return turn.axis() * turn.angle() / (2 * h);
      };
      const Vector3d w = rate_at(t), alpha = (rate_at(t + 1e-3) - rate_at(t - 1e-3)) / 2e-3;
      const Vector3d a = (place(t + 1e-3) - 2 * place(t) + place(t - 1e-3)) / 1e-6;
      state.R_WB = Eigen::Quaterniond(R);
      state.p_WB.setZero();
      state.V_WB.setZero();
      state.V_WB.head<3>() = w;
      vdot.head<3>() = alpha, vdot.segment<3>(3) = a;
      for (int j = 0; j < 6; ++j) {
        state.q(j) = angle(j, t);
        state.qd(j) = (angle(j, t + h) - angle(j, t - h)) / (2 * h);
        vdot(6 + j) = (angle(j, t + 1e-3) - 2 * angle(j, t) + angle(j, t - 1e-3)) / 1e-6;
      }
      update_kinematics(model, state, &data);
      calc_inverse_dynamics(model, vdot, nullptr, &data, &tau);
      tau(4) -= hidden_.push * std::sin(1.3 * t);
      const Vector3d pull(-hidden_.tether * (place(t).x() - place(0).x()), 0, 0);
      tau.head<3>() -= (R * tree_.links[0].inertia.p_LLcm_L).cross(pull), tau.segment<3>(3) -= pull;
      if (hidden_.bend == 0) {
        add_sample(t, a, model, state, vdot, &data, tau, &out);
      } else {
        add_bent_sample(t, a, state, vdot, tau, &data, &out);
      }
    }
    e_.recordings.push_back(std::move(out));
  }

  // The leg hangs askew by the moment that the ground's force makes about x at the hip.
  void add_bent_sample(double t, const Vector3d& a, const State& state, const Eigen::VectorXd& vdot,
                       const Eigen::VectorXd& needed, Data* data, Recording* out) {
    const auto thigh = static_cast<size_t>(tree_.find_link("l_thigh"));
    const Transform hip = get_pose(*data, static_cast<int>(thigh));
    const Vector3d about = find_share(t) * (needed.head<3>() - hip.p.cross(needed.segment<3>(3)));
    const double moment =
        get_joint_wrench(*data, static_cast<int>(thigh)).x() - state.R_WB.toRotationMatrix().col(0).dot(about);
    TreeSpec bent = tree_;
    Matrix3d& R = bent.links[thigh].joint.X_PF.R;
    R = R * make_turn(Vector3d(-hidden_.bend * moment, 0, 0)).toRotationMatrix();
    const Model model(bent, e_.scenario.gravity_W);
    Data moved(model);
    Eigen::VectorXd tau(model.nv());
    update_kinematics(model, state, &moved);
    calc_inverse_dynamics(model, vdot, nullptr, &moved, &tau);
    add_sample(t, a, model, state, vdot, &moved, tau, out);
  }

  double find_share(double t) const {
    return std::clamp(0.5 + (recorded_.lifts ? 0.8 : 0.3) * std::sin(1.3 * t + turn_), 0.0, 1.0);
  }  // of what the feet bear, the left one's

  void add_sample(double t, const Vector3d& a, const Model& model, const State& state, const Eigen::VectorXd& vdot,
                  Data* data, const Eigen::VectorXd& needed, Recording* out) {
    out->time.push_back(t);
    const Matrix3d R = state.R_WB.toRotationMatrix();
    if (recorded_.imu) put(out, "/imu/waist/angular_velocity", R.transpose() * state.V_WB.head<3>(), 1e-3);
    if (recorded_.imu) put(out, "/imu/waist/linear_acceleration", R.transpose() * (a - e_.scenario.gravity_W), 0.02);
    if (recorded_.pose) put_pose(out, place(t), state.R_WB);
    LinkWrenches wrenches(tree_.links.size(), Vector6d::Zero());
    const double share = find_share(t);
    for (const std::string side : {"l", "r"}) {
      const auto link = static_cast<size_t>(tree_.find_link(side + "_foot"));
      const Transform X = get_pose(*data, static_cast<int>(link));
      const double part = side == "l" ? share : 1 - share;
      // A foot in the air hangs on its sensor.
      const Vector3d hung =
          recorded_.lifts && !recorded_.whole_feet ? Vector3d(0, 0, kFootMass * 9.81) : Vector3d::Zero();
      const Vector3d force = part * (needed.segment<3>(3) + 2 * hung) - hung;
      const Vector3d moment = part * (needed.head<3>() - X.p.cross(needed.segment<3>(3)));
      wrenches[link] << moment, force;
      const double scale = side == "l" ? hidden_.force_scale : 1;
      const Matrix3d R_SW =
          (side == "l" ? make_turn(hidden_.turn).toRotationMatrix().transpose() : Matrix3d(Matrix3d::Identity())) *
          X.R.transpose();
      const Vector3d zero(0, side == "l" ? hidden_.zero_y : 0, 0);
      if (side == "l" || recorded_.right_foot)
        put_wrench(out, "/wrench/" + side, scale * (R_SW * force), R_SW * moment + zero);
    }
    Eigen::VectorXd tau(model.nv());
    calc_inverse_dynamics(model, vdot, &wrenches, data, &tau);
    for (int j = 0; j < 6; ++j) {
      JointColumns& c = out->joints[static_cast<size_t>(j)];
      c.signal[0].push_back(state.q(j) + (j == 0 ? hidden_.give * tau(6 + j) : 0.0) + 2e-5 * normal_(random_));
      const bool knee = j == 1;
      const double dry = hidden_.every + (knee ? hidden_.dry : 0);
      const double rotor = hidden_.every_rotor + (knee ? hidden_.rotor : 0);
      const double friction =
          dry * std::tanh(state.qd(j) / 1e-3) + hidden_.every_viscous * state.qd(j) + rotor * vdot(6 + j);
      if (recorded_.effort) c.signal[2].push_back(tau(6 + j) + friction + 0.05 * normal_(random_));
    }
  }

  void put(Recording* out, const std::string& base, const Vector3d& v, double noise) {
    for (int i = 0; i < 3; ++i) out->other[base + "/" + "xyz"[i]].push_back(v(i) + noise * normal_(random_));
  }

  void put_pose(Recording* out, const Vector3d& p, const Eigen::Quaterniond& q) {
    for (int i = 0; i < 3; ++i) out->other[std::string("/base/pose/position/") + "xyz"[i]].push_back(p(i));
    for (int i = 0; i < 4; ++i) out->other[std::string("/base/pose/orientation/") + "xyzw"[i]].push_back(q.coeffs()(i));
  }

  void put_wrench(Recording* out, const std::string& base, const Vector3d& force, const Vector3d& moment) {
    if (!recorded_.six_axes) {
      out->other[base + "/force/z"].push_back(recorded_.zero + recorded_.unit * force.z() + 0.2 * normal_(random_));
      return;
    }
    put(out, base + "/force", force, 0.3);
    if (recorded_.moments) put(out, base + "/torque", moment, 0.03);
  }

  Hidden hidden_;
  Recorded recorded_;
  Experiment e_;
  TreeSpec tree_;
  double turn_ = 0;
  Vector3d level_{0, 0, 0};
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

}  // namespace

std::string make_link(const std::string& name, double mass, double z, const std::string& more) {
  const double i = 0.02 * mass;
  return "<link name=\"" + name + "\"><inertial><origin xyz=\"0 0 " + std::to_string(z) + "\"/><mass value=\"" +
         std::to_string(mass) + "\"/><inertia ixx=\"" + std::to_string(i) + "\" iyy=\"" + std::to_string(i) +
         "\" izz=\"" + std::to_string(i) + "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>" + more + "</link>";
}

std::string make_biped_urdf() {
  std::string out = "<robot name=\"biped\">" + make_link("pelvis", 20, 0.1);
  for (const std::string side : {"l", "r"}) {
    const std::string y = side == "l" ? "0.1" : "-0.1";
    out += make_link(side + "_thigh", 4, -0.15) + make_link(side + "_shank", 3, -0.15) +
           make_link(
               side + "_foot", kFootMass, -0.03,
               "<collision><origin xyz=\"0 0 -0.05\"/><geometry><box size=\"0.2 0.1 0.02\"/></geometry></collision>");
    out += make_joint(side + "_hip", "pelvis", side + "_thigh", "0 " + y + " 0");
    out += make_joint(side + "_knee", side + "_thigh", side + "_shank", "0 0 -0.3");
    out += make_joint(side + "_ankle", side + "_shank", side + "_foot", "0 0 -0.3");
  }
  return out + "</robot>";
}

Experiment make_biped(const Hidden& hidden, const Recorded& recorded) { return Maker(hidden, recorded).run(); }

void hang_upside_down(Experiment* e) {
  std::string urdf = make_biped_urdf(), scenario = kBipedScenario;
  for (const std::string side : {"l", "r"}) {
    const std::string below = make_link(side + "_ft", 0.5, 0.03);  // the foot's mass, in the sensor's axes
    const std::string fixed = "<joint name=\"" + side + "_mount\" type=\"fixed\"><parent link=\"" + side +
                              "_foot\"/><child link=\"" + side +
                              "_ft\"/><origin xyz=\"0 0 0\" rpy=\"3.14159265358979 0 0\"/></joint>";
    const size_t foot = urdf.find("<inertial>", urdf.find("<link name=\"" + side + "_foot\"")),
                 end = urdf.find("</inertial>", foot);
    urdf.erase(foot, end + std::string("</inertial>").size() - foot);
    urdf.insert(urdf.rfind("</robot>"), below + fixed);
    scenario.replace(scenario.rfind(side + "_foot}"), 6, side + "_ft");
  }
  e->scenario = parse_scenario(scenario, "biped.yaml");
  e->robot = parse_robot(urdf, "biped.urdf", e->scenario);
  for (Recording& r : e->recordings) {
    for (auto& [name, column] : r.other) {
      if (name.rfind("/wrench/", 0) != 0 || name.back() == 'x') continue;
      for (double& v : column) v = -v;
    }
  }
}

void scale_readings(const std::string& sensor, double factor, Experiment* e) {
  for (Recording& r : e->recordings) {
    for (const char* axis : {"/x", "/y", "/z"}) {
      for (double& v : r.other.at(sensor + axis)) v *= factor;
    }
  }
}

Evidence diagnose_biped(const Hidden& hidden, const Recorded& recorded) {
  const LeggedReport report = diagnose_legged(make_biped(hidden, recorded), nullptr);
  EXPECT_TRUE(report.judged);
  return report.evidence;
}

}  // namespace hrp::diagnosis::floating

// SPDX-License-Identifier: BSD-3-Clause
// openhrp_dds.Robot and State: the functions of common/multibody.
#include "common/base/join_words.h"
#include "common/multibody/forward_dynamics.h"
#include "common/multibody/mass_matrix.h"
#include "common/multibody/momentum.h"
#include "common/multibody/regressor.h"
#include "python/src/arrays.h"
#include "python/src/robot.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::python {

void check_state(const TreeSpec& tree, const State& state) {
  const Eigen::Index n = tree.num_joints();
  for (const auto& [name, vector] : {std::make_pair("state.q", &state.q), std::make_pair("state.qd", &state.qd)}) {
    if (vector->size() == n) continue;
    throw py::value_error(std::string(name) + " must have shape (" + std::to_string(n) + ",) for robot '" + tree.name +
                          "', not (" + std::to_string(vector->size()) + ",)");
  }
}

namespace {

std::vector<std::string> get_links(const PyRobot& robot) {
  std::vector<std::string> names;
  for (const LinkSpec& link : robot.description.tree.links) names.push_back(link.name);
  return names;
}

std::vector<std::string> get_joints(const PyRobot& robot) {
  std::vector<std::string> names;
  for (int i = 0; i < robot.model.num_joints(); ++i) names.push_back(robot.description.tree.joint(i).name);
  return names;
}

std::vector<std::string> get_frames(const PyRobot& robot) {
  std::vector<std::string> names;
  for (const FrameSpec& frame : robot.description.tree.frames) names.push_back(frame.name);
  return names;
}

int find_frame(const PyRobot& robot, const std::string& name) {
  const int frame = robot.description.tree.find_frame(name);
  if (frame < 0)
    throw py::value_error("robot '" + robot.description.tree.name + "' has no frame '" + name +
                          "'; frames: " + join_words(get_frames(robot)));
  return frame;
}

int find_link(const PyRobot& robot, const std::string& name) {
  const int link = robot.description.tree.find_link(name);
  if (link < 0)
    throw py::value_error("robot '" + robot.description.tree.name + "' has no moving link '" + name +
                          "'; links: " + join_words(get_links(robot)));
  return link;
}

void update(PyRobot& robot, const State& state) {
  check_state(robot.description.tree, state);
  update_kinematics(robot.model, state, &robot.data);
}

template <typename Value, typename Get>
Eigen::VectorXd collect(const PyRobot& robot, Get get) {
  Eigen::VectorXd values(robot.model.num_joints());
  for (int i = 0; i < robot.model.num_joints(); ++i) values[i] = get(robot.description.tree.joint(i));
  return values;
}

LinkWrenches take_wrenches(const PyRobot& robot, const py::dict& wrenches) {
  LinkWrenches all(static_cast<size_t>(robot.model.num_links()), Vector6d::Zero());
  for (const auto& [link, wrench] : wrenches) {
    const std::string name = py::cast<std::string>(link);
    all[static_cast<size_t>(find_link(robot, name))] = take_finite(wrench, "wrenches['" + name + "']", 6);
  }
  return all;
}

State make_state_of(const PyRobot& robot) { return make_state(robot.model); }

Eigen::MatrixXd calc_jacobian(PyRobot& robot, const State& state, const std::string& frame, const py::object& point) {
  update(robot, state);
  const int index = find_frame(robot, frame);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, robot.model.nv());
  const Transform X_WF = calc_frame_pose(robot.model, robot.data, index);
  const Vector3d p_FQ = point.is_none() ? Vector3d::Zero() : Vector3d(take_finite(point, "point", 3));
  calc_point_jacobian(robot.model, robot.data, robot.description.tree.frames[static_cast<size_t>(index)].link,
                      X_WF * p_FQ, J);
  return J;
}

Vector6d calc_bias_acceleration(PyRobot& robot, const State& state, const std::string& frame) {
  update(robot, state);
  const int index = find_frame(robot, frame);
  const Vector3d p_WF = calc_frame_pose(robot.model, robot.data, index).p;
  return calc_point_bias_acceleration(robot.model, robot.description.tree.frames[static_cast<size_t>(index)].link, p_WF,
                                      &robot.data);
}

Eigen::VectorXd calc_needed_force(PyRobot& robot, const State& state, const py::object& vdot,
                                  const py::dict& wrenches) {
  update(robot, state);
  const LinkWrenches links = take_wrenches(robot, wrenches);
  Eigen::VectorXd tau(robot.model.nv());
  calc_inverse_dynamics(robot.model, take_finite(vdot, "vdot", robot.model.nv()), &links, &robot.data, &tau);
  return tau;
}

Eigen::VectorXd calc_acceleration(PyRobot& robot, const State& state, const py::object& efforts,
                                  const py::dict& wrenches) {
  update(robot, state);
  const LinkWrenches links = take_wrenches(robot, wrenches);
  Eigen::VectorXd vdot(robot.model.nv());
  const Status status = calc_forward_dynamics(robot.model, take_finite(efforts, "efforts", robot.model.num_joints()),
                                              &links, {}, &robot.data, &vdot);
  if (status != Status::kOk) throw py::value_error(std::string("forward_dynamics: ") + get_status_text(status));
  return vdot;
}

py::tuple calc_regressors(PyRobot& robot, const State& state, const py::object& vdot) {
  update(robot, state);
  Regressor regressor(robot.model);
  calc_regressor(robot.model, take_finite(vdot, "vdot", robot.model.nv()), &robot.data, &regressor);
  return py::make_tuple(std::move(regressor.Y_BI), std::move(regressor.Y_JI), std::move(regressor.Y_JJ));
}

py::array calc_poses(PyRobot& robot, const State& state) {
  update(robot, state);
  py::array_t<double> poses({robot.model.num_links(), 4, 4});
  for (int i = 0; i < robot.model.num_links(); ++i) {
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(poses.mutable_data(i)) =
        make_matrix(get_pose(robot.data, i));
  }
  return std::move(poses);
}

State make_moved(PyRobot& robot, const State& state, const py::object& v, double dt) {
  check_state(robot.description.tree, state);
  State moved = state;
  integrate_positions(robot.model, take_finite(v, "v", robot.model.nv()), dt, &moved);
  return moved;
}

State make_py_state(const py::object& q, const py::object& qd, const py::object& position,
                    const py::object& orientation, const py::object& velocity) {
  State state;
  const Numbers values = take_numbers(q, "q");
  if (values.ndim() != 1) throw py::value_error("q must have shape (n,), not " + format_shape(values));
  state.q = take_finite(q, "q", values.shape(0));
  state.qd =
      qd.is_none() ? Eigen::VectorXd(Eigen::VectorXd::Zero(state.q.size())) : take_finite(qd, "qd", state.q.size());
  if (!position.is_none()) state.p_WB = take_finite(position, "base_position", 3);
  if (!orientation.is_none()) state.R_WB = take_quaternion(orientation, "base_orientation");
  if (!velocity.is_none()) state.V_WB = take_finite(velocity, "base_velocity", 6);
  return state;
}

void bind_state(py::module_& m) {
  py::class_<State>(m, "State", "Positions and velocities of a robot: base in the world, joints in the robot's order.")
      .def(py::init(&make_py_state), py::arg("q"), py::arg("qd") = py::none(), py::kw_only(),
           py::arg("base_position") = py::none(), py::arg("base_orientation") = py::none(),
           py::arg("base_velocity") = py::none(),
           "q (n,) [rad or m]; qd (n,) [rad/s or m/s], zero when left out; base_position (3,) [m] p_WB;\n"
           "base_orientation (4,) unit quaternion (w, x, y, z) R_WB; base_velocity (6,) [rad/s; m/s] [w_WB; v_WB], "
           "world axes.")
      .def_property_readonly(
          "q", [](const py::object& self) { return view(self.cast<const State&>().q, self); },
          "(n,) [rad or m] joint positions; read-only, no copy.")
      .def_property_readonly(
          "qd", [](const py::object& self) { return view(self.cast<const State&>().qd, self); },
          "(n,) [rad/s or m/s] joint velocities; read-only, no copy.")
      .def_property_readonly(
          "base_position", [](const py::object& self) { return view(self.cast<const State&>().p_WB, self); },
          "(3,) [m] p_WB; read-only, no copy.")
      .def_property_readonly(
          "base_orientation", [](const State& state) { return make_wxyz(state.R_WB); },
          "(4,) R_WB as a unit quaternion (w, x, y, z).")
      .def_property_readonly(
          "base_velocity", [](const py::object& self) { return view(self.cast<const State&>().V_WB, self); },
          "(6,) [rad/s; m/s] [w_WB; v_WB], world axes; read-only, no copy.")
      .def(py::pickle(
          [](const State& s) {
            return py::make_tuple(s.q, s.qd, Vector3d(s.p_WB), make_wxyz(s.R_WB), Vector6d(s.V_WB));
          },
          [](const py::tuple& kept) { return make_py_state(kept[0], kept[1], kept[2], kept[3], kept[4]); }))
      .def_property_readonly("hash", &calc_state_hash, "Of the bits of all numbers: equal states, equal hashes.");
}

using RobotClass = py::class_<PyRobot, std::shared_ptr<PyRobot>>;

// What the robot is.
void bind_description(RobotClass& robot) {
  robot
      .def_property_readonly(
          "name", [](const PyRobot& r) { return r.description.tree.name; }, "From the URDF.")
      .def_property_readonly("links", &get_links, "Names of the moving links; the first one is the base.")
      .def_property_readonly("joints", &get_joints, "Names of the joints: the order of q, qd and efforts.")
      .def_property_readonly("frames", &get_frames, "Names of the frames: every link of the URDF, welded ones, too.")
      .def_property_readonly(
          "floating_base", [](const PyRobot& r) { return r.model.floating(); },
          "False: the base is welded to the world.")
      .def_property_readonly(
          "num_joints", [](const PyRobot& r) { return r.model.num_joints(); }, "n.")
      .def_property_readonly(
          "nv", [](const PyRobot& r) { return r.model.nv(); }, "Size of v: n, and 6 more with a floating base.")
      .def_property_readonly(
          "mass", [](const PyRobot& r) { return r.model.mass(); }, "[kg] of all links.")
      .def_property_readonly(
          "gravity", [](const PyRobot& r) { return Vector3d(r.model.gravity_W()); }, "(3,) [m/s^2] world axes.")
      .def_property_readonly(
          "lower", [](const PyRobot& r) { return collect<double>(r, [](const JointSpec& j) { return j.lower; }); },
          "(n,) [rad or m] limits of the joints, -inf where there is none.")
      .def_property_readonly(
          "upper", [](const PyRobot& r) { return collect<double>(r, [](const JointSpec& j) { return j.upper; }); },
          "(n,) [rad or m] limits of the joints, inf where there is none.")
      .def_property_readonly(
          "effort_limit",
          [](const PyRobot& r) { return collect<double>(r, [](const JointSpec& j) { return j.effort_limit; }); },
          "(n,) [N m or N], inf where there is none.")
      .def_property_readonly(
          "warnings", [](const PyRobot& r) { return r.description.warnings; },
          "What was repaired, ignored or missing in the URDF.")
      .def(
          "__deepcopy__", [](const py::object& self, const py::dict&) { return self; }, py::arg("memo"),
          "The same object: a robot does not change.")
      .def("zero_state", &make_state_of, "A State with all numbers zero and the base at the world's origin.");
}

// Where its links are, and how they move.
void bind_kinematics(RobotClass& robot) {
  robot.def("poses", &calc_poses, py::arg("state"), "(links, 4, 4) [m] X_WL of all moving links, homogeneous matrices.")
      .def(
          "pose",
          [](PyRobot& r, const State& state, const std::string& frame) {
            update(r, state);
            return make_matrix(calc_frame_pose(r.model, r.data, find_frame(r, frame)));
          },
          py::arg("state"), py::arg("frame"), "(4, 4) [m] X_WF of a frame, homogeneous matrix.")
      .def(
          "velocity",
          [](PyRobot& r, const State& state, const std::string& frame) {
            update(r, state);
            return Vector6d(calc_frame_velocity(r.model, r.data, find_frame(r, frame)));
          },
          py::arg("state"), py::arg("frame"), "(6,) [rad/s; m/s] [w; v of the frame's origin], world axes.")
      .def("jacobian", &calc_jacobian, py::arg("state"), py::arg("frame"), py::arg("point") = py::none(),
           "(6, nv): [w; v of the point] = J v, world axes. point (3,) [m] in the frame's axes; its origin when left "
           "out.")
      .def("bias_acceleration", &calc_bias_acceleration, py::arg("state"), py::arg("frame"),
           "(6,) [rad/s^2; m/s^2] Jdot v: acceleration of the frame's origin when vdot = 0, without gravity, world "
           "axes.");
}

// The equations of motion, and what they are made of.
void bind_dynamics(RobotClass& robot) {
  robot
      .def(
          "mass_matrix",
          [](PyRobot& r, const State& state) {
            update(r, state);
            return Eigen::MatrixXd(update_mass_matrix(r.model, &r.data));
          },
          py::arg("state"), "(nv, nv) M, rotor inertias on the diagonal.")
      .def(
          "bias",
          [](PyRobot& r, const State& state) {
            update(r, state);
            Eigen::VectorXd bias(r.model.nv());
            calc_bias(r.model, &r.data, &bias);
            return bias;
          },
          py::arg("state"), "(nv,) C v + g: velocity products and gravity.")
      .def("inverse_dynamics", &calc_needed_force, py::arg("state"), py::arg("vdot"), py::arg("wrenches") = py::dict(),
           "(nv,) M vdot + C v + g - J^T F. vdot (nv,). wrenches: link -> (6,) [N m; N] [moment about the link's "
           "origin;\n"
           "force], world axes.")
      .def("forward_dynamics", &calc_acceleration, py::arg("state"), py::arg("efforts"),
           py::arg("wrenches") = py::dict(),
           "(nv,) vdot of efforts (n,) [N m or N] and wrenches as in inverse_dynamics().")
      .def("regressor", &calc_regressors, py::arg("state"), py::arg("vdot"),
           "(Y_BI, Y_JI, Y_JJ): (6, 10 links), (n, 10 links), (n, 3 n). Force on the base Y_BI p, efforts Y_JI p + "
           "Y_JJ r with\n"
           "p = inertial_parameters, r = joint_parameters.")
      .def_property_readonly(
          "inertial_parameters", [](const PyRobot& r) { return make_inertial_parameters(r.model); },
          "(10 links,) each m, m c (3), inertia about the link's origin xx xy xz yy yz zz; link axes.")
      .def_property_readonly(
          "joint_parameters", [](const PyRobot& r) { return make_joint_parameters(r.model); },
          "(3 n,) each rotor inertia, viscous friction, Coulomb friction.");
}

// The robot as a whole: centre of mass, momentum, energy.
void bind_balance(RobotClass& robot) {
  robot
      .def(
          "centre_of_mass",
          [](PyRobot& r, const State& state) {
            update(r, state);
            return Vector3d(calc_centre_of_mass(r.model, r.data));
          },
          py::arg("state"), "(3,) [m] world.")
      .def(
          "centre_of_mass_jacobian",
          [](PyRobot& r, const State& state) {
            update(r, state);
            Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, r.model.nv());
            calc_centre_of_mass_jacobian(r.model, &r.data, J);
            return J;
          },
          py::arg("state"), "(3, nv): velocity of the centre of mass = J v.")
      .def(
          "centroidal_momentum",
          [](PyRobot& r, const State& state) {
            update(r, state);
            return Vector6d(calc_centroidal_momentum(r.model, r.data));
          },
          py::arg("state"),
          "(6,) [N m s; N s] [angular momentum about the centre of mass; linear momentum], world axes.")
      .def(
          "kinetic_energy",
          [](PyRobot& r, const State& state) {
            update(r, state);
            return calc_kinetic_energy(r.model, r.data);
          },
          py::arg("state"), "[J] with reflected rotor inertias.")
      .def(
          "potential_energy",
          [](PyRobot& r, const State& state) {
            update(r, state);
            return calc_potential_energy(r.model, r.data);
          },
          py::arg("state"), "[J] of gravity, zero at the world's origin.");
}

// The generalised velocity of a state, and where it leads.
void bind_velocities(RobotClass& robot) {
  robot
      .def(
          "generalised_velocity",
          [](PyRobot& r, const State& state) {
            check_state(r.description.tree, state);
            Eigen::VectorXd v(r.model.nv());
            get_generalised_velocity(r.model, state, &v);
            return v;
          },
          py::arg("state"), "(nv,) v = [w_WB; v_WB; qd].")
      .def("integrate", &make_moved, py::arg("state"), py::arg("v"), py::arg("dt"),
           "The State moved by v (nv,) during dt [s]: exponential map on the attitude. Velocities stay as they were.");
}

}  // namespace

void bind_robot(py::module_& m) {
  bind_state(m);
  RobotClass robot(
      m, "Robot",
      "A tree of rigid bodies and its equations of motion.\n\n"
      "Generalised velocity v (nv,) = [w_WB; v_WB; qd]: base first, world axes; a fixed base has only qd. Generalised "
      "force\n"
      "(nv,) = [moment about the base's origin; force; efforts]. Spatial vectors have the angular part first.");
  bind_description(robot);
  bind_kinematics(robot);
  bind_dynamics(robot);
  bind_balance(robot);
  bind_velocities(robot);
  m.def(
      "load_robot",
      [](const std::string& urdf, bool floating_base, const py::object& gravity) {
        Scenario scenario;
        scenario.robot = urdf;
        scenario.floating_base = floating_base;
        return std::make_shared<PyRobot>(load_robot(scenario), Vector3d(take_finite(gravity, "gravity", 3)));
      },
      py::arg("urdf"), py::kw_only(), py::arg("floating_base") = true,
      py::arg("gravity") = py::make_tuple(0.0, 0.0, -9.81),
      "A Robot from a URDF file. floating_base=False welds its root to the world. gravity (3,) [m/s^2], world axes.\n"
      "Raises InputError (a ValueError) with file, line and reason.");
}

}  // namespace hrp::python

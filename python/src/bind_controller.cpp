// SPDX-License-Identifier: BSD-3-Clause
// openhrp_dds.Controller's other side: observations, commands, and the process that joins a run.
#include <cmath>
#include <cstdio>

#include "python/src/py_controller.h"
#include "python/src/robot.h"

namespace hrp::python {
namespace {

void check_array(const Eigen::VectorXd& values, const char* name, const Robot& robot) {
  const auto n = static_cast<Eigen::Index>(robot.joints.size());
  if (values.size() == 0) return;
  if (values.size() != n) {
    throw py::value_error(std::string(name) + " must have shape (" + std::to_string(n) +
                          ",), one number per joint of '" + robot.name + "', not (" + std::to_string(values.size()) +
                          ",)");
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    if (std::isfinite(values[i])) continue;
    throw py::value_error(std::string(std::isnan(values[i]) ? "NaN" : "an infinite value") + " in " + name +
                          " of joint '" + robot.joints[static_cast<size_t>(i)] + "'");
  }
}

Eigen::VectorXd take_optional(const py::object& value, const char* name) {
  if (value.is_none()) return {};
  const Numbers array = take_numbers(value, name);
  if (array.ndim() != 1) throw py::value_error(std::string(name) + " must have shape (n,), not " + format_shape(array));
  return take_vector(value, name, array.shape(0));
}

JointCommand make_command(const py::object& q, const py::object& qd, const py::object& efforts) {
  return {take_optional(q, "q"), take_optional(qd, "qd"), take_optional(efforts, "efforts")};
}

// "ValueError: no step now (my_controller.py:12)".
std::string describe(const py::error_already_set& error) {
  std::string text = std::string(py::str(error.type().attr("__name__"))) + ": " + std::string(py::str(error.value()));
  if (!error.trace()) return text;
  py::object last = error.trace();
  while (!last.attr("tb_next").is_none()) last = last.attr("tb_next");
  return text + " (" + std::string(py::str(last.attr("tb_frame").attr("f_code").attr("co_filename"))) + ":" +
         std::string(py::str(last.attr("tb_lineno"))) + ")";
}

py::dict make_imus(const py::object& self) {
  const auto& observation = self.cast<const Observation&>();
  py::dict all;
  for (size_t i = 0; i < observation.data.imus.size(); ++i)
    all[observation.robot->imus[i].c_str()] = observation.data.imus[i];
  return all;
}

py::dict make_wrenches(const py::object& self) {
  const auto& observation = self.cast<const Observation&>();
  py::dict all;
  for (size_t i = 0; i < observation.data.wrenches.size(); ++i) {
    const WrenchSample& sample = observation.data.wrenches[i];
    Vector6d wrench;
    wrench << sample.torque, sample.force;
    all[observation.robot->wrenches[i].c_str()] = wrench;
  }
  return all;
}

// The rest of a command line goes to the common options of all servers.
int run_controller_process(const py::object& controller, const std::string& program,
                           const std::vector<std::string>& arguments) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const py::gil_scoped_release free;
  return run_controller(static_cast<int>(words.size()), argv.data(), program,
                        [&](const Robot& robot) { return std::make_unique<PyController>(controller, robot); });
}

void bind_controlled_robot(py::module_& m) {
  py::class_<Robot, std::shared_ptr<Robot>>(
      m, "ControlledRobot", "What a controller may know of its robot. Arrays are in the order of joints.")
      .def_readonly("name", &Robot::name, "From the URDF.")
      .def_readonly("joints", &Robot::joints, "Names: the order of q, qd and efforts.")
      .def_readonly("imus", &Robot::imus, "Names of the IMUs.")
      .def_readonly("wrench_sensors", &Robot::wrenches, "Names of the force sensors.")
      .def_readonly("period", &Robot::period, "[s] between two observations = between two commands.")
      .def_property_readonly(
          "lower", [](const py::object& self) { return view(self.cast<const Robot&>().lower, self); },
          "(n,) [rad or m]; read-only.")
      .def_property_readonly(
          "upper", [](const py::object& self) { return view(self.cast<const Robot&>().upper, self); },
          "(n,) [rad or m]; read-only.")
      .def_property_readonly(
          "effort_limit", [](const py::object& self) { return view(self.cast<const Robot&>().effort_limit, self); },
          "(n,) [N m or N]; read-only.")
      .def_property_readonly(
          "initial_q", [](const py::object& self) { return view(self.cast<const Robot&>().initial_q, self); },
          "(n,) [rad or m] pose at the start of the run; read-only.")
      .def_property_readonly("drive", &find_drive, "The scenario's key: servo, effort, motion or voltage.")
      .def_property_readonly(
          "model", [](const Robot& r) { return std::make_shared<PyRobot>(*r.description, r.gravity_W); },
          "A new Robot with the equations of motion; keep it, it is made at each call.")
      .def(
          "__deepcopy__", [](const py::object& self, const py::dict&) { return self; }, py::arg("memo"),
          "The same object: it does not change.");
}

void bind_observation(py::module_& m) {
  py::class_<ImuSample>(m, "ImuSample", "One reading of an IMU, sensor axes S.")
      .def_property_readonly(
          "orientation", [](const ImuSample& s) { return make_wxyz(s.R_WS); },
          "(4,) R_WS as a unit quaternion (w, x, y, z).")
      .def_property_readonly(
          "angular_velocity", [](const ImuSample& s) { return Vector3d(s.angular_velocity); },
          "(3,) [rad/s] sensor axes.")
      .def_property_readonly(
          "linear_acceleration", [](const ImuSample& s) { return Vector3d(s.linear_acceleration); },
          "(3,) [m/s^2] specific force, sensor axes: +9.81 along the upward axis at rest.");
  py::class_<Observation>(m, "Observation",
                          "One sample of all sensors. Arrays look into the observation: read-only, no copy, valid as "
                          "long as you keep them.")
      .def_property_readonly(
          "time", [](const Observation& o) { return o.data.time; }, "[s] since the start of the run.")
      .def_property_readonly(
          "step", [](const Observation& o) { return o.data.step; }, "Number of the physics step.")
      .def_property_readonly(
          "q", [](const py::object& self) { return view(self.cast<const Observation&>().data.q, self); },
          "(n,) [rad or m] encoders.")
      .def_property_readonly(
          "qd", [](const py::object& self) { return view(self.cast<const Observation&>().data.qd, self); },
          "(n,) [rad/s or m/s].")
      .def_property_readonly(
          "efforts", [](const py::object& self) { return view(self.cast<const Observation&>().data.effort, self); },
          "(n,) [N m or N] as a drive logs them.")
      .def_property_readonly("imus", &make_imus, "Name -> ImuSample.")
      .def_property_readonly("wrenches", &make_wrenches,
                             "Name -> (6,) [N m; N] [torque; force] that the sensor's link exerts on its parent, about "
                             "the link's origin, link axes.")
      .def_property_readonly(
          "base_pose",
          [](const Observation& o) -> py::object {
            if (!o.data.has_base_pose) return py::none();
            return py::cast(make_matrix(o.data.X_WB));
          },
          "(4, 4) [m] X_WB, homogeneous matrix, of scenarios with `sensors: {base_pose: true}`; else None.")
      .def_property_readonly(
          "base_velocity",
          [](const Observation& o) -> py::object {
            if (!o.data.has_base_pose) return py::none();
            return py::cast(Vector6d(o.data.V_WB));
          },
          "(6,) [rad/s; m/s] [w_WB; v_WB], world axes, as base_pose.");
}

}  // namespace

std::string find_drive(const Robot& robot) {
  return parse_scenario(robot.description->scenario, robot.description->scenario_path).drive;
}

void check_command(const JointCommand& command, const Robot& robot) {
  check_array(command.q, "q", robot);
  check_array(command.qd, "qd", robot);
  check_array(command.effort, "efforts", robot);
}

JointCommand convert_command(const py::object& value, const Robot& robot, const std::string& drive) {
  if (value.is_none()) throw py::type_error("must be efforts (an array) or a Command, not None");
  JointCommand command;
  if (py::isinstance<JointCommand>(value)) {
    command = value.cast<JointCommand>();
  } else {
    command.effort = take_vector(value, "efforts", static_cast<Eigen::Index>(robot.joints.size()));
    if (drive != "effort") {
      throw py::value_error("efforts alone move nothing with `drive: " + drive +
                            "`: use openhrp_dds.Command(q, qd, efforts), or `drive: effort` in the scenario");
    }
  }
  check_command(command, robot);
  if (command.q.size() == 0 && drive != "effort")
    throw py::value_error("q is missing: the joints have servos (`drive: " + drive + "`)");
  if (command.q.size() == 0) command.q = robot.initial_q;  // nothing looks at it, but the message has it
  return command;
}

PyController::PyController(const py::object& object, const Robot& robot)
    : drive_(find_drive(robot)), robot_(std::make_shared<Robot>(robot)) {
  const py::gil_scoped_acquire lock;
  object_ = object;
  name_ = std::string(py::str(py::type::of(object_).attr("__name__")));
}

PyController::~PyController() {
  const py::gil_scoped_acquire lock;
  object_ = py::object();
  memory_ = py::object();
}

std::string PyController::make_place(const SensorData& sensors) const {
  char place[80];
  std::snprintf(place, sizeof place, "' at step %llu (t = %.4f s): ", sensors.step, sensors.time);
  return "controller '" + name_ + place;
}

void PyController::start(const Robot&) {
  const py::gil_scoped_acquire lock;
  try {
    const py::object info = py::cast(std::const_pointer_cast<Robot>(robot_));
    object_.attr("robot") = info;
    object_.attr("start")(info);
  } catch (py::error_already_set& error) {
    throw ControllerError("controller '" + name_ + "' in start(): " + describe(error),
                          std::make_shared<py::error_already_set>(error));
  }
}

JointCommand PyController::ask(const SensorData& sensors) {
  try {
    const py::object answer = object_.attr("step")(Observation{sensors, robot_});
    return convert_command(answer, *robot_, drive_);
  } catch (py::error_already_set& error) {
    throw ControllerError(make_place(sensors) + describe(error), std::make_shared<py::error_already_set>(error));
  } catch (const py::builtin_exception& error) {
    throw ControllerError(make_place(sensors) + "step() returned what cannot be used: " + error.what());
  }
}

JointCommand PyController::control(const SensorData& sensors, const Robot&) {
  const py::gil_scoped_acquire lock;
  return ask(sensors);
}

std::unique_ptr<Controller> PyController::clone() const {
  const py::gil_scoped_acquire lock;
  const py::object copy = py::module_::import("copy").attr("deepcopy");
  auto other = std::make_unique<PyController>(object_, *robot_);
  if (!memory_) {
    other->memory_ = copy(object_.attr("__dict__"));
  } else {
    object_.attr("__dict__").attr("clear")();
    object_.attr("__dict__").attr("update")(copy(memory_));
  }
  return other;
}

void bind_controller(py::module_& m) {
  bind_controlled_robot(m);
  bind_observation(m);
  py::class_<JointCommand>(m, "Command", "What a controller asks of the joints' servos until its next answer.")
      .def(py::init(&make_command), py::arg("q") = py::none(), py::arg("qd") = py::none(),
           py::arg("efforts") = py::none(),
           "q (n,) [rad or m] references; qd (n,) [rad/s or m/s], zero when left out; efforts (n,) [N m or N] in "
           "addition,\n"
           "zero when left out. With `drive: effort` efforts alone act, and q may be left out.")
      .def_property_readonly(
          "q", [](const py::object& self) { return view(self.cast<const JointCommand&>().q, self); },
          "(n,) or (0,) [rad or m]; read-only.")
      .def_property_readonly(
          "qd", [](const py::object& self) { return view(self.cast<const JointCommand&>().qd, self); },
          "(n,) or (0,) [rad/s or m/s]; read-only.")
      .def_property_readonly(
          "efforts", [](const py::object& self) { return view(self.cast<const JointCommand&>().effort, self); },
          "(n,) or (0,) [N m or N]; read-only.");
  m.def("run_controller_process", &run_controller_process, py::arg("controller"), py::arg("program"),
        py::arg("arguments"),
        "Joins a run as its controller and answers until it ends; returns the exit status. Use Controller.main().");
}

}  // namespace hrp::python

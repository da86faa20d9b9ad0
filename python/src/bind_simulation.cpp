// SPDX-License-Identifier: BSD-3-Clause
// openhrp_dds.Simulation: a run of a scenario in this process, by the runner of hrp-trial.
#include <atomic>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/messages/convert.h"
#include "python/src/py_controller.h"
#include "python/src/robot.h"
#include "servers/console/trial/trial.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp::python {
namespace {

constexpr long kStepsBetweenSignals = 1000;  // Ctrl-C is heard this often

struct SimulationFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Answers with what Simulation::set_command() was given; before that, the initial pose is held.
class GivenController : public Controller {
 public:
  explicit GivenController(std::shared_ptr<JointCommand> command) : command_(std::move(command)) {}
  void start(const Robot& robot) override {
    *command_ = JointCommand{};
    command_->q = robot.initial_q;
  }
  JointCommand control(const SensorData&, const Robot&) override { return *command_; }

 private:
  std::shared_ptr<JointCommand> command_;
};

enum class Law { kScenario, kGiven, kPython };

// Rows of a run.
struct Record {
  py::array time, q, qd, efforts, base_position, base_orientation, base_velocity, foot_forces;
};

struct Rows {
  std::vector<double> time, q, qd, efforts, position, orientation, velocity, feet;

  static void add(std::vector<double>* row, const double* values, Eigen::Index size) {
    row->insert(row->end(), values, values + size);
  }
  void add(const Trial& trial) {
    const State& state = trial.engine().state();
    const Eigen::Vector4d wxyz = make_wxyz(state.R_WB);
    time.push_back(trial.time());
    add(&q, state.q.data(), state.q.size());
    add(&qd, state.qd.data(), state.qd.size());
    add(&efforts, trial.engine().joint_efforts().data(), trial.engine().joint_efforts().size());
    add(&position, state.p_WB.data(), 3);
    add(&orientation, wxyz.data(), 4);
    add(&velocity, state.V_WB.data(), 6);
    feet.insert(feet.end(), trial.engine().foot_forces().begin(), trial.engine().foot_forces().end());
  }
};

struct SavedRun {
  TrialState state;
  std::string scenario;  // text
  Law law;
  JointCommand given;  // of Law::kGiven
  const void* owner;   // the simulation, which a controller in Python belongs to
};

// As every server reads it: the model parser may have put the robot into a motion's first pose.
Scenario load_as_servers(const std::string& path) {
  const Scenario scenario = load_scenario(path);
  const RobotDescription robot = load_robot(scenario);
  return parse_scenario(robot.scenario, robot.scenario_path);
}

class Simulation {
 public:
  Simulation(const std::string& path, const py::object& controller)
      : scenario_(load_as_servers(path)),
        law_(find_law(controller)),
        given_(std::make_shared<JointCommand>()),
        trial_(scenario_, [&](const Robot& robot) { return make_controller(controller, robot); }),
        robot_(std::make_shared<PyRobot>(trial_.robot(), scenario_.gravity_W)),
        names_(trial_.robot(), trial_.scenario()),
        drive_(scenario_.drive) {}

  // Throws as Python sees it when the controller cannot start.
  static std::unique_ptr<Simulation> make(const std::string& path, const py::object& controller) {
    std::unique_ptr<Simulation> made;
    guard([&] { made = std::make_unique<Simulation>(path, controller); });
    return made;
  }

  // Everything but steps: what a thread that is stepping must not be disturbed by.
  Trial& idle() {
    if (busy_)
      throw SimulationFault("this simulation is stepping in another thread, or asks itself from within its controller");
    return trial_;
  }

  void step(long steps) {
    run_steps(steps, [](const Trial&, long) {});
  }

  Record run(long steps, long every) {
    if (every < 1) throw py::value_error("every must be at least 1, not " + std::to_string(every));
    Rows rows;
    run_steps(steps, [&](const Trial& trial, long done) {
      if (done % every == 0) rows.add(trial);
    });
    return give_rows(std::move(rows));
  }

  void reset(const py::object& state) {
    Trial& trial = idle();
    if (state.is_none()) return guard([&] { trial.reset(); });
    const State& wanted = state.cast<const State&>();
    check_state(robot_->description.tree, wanted);
    guard([&] {
      if (!trial.reset_to(wanted))
        throw py::value_error("state does not fit the robot: not finite, or base_orientation is no unit quaternion");
    });
  }

  SavedRun save() {
    TrialState state = idle().save();
    if (!state.controllers[0] && law_ != Law::kGiven)
      throw SimulationFault("the controller of this scenario cannot be copied");
    return {std::move(state), scenario_.text, law_, *given_, this};
  }

  void restore(const SavedRun& saved) {
    Trial& trial = idle();
    if (saved.scenario != scenario_.text || saved.law != law_)
      throw py::value_error("saved: is of another scenario, or of another kind of controller");
    if (law_ == Law::kPython && saved.owner != this) {
      throw py::value_error("saved: a controller in Python goes back into the simulation that it was saved in");
    }
    trial.restore(saved.state);
    *given_ = saved.given;
  }

  // Acts from the next control step on.
  void set_command(const py::object& value) {
    if (law_ != Law::kGiven)
      throw SimulationFault("set_command() needs Simulation(scenario, controller=None); this one has a controller");
    *given_ = convert_command(value, idle().controlled(), drive_);
  }

  py::list make_forces();
  py::list make_contacts();
  py::list make_pushes();

  const Scenario& scenario() const { return scenario_; }
  const std::shared_ptr<PyRobot>& robot() const { return robot_; }

 private:
  static Law find_law(const py::object& controller) {
    if (controller.is_none()) return Law::kGiven;
    if (!py::isinstance<py::str>(controller)) return Law::kPython;
    if (controller.cast<std::string>() == "scenario") return Law::kScenario;
    throw py::value_error("controller must be 'scenario', None or a Controller, not '" +
                          controller.cast<std::string>() + "'");
  }
  std::unique_ptr<Controller> make_controller(const py::object& controller, const Robot& robot) {
    if (law_ == Law::kPython) return std::make_unique<PyController>(controller, robot);
    if (law_ == Law::kScenario) return make_scenario_controller(robot);
    return std::make_unique<GivenController>(given_);
  }

  template <typename Work>
  static void guard(const Work& work) {
    try {
      work();
    } catch (const ControllerError& error) {
      raise(error);
    }
  }

  [[noreturn]] static void raise(const ControllerError& error) {
    if (!error.cause) throw SimulationFault(error.what());
    const py::object type =
        py::module_::import("openhrp_dds._core").attr("SimulationError");  // before there is an error
    error.cause->restore();
    py::raise_from(type.ptr(), error.what());
    throw py::error_already_set();
  }

  template <typename OnStep>
  void run_steps(long steps, const OnStep& on_step) {
    if (steps < 0) throw py::value_error("steps must not be negative, not " + std::to_string(steps));
    idle();
    busy_ = true;
    const Release busy{&busy_};
    for (long done = 0; done < steps;) {
      const long until = std::min(steps, done + kStepsBetweenSignals);
      guard([&] {
        const py::gil_scoped_release free;
        for (; done < until; on_step(trial_, ++done)) {
          if (!trial_.step())
            throw SimulationFault("step " + std::to_string(trial_.step_number()) + ": " + trial_.fault());
        }
      });
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
  }

  Record give_rows(Rows&& rows) const {
    const size_t n = static_cast<size_t>(robot_->model.num_joints());
    const size_t steps = rows.time.size();
    const py::array time = give(std::move(rows.time), 1).attr("reshape")(-1);
    return {time,
            give(std::move(rows.q), n, steps),
            give(std::move(rows.qd), n, steps),
            give(std::move(rows.efforts), n, steps),
            give(std::move(rows.position), 3),
            give(std::move(rows.orientation), 4),
            give(std::move(rows.velocity), 6),
            give(std::move(rows.feet), scenario_.feet.size(), steps)};
  }

  struct Release {
    std::atomic<bool>* busy;
    ~Release() { *busy = false; }
  };

  Scenario scenario_;
  Law law_;
  std::shared_ptr<JointCommand> given_;
  Trial trial_;
  std::shared_ptr<PyRobot> robot_;
  BodyNames names_;
  std::string drive_;
  std::atomic<bool> busy_{false};
};

py::dict make_point(const PointForce& point) {
  py::dict values;
  values["position"] = Vector3d(point.p_WC);
  values["normal"] = Vector3d(point.n_BA_W);
  values["depth"] = point.depth;
  values["spring"] = Vector3d(point.spring);
  values["damper"] = Vector3d(point.damper);
  values["friction"] = Vector3d(point.friction);
  values["total"] = Vector3d(point.total);
  values["slip"] = Vector3d(point.slip);
  values["clipped"] = point.clipped;
  return values;
}

py::list Simulation::make_forces() {
  py::list all;
  for (const PairForce& pair : idle().engine().contact_forces()) {
    py::dict values;
    values["body_a"] = names_.get(pair.body_a);
    values["body_b"] = names_.get(pair.body_b);
    values["reference"] = Vector3d(pair.p_WR);
    values["spring"] = Vector6d(pair.spring);
    values["damper"] = Vector6d(pair.damper);
    values["friction"] = Vector6d(pair.friction);
    values["total"] = Vector6d(pair.total);
    values["clipped"] = pair.clipped;
    py::list points;
    for (const PointForce& point : pair.points) points.append(make_point(point));
    values["points"] = points;
    all.append(values);
  }
  return all;
}

py::list Simulation::make_pushes() {
  py::list all;
  for (const PushForce& push : idle().engine().pushes()) {
    py::dict values;
    values["name"] = push.name;
    values["link"] = push.link;
    values["point"] = Vector3d(push.p_LQ);
    values["force"] = Vector3d(push.force_W);
    all.append(values);
  }
  return all;
}

py::list Simulation::make_contacts() {
  py::list all;
  for (const ContactPair& pair : idle().calc_contacts()) {
    py::dict values;
    values["body_a"] = names_.get(pair.body_a);
    values["body_b"] = names_.get(pair.body_b);
    values["friction"] = pair.friction;
    py::list points;
    for (const ContactPoint& point : pair.points) {
      py::dict one;
      one["position"] = Vector3d(point.p_WC);
      one["normal"] = Vector3d(point.n_BA_W);
      one["depth"] = point.depth;
      points.append(one);
    }
    values["points"] = points;
    all.append(values);
  }
  return all;
}

void bind_record(py::module_& m) {
  py::class_<Record>(m, "Record",
                     "What Simulation.run() returns: one row every `every` steps, after the step. Arrays are yours: no "
                     "copy, writable.")
      .def_readonly("time", &Record::time, "(T,) [s].")
      .def_readonly("q", &Record::q, "(T, n) [rad or m].")
      .def_readonly("qd", &Record::qd, "(T, n) [rad/s or m/s].")
      .def_readonly("efforts", &Record::efforts,
                    "(T, n) [N m or N] on the links over the step: servo, friction, springs, stops.")
      .def_readonly("base_position", &Record::base_position, "(T, 3) [m] p_WB.")
      .def_readonly("base_orientation", &Record::base_orientation, "(T, 4) R_WB as (w, x, y, z).")
      .def_readonly("base_velocity", &Record::base_velocity, "(T, 6) [rad/s; m/s] [w_WB; v_WB], world axes.")
      .def_readonly("foot_forces", &Record::foot_forces,
                    "(T, feet) [N] vertical force on each foot, in the order of the scenario's feet.");
  py::class_<SavedRun>(
      m, "SavedRun",
      "A run to go back to: state, all memories, the command that acts, the controller. See Simulation.save().")
      .def_property_readonly(
          "step_number", [](const SavedRun& s) { return s.state.step; }, "Where it was saved.");
}

}  // namespace

void bind_simulation(py::module_& m) {
  py::register_exception<InputError>(m, "InputError", PyExc_ValueError).attr("__doc__") =
      "A scenario, robot or file that cannot be used: file, line, column, key, reason.";
  py::register_exception<SimulationFault>(m, "SimulationError", PyExc_RuntimeError).attr("__doc__") =
      "A step that failed (and which joint, contact or controller did it), or a simulation that is busy.";
  bind_record(m);
  py::class_<Simulation>(
      m, "Simulation",
      "A run of a scenario in this process: the model, contacts, physics and controller of the server set, called in\n"
      ""
      "the same order, so that the bits are the same. Not for two threads at once; several simulations are.")
      .def(py::init(&Simulation::make), py::arg("scenario"), py::arg("controller") = "scenario",
           "scenario: a file. controller: 'scenario' (the one that it names), None (set_command()), or a Controller.\n"
           ""
           "Raises InputError.")
      .def("step", &Simulation::step, py::arg("steps") = 1,
           "Physics steps of `time_step`. Other threads of Python run meanwhile. Raises SimulationError; what was "
           "reached stays.")
      .def("run", &Simulation::run, py::arg("steps"), py::arg("every") = 1,
           "As step(), and returns a Record with a row every `every` steps.")
      .def("reset", &Simulation::reset, py::arg("state") = py::none(),
           "Step 0 at the scenario's pose, or at a State. Everything with a memory starts afresh, the controller, too.")
      .def("save", &Simulation::save, "A SavedRun. After restore(saved) the run goes on with the same bits.")
      .def("restore", &Simulation::restore, py::arg("saved"),
           "Goes back to where save() was called, here or in another simulation of the scenario (not with a controller "
           "in Python).")
      .def("set_command", &Simulation::set_command, py::arg("command"),
           "A Command, or efforts (n,) [N m or N] with `drive: effort`; acts from the next control step on. For "
           "controller=None.")
      .def(
          "push",
          [](Simulation& s, const std::string& link, const py::object& force, uint64_t steps, const py::object& point) {
            const Vector3d p_LQ = point.is_none() ? Vector3d::Zero() : Vector3d(take_finite(point, "point", 3));
            s.idle().push(link, p_LQ, Vector3d(take_finite(force, "force", 3)), steps);
          },
          py::arg("link"), py::arg("force"), py::arg("steps"), py::arg("point") = py::none(),
          "Pushes a link, an object or 'robot/link' of another robot from the next step on: force (3,) [N], world "
          "axes, at point (3,) [m], link axes. The next\n"
          ""
          "push of this link ends it; steps=0 lets go. Raises InputError.")
      .def_property_readonly("pushes", &Simulation::make_pushes,
                             "What pushed robots and objects over the last step, one dict each: name (of the "
                             "scenario's push or hand; '': push()), link,\n"
                             ""
                             "point (3,) [m], link axes, force (3,) [N], world axes.")
      .def_property_readonly(
          "state", [](Simulation& s) { return s.idle().engine().state(); }, "A copy of the State.")
      .def_property_readonly(
          "observation",
          [](Simulation& s) {
            Trial& trial = s.idle();
            Observation now{{}, std::make_shared<Robot>(trial.controlled())};
            static_cast<SensorSample&>(now.data) = trial.engine().sensors();
            now.data.time = trial.time();
            now.data.step = static_cast<unsigned long long>(trial.step_number());
            return now;
          },
          "The last Observation of all sensors, with the scenario's sensor errors. Sensors are read at control steps: "
          "between them, its readings are those of the last one.")
      .def_property_readonly(
          "command", [](Simulation& s) { return s.idle().command(); }, "The Command of the last control step.")
      .def_property_readonly(
          "efforts", [](Simulation& s) { return Eigen::VectorXd(s.idle().engine().joint_efforts()); },
          "(n,) [N m or N] on the links over the last step: servo, friction, springs, stops.")
      .def_property_readonly(
          "foot_forces",
          [](Simulation& s) {
            const std::vector<double>& forces = s.idle().engine().foot_forces();
            return Eigen::VectorXd(
                Eigen::Map<const Eigen::VectorXd>(forces.data(), static_cast<Eigen::Index>(forces.size())));
          },
          "(feet,) [N] vertical, in the order of the scenario's feet.")
      .def_property_readonly(
          "contact_forces", &Simulation::make_forces,
          "Forces of the last step, one dict per pair of bodies: body_a, body_b; spring, damper, friction, total (6,)\n"
          ""
          "[N m; N] on A about `reference` (3,) [m]; clipped; points, each with position, normal (from B to A), depth "
          "[m],\n"
          ""
          "spring, damper, friction, total (3,) [N], slip (3,) [m/s]. World axes. total = spring + damper + friction.")
      .def_property_readonly("contacts", &Simulation::make_contacts,
                             "What touches in the state now, one dict per pair of bodies: body_a, body_b, friction, "
                             "points (position (3,) [m],\n"
                             ""
                             "normal from B to A (3,), depth [m]). World axes.")
      .def_property_readonly(
          "step_number", [](Simulation& s) { return s.idle().step_number(); }, "Physics steps since step 0.")
      .def_property_readonly(
          "time", [](Simulation& s) { return s.idle().time(); }, "[s] since step 0.")
      .def_property_readonly(
          "time_step", [](const Simulation& s) { return s.scenario().time_step; }, "[s].")
      .def_property_readonly(
          "control_period", [](const Simulation& s) { return s.scenario().control_period; },
          "Steps between two commands.")
      .def_property_readonly(
          "duration", [](const Simulation& s) { return s.scenario().duration; },
          "[s] as the scenario says; 0: until stopped.")
      .def_property_readonly(
          "feet", [](const Simulation& s) { return s.scenario().feet; }, "Names of the feet.")
      .def_property_readonly(
          "state_hash", [](Simulation& s) { return s.idle().engine().state_hash(); },
          "Of the bits of state and memories: as the log of a run in the server set has it.")
      .def_property_readonly("robot", &Simulation::robot, "The Robot of this scenario.")
      .def_property_readonly(
          "controlled_robot", [](Simulation& s) { return std::make_shared<Robot>(s.idle().controlled()); },
          "The ControlledRobot that a controller is told.");
}

}  // namespace hrp::python

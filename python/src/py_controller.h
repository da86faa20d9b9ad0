// SPDX-License-Identifier: BSD-3-Clause
// A controller whose law is a Python object: the same in a process of the server set and within this one.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "controller/client.h"
#include "python/src/arrays.h"

namespace hrp::python {

// What went wrong in a controller, with its name, step and time. `cause`: the exception of Python, if it was one.
struct ControllerError : std::runtime_error {
  explicit ControllerError(const std::string& text, std::shared_ptr<py::error_already_set> given = nullptr)
      : std::runtime_error(text), cause(std::move(given)) {}
  std::shared_ptr<py::error_already_set> cause;
};

// One sample of all sensors, and the robot that it is of.
struct Observation {
  SensorData data;
  std::shared_ptr<const Robot> robot;
};

class PyController : public Controller {
 public:
  // Takes the interpreter's lock where it needs it. `object` has start(robot) and step(observation).
  PyController(const py::object& object, const Robot& robot);
  ~PyController() override;
  PyController(const PyController&) = delete;
  PyController& operator=(const PyController&) = delete;

  void start(const Robot& robot) override;
  JointCommand control(const SensorData& sensors, const Robot& robot) override;
  // Of one that runs: keeps a deep copy of the object's attributes. Of such a copy: one that runs, with these
  // attributes given back to the object.
  std::unique_ptr<Controller> clone() const override;

 private:
  JointCommand ask(const SensorData& sensors);
  std::string make_place(const SensorData& sensors) const;

  py::object object_, memory_;
  std::string name_, drive_;
  std::shared_ptr<const Robot> robot_;
};

// Throws ValueError when the command does not fit the robot: sizes, NaN.
void check_command(const JointCommand& command, const Robot& robot);
// An array of efforts where the scenario's drive takes nothing else, or a Command. Throws ValueError or TypeError.
JointCommand convert_command(const py::object& value, const Robot& robot, const std::string& drive);
// Key `drive` of the scenario that the robot runs in.
std::string find_drive(const Robot& robot);

}  // namespace hrp::python

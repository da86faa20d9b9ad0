// SPDX-License-Identifier: BSD-3-Clause
// The computer of a robot that walks: our controller, as it runs on a robot. It sees sensors, faults and all, and
// gives commands; nothing of the bodies that the generator simulates comes from it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hrp::cases {

// What the controller is told at one instant, joints in the order of the URDF that it was given.
struct BrainInput {
  double time = 0;                                 // [s]
  std::vector<double> position;                    // [rad]
  std::vector<double> orientation{0, 0, 0, 1};     // of the IMU, x y z w
  std::vector<double> rate{0, 0, 0};               // [rad/s]
  std::vector<double> acceleration{0, 0, 9.81};    // [m/s^2]
  std::vector<std::vector<double>> force, torque;  // by foot, left first [N], [N m]
};

class WalkBrain {
 public:
  // `scenario`: YAML with sensors and the section `controller.walk`; force sensors in the order of the feet.
  WalkBrain(const std::string& urdf, const std::string& scenario, const std::vector<std::string>& joints);
  ~WalkBrain();
  // Where the joints are to be [rad]. Throws std::runtime_error: no such walk.
  void control(const BrainInput& input, std::vector<double>* position);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hrp::cases

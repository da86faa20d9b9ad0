// SPDX-License-Identifier: BSD-3-Clause
// MuJoCo as the engine of a dynamics server: proof that the server can be replaced, and a second opinion.
//
// MuJoCo finds and solves its own contacts; the contact set is waited for (that is the protocol) and not used. Its
// contact has no separate damper: the normal force is reported as spring, the damper as zero. Readings are ideal:
// noise, bias, delay and quantisation of the scenario are not applied.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/node/dynamics_loop.h"
#include "common/robot/pushes.h"
#include "common/robot/reference.h"

struct mjModel_;
struct mjData_;
struct mjContact_;

namespace hrp {

class MujocoDynamicsEngine : public DynamicsEngine {
 public:
  // Throws InputError for what MuJoCo or this server cannot do.
  MujocoDynamicsEngine(const RobotDescription& robot, const Scenario& scenario);
  ~MujocoDynamicsEngine() override;

  void reset() override;
  std::string step(const ContactSet& contacts, const JointCommand& command) override;
  const State& state() const override { return state_; }
  unsigned long long state_hash() const override { return calc_state_hash(state_); }
  const Eigen::VectorXd& joint_efforts() const override { return efforts_; }
  const ContactForces& contact_forces() const override { return forces_; }
  const SensorSample& sensors() const override { return sensors_; }
  const std::vector<double>& foot_forces() const override { return foot_forces_; }
  bool push(const PushForces& forces) override {
    pushes_->set_live(forces);
    return true;
  }
  const PushForces& pushes() const override { return pushes_->acting(); }

 private:
  void set_initial_state();
  double find_lowest_sole() const;
  void set_controls();
  void set_pushes();
  void read_state();
  void read_sensors();
  void read_contacts();
  PairForce& find_pair(int body_a, int body_b);
  Vector3d read_sensor(const std::string& name) const;

  RobotDescription robot_;
  Scenario scenario_;
  Reference reference_;  // as of our dynamics: a command that is held gives the robot a kick in every control period
  std::unique_ptr<Pushes> pushes_;
  long step_ = 0;
  mjModel_* model_ = nullptr;
  mjData_* data_ = nullptr;
  std::vector<int> positions_, dofs_;  // addresses of joint i
  std::vector<int> foot_links_;        // in the order of Scenario::feet
  State state_;
  Eigen::VectorXd efforts_;
  ContactForces forces_;
  SensorSample sensors_;
  std::vector<double> foot_forces_;
};

// For DynamicsLoop.
std::unique_ptr<DynamicsEngine> make_mujoco_engine(const RobotDescription& robot, const Scenario& scenario);

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// A run as topics of ROS 2 in an MCAP file: `ros2msg` schemas, CDR, the quality of service as channel metadata. All but
// clock and frames of robot "partner" is in its namespace, /partner.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/mcap/writer.h"
#include "common/messages/cdr.h"
#include "common/multibody/kinematics.h"
#include "common/robot/movers.h"
#include "common/scene/frames.h"
#include "common/scene/ground_contact.h"
#include "hrp_idl/ros_views.h"
#include "servers/console/log_tool/run_reader.h"

namespace hrp {

// As rosbag2 writes a topic.
struct RosTopic {
  std::string name, type;
  bool latched = false;  // transient local: one message for all who come later
  uint16_t channel = 0;
  uint64_t count = 0;
};

// The quality of service as rosbag2's metadata version 5 has it, on many lines.
std::string make_qos_text(bool latched);

class RosTopics final : public RunListener {
 public:
  enum class Frames { kTf, kNone };
  RosTopics(mcap::Writer* writer, Frames frames);
  ~RosTopics() override;
  void on_robot(const RobotDescription& robot, const Scenario& scenario, const LogPlace& place) override;
  void on_step(const RunStep& step, const LogPlace& place) override;
  void on_sensors(size_t robot, const msg::SensorData& sensors, const LogPlace& place) override;
  void on_commands(size_t robot, const msg::JointCommands& commands, const LogPlace& place) override;
  void on_picture(const std::string& topic, const std::string& type, Bytes sample, const LogPlace& place) override;
  const std::vector<RosTopic>& topics() const { return topics_; }

 private:
  struct Robot {
    Robot(const Mover& body, const FrameTree& tree);
    std::string find_topic(const std::string& name) const { return body.name.empty() ? name : "/" + body.name + name; }
    Mover body;
    FrameTree tree;
    Model model;
    Data data;
    sensor_msgs::msg::dds_::JointState_ joint_states, joint_commands;
    std::vector<sensor_msgs::msg::dds_::Imu_> imus;
    std::vector<geometry_msgs::msg::dds_::WrenchStamped_> wrenches;
  };
  // Channels are made with their first message.
  template <typename Message>
  void write(const std::string& topic, const char* type, const Message& message, const LogPlace& place,
             bool latched = false);
  void write_sample(Bytes sample, const LogPlace& place, RosTopic* topic);
  RosTopic& find_topic(const std::string& name, const std::string& type, bool latched);
  void write_frames(const std::vector<NamedTransform>& frames, const LogPlace& place, bool fixed);
  void write_link_force(const Robot& robot, const LinkForce& force, const LogPlace& place);
  void write_forces(const Robot& robot, const ContactForces& forces, const LogPlace& place);

  mcap::Writer& writer_;
  const Frames frames_;
  std::vector<RosTopic> topics_;
  std::map<std::string, uint16_t> schemas_;
  std::vector<char> buffer_;
  std::vector<std::unique_ptr<Robot>> robots_;
  Scenario scenario_;
  GroundPlane ground_;
};

}  // namespace hrp

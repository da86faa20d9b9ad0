// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/log_tool/ros_topics.h"

#include "common/messages/ros_convert.h"
#include "common/base/ros_definitions.h"

namespace hrp {
namespace {

constexpr const char* kForever = "{sec: 9223372036, nsec: 854775807}";

constexpr const char* kJointState = "sensor_msgs/msg/JointState";
constexpr const char* kWrench = "geometry_msgs/msg/WrenchStamped";

std::string find_imu_topic(const msg::ImuSample& sample) { return "/imu/" + sample.name(); }
std::string find_wrench_topic(const msg::WrenchSample& sample) { return "/wrench/" + sample.name(); }

}  // namespace

// Numbers are those of the enumerations of rmw: history keep last, reliability reliable, durability transient local or
// volatile, liveliness automatic.
std::string make_qos_text(bool latched) {
  return std::string("- history: 1\n  depth: ") + (latched ? "1" : "10") + "\n  reliability: 1\n  durability: " +
         (latched ? "1" : "2") + "\n  deadline: " + kForever + "\n  lifespan: " + kForever +
         "\n  liveliness: 1\n  liveliness_lease_duration: " + kForever + "\n  avoid_ros_namespace_conventions: false";
}

RosTopics::RosTopics(mcap::Writer* writer, Frames frames) : writer_(*writer), frames_(frames) {}
RosTopics::~RosTopics() = default;

RosTopic& RosTopics::find_topic(const std::string& name, const std::string& type, bool latched) {
  for (RosTopic& topic : topics_) {
    if (topic.name == name) return topic;
  }
  if (schemas_.count(type) == 0) schemas_[type] = writer_.add_schema(type, "ros2msg", make_ros_schema(type));
  const uint16_t channel =
      writer_.add_channel(name, schemas_[type], "cdr",
                          {{"offered_qos_profiles", make_qos_text(latched)}, {"topic_type_hash", calc_ros_type_hash(type)}});
  topics_.push_back({name, type, latched, channel, 0});
  return topics_.back();
}

template <typename Message>
void RosTopics::write(const std::string& topic, const char* type, const Message& message, const LogPlace& place, bool latched) {
  write_sample(encode(message, &buffer_), place, &find_topic(topic, type, latched));
}

void RosTopics::write_sample(Bytes sample, const LogPlace& place, RosTopic* topic) {
  mcap::Message out;
  out.channel_id = topic->channel;
  out.sequence = place.sequence;
  out.log_time = out.publish_time = place.log_time;
  out.data = sample.data;
  out.size = sample.size;
  writer_.add_message(out);
  ++topic->count;
}

void RosTopics::on_picture(const std::string& topic, const std::string& type, Bytes sample, const LogPlace& place) {
  if (find_ros_definition(type) == nullptr) return;
  write_sample(sample, place, &find_topic(topic.substr(2), type, false));
}

void RosTopics::write_frames(const std::vector<NamedTransform>& frames, const LogPlace& place, bool fixed) {
  tf2_msgs::msg::dds_::TFMessage_ message;
  ros::set(frames, place.time, &message);
  write(fixed ? "/tf_static" : "/tf", "tf2_msgs/msg/TFMessage", message, place, fixed);
}

void RosTopics::on_robot(const RobotDescription& robot, const Scenario& scenario, const LogPlace& place) {
  tree_ = std::make_unique<FrameTree>(robot.tree);
  model_ = std::make_unique<Model>(robot.tree);
  data_ = std::make_unique<Data>(*model_);
  ground_ = make_ground_plane(scenario.ground);
  for (int i = 0; i < robot.tree.num_joints(); ++i) joint_states_.name().push_back(robot.tree.joint(i).name);
  joint_commands_.name() = joint_states_.name();
  for (const ImuSpec& imu : scenario.sensors.imus) imus_.emplace_back().header().frame_id(imu.link);
  for (const WrenchSpec& wrench : scenario.sensors.wrenches) wrenches_.emplace_back().header().frame_id(wrench.link);
  std_msgs::msg::dds_::String_ urdf;
  urdf.data(robot.urdf);
  write("/robot_description", "std_msgs/msg/String", urdf, place, true);
  if (frames_ == Frames::kTf) write_frames(tree_->make_fixed(scenario.sensors), place, true);
}

void RosTopics::on_step(const State& state, const ContactForces& forces, const LogPlace& place) {
  if (frames_ == Frames::kTf) {
    rosgraph_msgs::msg::dds_::Clock_ clock;
    ros::set_time(place.time, &clock.clock());
    write("/clock", "rosgraph_msgs/msg/Clock", clock, place);
    tree_->update_moving(state, &moving_);
    write_frames(moving_, place, false);
  }
  update_kinematics(*model_, state, data_.get());
  write_forces(forces, place);
}

// Forces on a link about its origin in its axes, as readers of a WrenchStamped expect.
void RosTopics::write_forces(const ContactForces& forces, const LogPlace& place) {
  for (const LinkForce& force : sum_link_forces(forces)) {
    const Transform X_WL = get_pose(*data_, force.link);
    geometry_msgs::msg::dds_::WrenchStamped_ message;
    ros::set_time(place.time, &message.header().stamp());
    message.header().frame_id(tree_->get_link(force.link));
    ros::set(Vector3d(X_WL.R.transpose() * force.force), &message.wrench().force());
    const Vector3d moment_L = force.moment + (force.p_WC - X_WL.p).cross(force.force);
    ros::set(Vector3d(X_WL.R.transpose() * moment_L), &message.wrench().torque());
    write("/contact/" + tree_->get_link(force.link), kWrench, message, place);
  }
  if (const auto zmp = calc_ground_zmp(forces, ground_)) {
    geometry_msgs::msg::dds_::PointStamped_ message;
    ros::set_time(place.time, &message.header().stamp());
    message.header().frame_id(tree_->world());
    ros::set(*zmp, &message.point());
    write("/zmp", "geometry_msgs/msg/PointStamped", message, place);
  }
  geometry_msgs::msg::dds_::PolygonStamped_ polygon;
  ros::set_time(place.time, &polygon.header().stamp());
  polygon.header().frame_id(tree_->world());
  for (const Vector3d& p : calc_support_polygon(forces, ground_)) ros::set(p, &polygon.polygon().points().emplace_back());
  write("/support_polygon", "geometry_msgs/msg/PolygonStamped", polygon, place);
}

void RosTopics::on_sensors(const msg::SensorData& sensors, const LogPlace& place) {
  ros::set(sensors, &joint_states_);
  write("/joint_states", kJointState, joint_states_, place);
  for (size_t i = 0; i < std::min(imus_.size(), sensors.imus().size()); ++i) {
    ros::set(sensors.imus()[i], sensors.header().time(), &imus_[i]);
    write(find_imu_topic(sensors.imus()[i]), "sensor_msgs/msg/Imu", imus_[i], place);
  }
  for (size_t i = 0; i < std::min(wrenches_.size(), sensors.wrenches().size()); ++i) {
    ros::set(sensors.wrenches()[i], sensors.header().time(), &wrenches_[i]);
    write(find_wrench_topic(sensors.wrenches()[i]), kWrench, wrenches_[i], place);
  }
}

void RosTopics::on_commands(const msg::JointCommands& commands, const LogPlace& place) {
  ros::set_time(commands.header().time(), &joint_commands_.header().stamp());
  joint_commands_.position() = commands.positions();
  joint_commands_.velocity() = commands.velocities();
  joint_commands_.effort() = commands.efforts();
  write("/joint_commands", kJointState, joint_commands_, place);
}

}  // namespace hrp

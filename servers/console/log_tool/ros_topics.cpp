// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/log_tool/ros_topics.h"

#include "common/base/ros_definitions.h"
#include "common/messages/ros_convert.h"
#include "common/messages/topics.h"

namespace hrp {
namespace {

constexpr const char* kForever = "{sec: 9223372036, nsec: 854775807}";

constexpr const char* kJointState = "sensor_msgs/msg/JointState";
constexpr const char* kWrench = "geometry_msgs/msg/WrenchStamped";

}  // namespace

// Numbers are those of the enumerations of rmw: history keep last, reliability reliable, durability transient local or
// volatile, liveliness automatic.
std::string make_qos_text(bool latched) {
  return std::string("- history: 1\n  depth: ") + (latched ? "1" : "10") +
         "\n  reliability: 1\n  durability: " + (latched ? "1" : "2") + "\n  deadline: " + kForever +
         "\n  lifespan: " + kForever + "\n  liveliness: 1\n  liveliness_lease_duration: " + kForever +
         "\n  avoid_ros_namespace_conventions: false";
}

RosTopics::RosTopics(mcap::Writer* writer, Frames frames) : writer_(*writer), frames_(frames) {}
RosTopics::~RosTopics() = default;

RosTopic& RosTopics::find_topic(const std::string& name, const std::string& type, bool latched) {
  for (RosTopic& topic : topics_) {
    if (topic.name == name) return topic;
  }
  if (schemas_.count(type) == 0) schemas_[type] = writer_.add_schema(type, "ros2msg", make_ros_schema(type));
  const uint16_t channel = writer_.add_channel(
      name, schemas_[type], "cdr",
      {{"offered_qos_profiles", make_qos_text(latched)}, {"topic_type_hash", calc_ros_type_hash(type)}});
  topics_.push_back({name, type, latched, channel, 0});
  return topics_.back();
}

template <typename Message>
void RosTopics::write(const std::string& topic, const char* type, const Message& message, const LogPlace& place,
                      bool latched) {
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
  write_sample(sample, place, &find_topic(topics::find_ros_topic(topic), type, false));
}

void RosTopics::write_frames(const std::vector<NamedTransform>& frames, const LogPlace& place, bool fixed) {
  tf2_msgs::msg::dds_::TFMessage_ message;
  ros::set(frames, place.time, &message);
  write(fixed ? "/tf_static" : "/tf", "tf2_msgs/msg/TFMessage", message, place, fixed);
}

RosTopics::Robot::Robot(const Mover& its_body, const FrameTree& its_tree)
    : body(its_body), tree(its_tree), model(body.robot.tree), data(model) {
  const TreeSpec& links = body.robot.tree;
  for (int i = 0; i < links.num_joints(); ++i) joint_states.name().push_back(links.joint(i).name);
  joint_commands.name() = joint_states.name();
  const SensorsSpec& sensors = body.scenario.sensors;
  for (const ImuSpec& imu : sensors.imus) imus.emplace_back().header().frame_id(tree.find_frame(imu.link));
  for (const WrenchSpec& wrench : sensors.wrenches)
    wrenches.emplace_back().header().frame_id(tree.find_frame(wrench.link));
}

void RosTopics::on_robot(const RobotDescription& robot, const Scenario& scenario, const LogPlace& place) {
  scenario_ = scenario;
  ground_ = make_ground_plane(scenario.ground);
  const std::vector<Mover> bodies = make_robots(robot, scenario);
  const std::vector<FrameTree> trees = make_frame_trees(bodies);
  std::vector<NamedTransform> fixed;
  for (size_t k = 0; k < bodies.size(); ++k) {
    const Robot& each = *robots_.emplace_back(std::make_unique<Robot>(bodies[k], trees[k]));
    const auto frames = each.tree.make_fixed(each.body.scenario.sensors);
    fixed.insert(fixed.end(), frames.begin(), frames.end());
    std_msgs::msg::dds_::String_ urdf;
    urdf.data(each.body.robot.urdf);
    write(each.find_topic("/robot_description"), "std_msgs/msg/String", urdf, place, true);
  }
  if (frames_ == Frames::kTf) write_frames(fixed, place, true);
}

void RosTopics::on_step(const RunStep& step, const LogPlace& place) {
  std::vector<NamedTransform> all, moving;
  for (size_t k = 0; k < robots_.size(); ++k) {
    const State& state = find_robot_state(k, step.state, step.others, scenario_);
    robots_[k]->tree.update_moving(state, &moving);
    all.insert(all.end(), moving.begin(), moving.end());
    update_kinematics(robots_[k]->model, state, &robots_[k]->data);
  }
  if (frames_ == Frames::kTf) {
    rosgraph_msgs::msg::dds_::Clock_ clock;
    ros::set_time(place.time, &clock.clock());
    write("/clock", "rosgraph_msgs/msg/Clock", clock, place);
    write_frames(all, place, false);
  }
  for (const auto& robot : robots_) write_forces(*robot, find_own_forces(step.forces, robot->body), place);
}

// About the link's origin in its axes, as readers of a WrenchStamped expect.
void RosTopics::write_link_force(const Robot& robot, const LinkForce& force, const LogPlace& place) {
  const Transform X_WL = get_pose(robot.data, force.link);
  geometry_msgs::msg::dds_::WrenchStamped_ message;
  ros::set_time(place.time, &message.header().stamp());
  message.header().frame_id(robot.tree.get_link(force.link));
  ros::set(Vector3d(X_WL.R.transpose() * force.force), &message.wrench().force());
  const Vector3d moment_L = force.moment + (force.p_WC - X_WL.p).cross(force.force);
  ros::set(Vector3d(X_WL.R.transpose() * moment_L), &message.wrench().torque());
  write(robot.find_topic("/contact/" + robot.body.robot.tree.links[static_cast<size_t>(force.link)].name), kWrench,
        message, place);
}

void RosTopics::write_forces(const Robot& robot, const ContactForces& forces, const LogPlace& place) {
  for (const LinkForce& force : sum_link_forces(forces)) write_link_force(robot, force, place);
  if (const auto zmp = calc_ground_zmp(forces, ground_)) {
    geometry_msgs::msg::dds_::PointStamped_ message;
    ros::set_time(place.time, &message.header().stamp());
    message.header().frame_id(robot.tree.world());
    ros::set(*zmp, &message.point());
    write(robot.find_topic("/zmp"), "geometry_msgs/msg/PointStamped", message, place);
  }
  geometry_msgs::msg::dds_::PolygonStamped_ polygon;
  ros::set_time(place.time, &polygon.header().stamp());
  polygon.header().frame_id(robot.tree.world());
  for (const Vector3d& p : calc_support_polygon(forces, ground_))
    ros::set(p, &polygon.polygon().points().emplace_back());
  write(robot.find_topic("/support_polygon"), "geometry_msgs/msg/PolygonStamped", polygon, place);
}

void RosTopics::on_sensors(size_t k, const msg::SensorData& sensors, const LogPlace& place) {
  Robot& robot = *robots_[k];
  ros::set(sensors, &robot.joint_states);
  write(robot.find_topic("/joint_states"), kJointState, robot.joint_states, place);
  for (size_t i = 0; i < std::min(robot.imus.size(), sensors.imus().size()); ++i) {
    ros::set(sensors.imus()[i], sensors.header().time(), &robot.imus[i]);
    write(robot.find_topic("/imu/" + sensors.imus()[i].name()), "sensor_msgs/msg/Imu", robot.imus[i], place);
  }
  for (size_t i = 0; i < std::min(robot.wrenches.size(), sensors.wrenches().size()); ++i) {
    ros::set(sensors.wrenches()[i], sensors.header().time(), &robot.wrenches[i]);
    write(robot.find_topic("/wrench/" + sensors.wrenches()[i].name()), kWrench, robot.wrenches[i], place);
  }
}

void RosTopics::on_commands(size_t k, const msg::JointCommands& commands, const LogPlace& place) {
  Robot& robot = *robots_[k];
  sensor_msgs::msg::dds_::JointState_& message = robot.joint_commands;
  ros::set_time(commands.header().time(), &message.header().stamp());
  message.position() = commands.positions();
  message.velocity() = commands.velocities();
  message.effort() = commands.efforts();
  write(robot.find_topic("/joint_commands"), kJointState, message, place);
}

}  // namespace hrp

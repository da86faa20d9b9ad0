// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/ros_definitions.h"

#include <gtest/gtest.h>

namespace hrp {
namespace {

// The expected values stand in the code that ROS 2 Jazzy generates for these messages (type_hash of rosidl).
TEST(RosTypeHash, IsThatOfRos2) {
  EXPECT_EQ(calc_ros_type_hash("std_msgs/msg/String"),
            "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18");
  EXPECT_EQ(calc_ros_type_hash("rosgraph_msgs/msg/Clock"),
            "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564");
  EXPECT_EQ(calc_ros_type_hash("sensor_msgs/msg/JointState"),
            "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e");
  EXPECT_EQ(calc_ros_type_hash("trajectory_msgs/msg/JointTrajectory"),
            "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e");
  EXPECT_EQ(calc_ros_type_hash("std_msgs/msg/Float64MultiArray"),
            "RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f");
  EXPECT_EQ(calc_ros_type_hash("tf2_msgs/msg/TFMessage"),
            "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087");
  EXPECT_EQ(calc_ros_type_hash("sensor_msgs/msg/Image"),
            "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47");
  EXPECT_EQ(calc_ros_type_hash("sensor_msgs/msg/CameraInfo"),
            "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275");
  EXPECT_EQ(calc_ros_type_hash("sensor_msgs/msg/PointCloud2"),
            "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5");
  EXPECT_EQ(calc_ros_type_hash("std_srvs/srv/SetBool_Request"),
            "RIHS01_c62fbb99d94e1b25e8ef9e109f9581956bb1b3361a45a4e5810c36a90d29932e");
  EXPECT_EQ(calc_ros_type_hash("std_srvs/srv/SetBool_Response"),
            "RIHS01_d0814e7f7b4880ab77e9c57426c7aa1562ab69f11eef8e2e968812f9cbd0b059");
}

TEST(RosUserData, IsThatOfTopicsAndServicesOfRos) {
  EXPECT_EQ(make_ros_user_data("std_srvs::srv::dds_::SetBool_Request_"),
            "typehash=RIHS01_c62fbb99d94e1b25e8ef9e109f9581956bb1b3361a45a4e5810c36a90d29932e;");
  EXPECT_EQ(make_ros_user_data("hrp::msg::RobotState"), "");
}

TEST(RosSchema, HasEveryTypeThatIsNeededOnce) {
  const std::string text = make_ros_schema("geometry_msgs/msg/PoseStamped");
  EXPECT_EQ(text.rfind("std_msgs/Header header\nPose pose\n====", 0), 0u);
  for (const char* part : {"MSG: builtin_interfaces/Time\n", "MSG: std_msgs/Header\n", "MSG: geometry_msgs/Pose\n",
                           "MSG: geometry_msgs/Point\n", "MSG: geometry_msgs/Quaternion\n"}) {
    const size_t at = text.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    EXPECT_EQ(text.find(part, at + 1), std::string::npos) << part;
  }
}

TEST(RosDefinition, TellsMessagesListsAndArraysApart) {
  const std::vector<RosField> imu = parse_ros_definition("sensor_msgs/msg/Imu");
  ASSERT_EQ(imu.size(), 7u);
  EXPECT_EQ(imu[0].base, "std_msgs/msg/Header");
  EXPECT_EQ(imu[2].array_size, 9u);
  EXPECT_TRUE(parse_ros_definition("sensor_msgs/msg/JointState")[1].is_sequence);
  EXPECT_THROW(parse_ros_definition("no_msgs/msg/None"), std::runtime_error);
}

}  // namespace
}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/topic_tool/sample_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "common/messages/cdr.h"
#include "hrp_idl/ros_views.h"

namespace hrp {
namespace {

const StructType& get_trajectory() { return *get_schema().find_struct("trajectory_msgs::msg::dds_::JointTrajectory_"); }

template <typename Message>
std::vector<uint8_t> encode_typed(const Message& message) {
  std::vector<char> buffer;
  const Bytes bytes = encode(message, &buffer);
  return {bytes.data, bytes.data + bytes.size};
}

// Fast CDR on the generated types is the other way to the same bytes.
TEST(SampleText, GivesTheBytesOfTheGeneratedType) {
  ::trajectory_msgs::msg::dds_::JointTrajectory_ message;
  message.header().frame_id("world");
  message.joint_names({"hip", "knees"});
  message.points().resize(2);
  message.points()[0].positions({0.5, -1e-3});
  message.points()[0].effort({1.0, 2.0});
  message.points()[1].time_from_start().sec(-3);
  message.points()[1].time_from_start().nanosec(4000000000u);
  EXPECT_EQ(encode_text(get_trajectory(),
                        "{header: {frame_id: world}, joint_names: [hip, knees], points: [{positions: [0.5, -1e-3], "
                        "effort: [1, 2.0]}, "
                        "{time_from_start: {sec: -3, nanosec: 4000000000}}]}"),
            encode_typed(message));
}

TEST(SampleText, TakesJsonAndSeveralLines) {
  ::std_msgs::msg::dds_::Float64MultiArray_ message;
  message.data({1.0, 2.0});
  message.layout().dim().resize(1);
  message.layout().dim()[0].label("joints");
  const StructType& type = *get_schema().find_struct("std_msgs::msg::dds_::Float64MultiArray_");
  EXPECT_EQ(encode_text(type, R"({"data": [1, 2], "layout": {"dim": [{"label": "joints"}]}})"), encode_typed(message));
  EXPECT_EQ(encode_text(type, "layout:\n  dim:\n  - label: joints\ndata:\n- 1\n- 2\n"), encode_typed(message));
}

TEST(SampleText, WithoutFieldsIsAllZeroAndEmpty) {
  EXPECT_EQ(encode_text(get_trajectory(), "{}"), encode_typed(::trajectory_msgs::msg::dds_::JointTrajectory_{}));
  EXPECT_EQ(encode_text(get_trajectory(), ""), encode_typed(::trajectory_msgs::msg::dds_::JointTrajectory_{}));
}

TEST(SampleText, SaysWhereItIsNoMessage) {
  const std::pair<const char*, const char*> cases[] = {
      {"{joint_name: [hip]}",
       "message:1:2: error: 'joint_name' is no field of trajectory_msgs::msg::dds_::JointTrajectory_; is it "
       "'joint_names'?"},
      {"{points: [{positions: [1, two]}]}", "message:1:27: error: points[0].positions[1]: 'two'; expected a number"},
      {"{points: {positions: [1]}}", "points: expected a list"},
      {"{points: [7]}", "points[0]: expected the fields of trajectory_msgs::msg::dds_::JointTrajectoryPoint_"},
      {"{points: [{time_from_start: {sec: 0.5}}]}", "points[0].time_from_start.sec: '0.5'; expected a whole number"},
      {"{points: [{time_from_start: {nanosec: -1}}]}", "'-1'; expected a whole number, 0 or more"},
      {"{joint_names: [[hip]]}", "joint_names[0]: expected a text"},
      {"{points: [", "message:"},
      {"[1, 2]", "expected the fields of"},
  };
  for (const auto& [text, said] : cases) {
    try {
      encode_text(get_trajectory(), text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(said)) << text;
    }
  }
}

}  // namespace
}  // namespace hrp

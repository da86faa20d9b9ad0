// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 1 as its recorder writes them. The writer here shares nothing with the reader.
#include <bzlib.h>
#include <lz4frame.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "common/log/ros_bag.h"
#include "diagnosis/data/recording.h"
#include "tests/catch_complaint.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr uint32_t kEpoch = 1'700'000'000;  // [s]
constexpr const char* kHeader = "====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";

// What ROS 1 serializes: numbers without gaps, lengths before texts and lists.
class Wire1 {
 public:
  template <typename Number>
  Wire1& put(Number value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Wire1& put(const std::string& text) {
    put(static_cast<uint32_t>(text.size()));
    text_ += text;
    return *this;
  }
  Wire1& put(const std::vector<std::string>& list) {
    put(static_cast<uint32_t>(list.size()));
    for (const std::string& text : list) put(text);
    return *this;
  }
  Wire1& put(const std::vector<double>& list) {
    put(static_cast<uint32_t>(list.size()));
    for (const double value : list) put(value);
    return *this;
  }
  Wire1& header(uint32_t seq, double t) { return put(seq).time(t).put(std::string("base")); }
  Wire1& time(double t) {
    return put(kEpoch + static_cast<uint32_t>(t)).put(static_cast<uint32_t>(std::llround(std::fmod(t, 1.0) * 1e9)));
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

template <typename Number>
std::string make_field(const std::string& name, Number value) {
  return Wire1().put(name + "=" + Wire1().put(value).text()).text();
}
std::string make_text_field(const std::string& name, const std::string& value) {
  return Wire1().put(name + "=" + value).text();
}
std::string make_record(const std::string& header, const std::string& data) {
  return Wire1().put(header).put(data).text();
}

std::string pack(const std::string& compression, std::string plain) {
  std::string packed(plain.size() * 2 + 1000, '\0');
  if (compression == "none") return plain;
  if (compression == "lz4") {
    packed.resize(LZ4F_compressFrame(&packed[0], packed.size(), plain.data(), plain.size(), nullptr));
    return packed;
  }
  auto size = static_cast<unsigned>(packed.size());
  BZ2_bzBuffToBuffCompress(&packed[0], &size, &plain[0], static_cast<unsigned>(plain.size()), 9, 0, 0);
  packed.resize(size);
  return packed;
}

class Bag1 {
 public:
  explicit Bag1(std::string compression) : compression_(std::move(compression)) {}
  void add_topic(const std::string& topic, const std::string& type, const std::string& definition) {
    const auto id = static_cast<uint32_t>(connections_.size());
    connections_.push_back(
        make_record(make_field("op", uint8_t{7}) + make_field("conn", id) + make_text_field("topic", topic),
                    make_text_field("topic", topic) + make_text_field("type", type) + make_text_field("md5sum", "*") +
                        make_text_field("message_definition", definition)));
    chunk_ += connections_.back();
  }
  void add(uint32_t topic, double received, const std::string& message) {
    chunk_ += make_record(make_field("op", uint8_t{2}) + make_field("conn", topic) +
                              make_text_field("time", Wire1().time(received).text()),
                          message);
    if (chunk_.size() > 100000) close_chunk();
  }
  // `closed`: with the index at the end, as when the recorder ended in peace.
  std::string write(bool closed = true) {
    close_chunk();
    const auto make_start = [&](uint64_t index) {
      const std::string header = make_field("op", uint8_t{3}) + make_field("index_pos", index) +
                                 make_field("conn_count", uint32_t{1}) + make_field("chunk_count", uint32_t{1});
      return "#ROSBAG V2.0\n" + make_record(header, std::string(4096 - header.size(), ' '));
    };
    std::string text = make_start(0) + chunks_;
    if (!closed) return text;
    text = make_start(text.size()) + chunks_;
    for (const std::string& connection : connections_) text += connection;
    return text + make_record(make_field("op", uint8_t{6}), "");
  }

 private:
  void close_chunk() {
    if (chunk_.empty()) return;
    chunks_ += make_record(make_field("op", uint8_t{5}) + make_text_field("compression", compression_) +
                               make_field("size", static_cast<uint32_t>(chunk_.size())),
                           pack(compression_, chunk_));
    chunks_ += make_record(make_field("op", uint8_t{4}), "an index of the chunk");
    chunk_.clear();
  }
  std::string compression_, chunk_, chunks_;
  std::vector<std::string> connections_;
};

double shoulder_at(double t) { return 0.5 * std::sin(2.0 * t); }

// 5 s of joint states at 200 Hz, and commands at 100 Hz without names.
Bag1 make_motion(const std::string& compression) {
  Bag1 bag(compression);
  bag.add_topic(
      "/joint_states", "sensor_msgs/JointState",
      std::string("Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n") +
          kHeader);
  bag.add_topic("/commands", "std_msgs/Float64MultiArray",
                "MultiArrayLayout layout\nfloat64[] data\n====\nMSG: std_msgs/MultiArrayLayout\nMultiArrayDimension[] "
                "dim\nuint32 data_offset\n"
                "====\nMSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n");
  for (uint32_t k = 0; k < 1000; ++k) {
    const double t = 0.005 * k;
    bag.add(0, t + 1e-4,
            Wire1()
                .header(k, t)
                .put(std::vector<std::string>{"elbow", "shoulder"})
                .put(std::vector<double>{0.1, shoulder_at(t)})
                .put(std::vector<double>{0.0, std::cos(2.0 * t)})
                .put(std::vector<double>{1.0, 2.0 + t})
                .text());
    if (k % 2 == 0)
      bag.add(1, t + 5e-5,
              Wire1().put(uint32_t{0}).put(uint32_t{0}).put(std::vector<double>{shoulder_at(t), 0.1}).text());
  }
  return bag;
}

Experiment load(const std::string& name, const std::string& bag) {
  const fs::path folder = fs::temp_directory_path() / ("hrp_ros1_bag_test_" + name);
  fs::create_directories(folder);
  std::ofstream(folder / "motion.bag", std::ios::binary) << bag;
  std::ofstream(folder / "robot.urdf") << kArm;
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 200, kd: 10}}\nrecordings: [{file: motion.bag, role: "
         "train}]\n"
         "topics:\n  joint_states: /joint_states\n  joint_commands: {topic: /commands, joints: [shoulder, elbow]}\n";
  return load_experiment((folder / "experiment.yaml").string());
}

void expect_motion(const Recording& r, size_t rows) {
  ASSERT_EQ(r.size(), rows);
  for (size_t k = 0; k < r.size(); k += 37) {
    const double t = 0.005 * static_cast<double>(k);
    EXPECT_NEAR(r.time[k] - r.time[0], t, 1e-6);  // stamps are in nanoseconds, times of a bag in microseconds
    EXPECT_DOUBLE_EQ(r.joints[kShoulder].signal[0][k], shoulder_at(t));
    EXPECT_DOUBLE_EQ(r.joints[kShoulder].signal[2][k], 2.0 + t);
    EXPECT_DOUBLE_EQ(r.joints[kElbow].signal[0][k], 0.1);
    EXPECT_DOUBLE_EQ(r.joints[kShoulder].command[k], shoulder_at(0.01 * std::floor(static_cast<double>(k) / 2.0)));
  }
}

class Ros1Compression : public testing::TestWithParam<const char*> {};

TEST_P(Ros1Compression, GivesEachJointItsOwnReadingsAndTheCommandThatHeld) {
  const Experiment e = load(GetParam(), make_motion(GetParam()).write());
  ASSERT_EQ(e.recordings.size(), 1u);
  expect_motion(e.recordings[0], 1000);
}
INSTANTIATE_TEST_SUITE_P(All, Ros1Compression, testing::Values("none", "bz2", "lz4"));

TEST(Ros1Bag, OneThatWasNotClosedIsReadAndSaidToBeCutShort) {
  const Experiment e = load("unclosed", make_motion("lz4").write(false));
  expect_motion(e.recordings.at(0), 1000);
  EXPECT_THAT(testing::PrintToString(e.warnings), HasSubstr("it was not closed"));
}

TEST(Ros1Bag, AfterACutInAChunkTheChunksBeforeItAreThere) {
  std::string bag = make_motion("none").write(false);
  bag.resize(bag.size() - 500);
  const Experiment e = load("cut", bag);
  EXPECT_GT(e.recordings.at(0).size(), 500u);
  EXPECT_THAT(testing::PrintToString(e.warnings), HasSubstr("ends too early"));
}

TEST(Ros1Bag, WhatIsNoBagIsRefusedByName) {
  for (const auto& wrong :
       std::vector<std::pair<std::string, std::string>>{{"", "#ROSBAG V2.0"},
                                                        {"#ROSBAG V1.2\n", "#ROSBAG V2.0"},
                                                        {"#ROSBAG V2.0\n", "first record"},
                                                        {"#ROSBAG V2.0\n\xff\xff\xff\xff", "first record"}}) {
    const std::string said = catch_complaint([&] { load("wrong", wrong.first); });
    EXPECT_THAT(said, HasSubstr("motion.bag"));
    EXPECT_THAT(said, HasSubstr(wrong.second));
  }
}

}  // namespace
}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
// One number of a message, found by a path that people and pages write: "hrp/robot_state:positions[L_KNEE]".
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/messages/reflection/schema.h"

namespace hrp {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// Splits "topic:path". Throws InputError without a colon.
struct SignalName {
  std::string topic;
  std::string path;
};
SignalName split_signal(const std::string& text);

// Path as FieldPath has it ("pairs[0].total.force.z"), and beside numbers also names in the brackets: of a joint where
// a list has one number per joint, else of the elements that have it as their `name` or `name_a` (all of them: the
// values are added, so "pairs[L_FOOT].total.force.z" is the whole vertical force on L_FOOT). Of contact forces also
// "zmp.x", "zmp.y" [m], "partner/zmp.x" of robot "partner": the zero-moment point of all forces from the ground, where
// it crosses the ground plane z = `height`.
class Signal {
 public:
  // Throws InputError when the type has no such field or no joint has the name.
  Signal(const StructType& type, const std::string& path, const std::vector<std::string>& joints, double height);
  // kNoValue when it is not there in this sample. Throws DecodeError.
  double find(Bytes sample) const;
  const std::string& unit() const { return unit_; }

  struct Step {
    std::string field;
    bool has_index = false;
    size_t index = 0;
    std::string name;  // of the element; empty: by index
  };

 private:
  void resolve(const std::vector<std::string>& joints);
  const StructType& type_;
  std::string path_;
  std::vector<Step> steps_;
  std::string unit_;
  int zmp_axis_ = -1;
  std::string zmp_robot_;
  double height_ = 0.0;
};

// Simulated time [s] of a sample: its header's (ours or that of ROS 2), else its own field `time`; nothing when the
// type has none of these.
class SampleTime {
 public:
  explicit SampleTime(const StructType& type);
  bool known() const { return kind_ != Kind::kNone; }
  double find(Bytes sample) const;
  bool has_header() const { return kind_ == Kind::kHeader; }

 private:
  enum class Kind { kNone, kHeader, kStamp, kField };
  const StructType* type_;
  Kind kind_ = Kind::kNone;
};

// The first field of all messages of the loop.
struct HeaderWords {
  uint64_t epoch = 0;
  uint64_t step = 0;
  double time = 0.0;  // [s]
};
// All zero when the sample is too short.
HeaderWords read_header(Bytes sample);
// [s] of the std_msgs/Header that a message of ROS 2 begins with; 0 when the sample is too short.
double read_stamp(Bytes sample);

}  // namespace hrp

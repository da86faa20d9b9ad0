// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/signal.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/diagnostics.h"
#include "common/messages/reflection/sample.h"
#include "common/robot/signals.h"
#include "hrp_idl/dynamics.h"

namespace hrp {
namespace {

std::vector<Signal::Step> split_path(const std::string& path) {
  std::vector<Signal::Step> steps;
  for (size_t at = 0; at < path.size();) {
    // Names in brackets may have dots.
    const size_t name_end = path.find_first_of(".[", at);
    Signal::Step step;
    step.field = path.substr(at, name_end == std::string::npos ? name_end : name_end - at);
    at = name_end == std::string::npos ? path.size() : name_end;
    if (at < path.size() && path[at] == '[') {
      const size_t close = path.find(']', at);
      if (close == std::string::npos) refuse_input({"", path}, "a '[' without a ']'");
      step.has_index = true;
      step.name = path.substr(at + 1, close - at - 1);
      at = close + 1;
      const bool number =
          !step.name.empty() && step.name.size() < 7 && step.name.find_first_not_of("0123456789") == std::string::npos;
      if (number) step.index = std::stoul(std::exchange(step.name, ""));
    }
    if (at < path.size() && path[at++] != '.') refuse_input({"", path}, "expected a '.' behind ']'");
    steps.push_back(step);
  }
  if (steps.empty()) refuse_input({"", path}, "is empty");
  return steps;
}

// Walks a sample and adds up what the path leads to.
class Finder final : public SampleVisitor {
 public:
  explicit Finder(const std::vector<Signal::Step>& steps) : steps_(steps) {}
  double value() const { return found_ ? sum_ : kNoValue; }

  void begin_struct(const StructType&) override {
    const int at = enter();
    const bool by_name = at > 0 && in_list() && !steps_[static_cast<size_t>(at) - 1].name.empty();
    levels_.push_back({at, false, 0, by_name ? &steps_[static_cast<size_t>(at) - 1].name : nullptr});
  }
  void end_struct() override { levels_.pop_back(); }
  void begin_field(const Field& field) override {
    const Level& level = levels_.back();
    is_name_ = level.wanted && (field.name == "name" || field.name == "name_a");
    const bool follows = level.at >= 0 && !level.wanted && static_cast<size_t>(level.at) < steps_.size() &&
                         steps_[static_cast<size_t>(level.at)].field == field.name;
    next_ = follows ? level.at : -1;
    if (follows && !field.type.is_list()) ++next_;
  }
  void begin_list(const FieldType&, size_t) override { levels_.push_back({next_, true, 0, nullptr}); }
  void end_list() override { levels_.pop_back(); }
  void on_bool(bool value) override { take(value ? 1.0 : 0.0); }
  void on_signed(int64_t value) override { take(static_cast<double>(value)); }
  void on_unsigned(uint64_t value) override { take(static_cast<double>(value)); }
  void on_float(double value) override { take(value); }
  void on_enum(const EnumType&, uint32_t value) override { take(value); }
  void on_string(const std::string& value) override {
    enter();
    // Names stand before what they name: from here on the element counts or does not.
    if (!is_name_) return;
    Level& level = levels_.back();
    if (level.wanted && *level.wanted == value) level.wanted = nullptr;
  }

 private:
  struct Level {
    int at = -1;  // steps that lead here; -1: the path does not
    bool list = false;
    size_t element = 0;                   // of a list: the next one
    const std::string* wanted = nullptr;  // name that this struct must have first
  };

  bool in_list() const { return !levels_.empty() && levels_.back().list; }

  // Steps that lead to the value that comes now, -1 when the path does not.
  int enter() {
    if (levels_.empty()) return 0;
    Level& level = levels_.back();
    if (!level.list) return next_;
    const size_t element = level.element++;
    if (level.at < 0) return -1;
    const Signal::Step& step = steps_[static_cast<size_t>(level.at)];
    const bool fits = step.has_index && (!step.name.empty() || step.index == element);
    return fits ? level.at + 1 : -1;
  }

  void take(double value) {
    if (enter() != static_cast<int>(steps_.size())) return;
    sum_ += value;
    found_ = true;
  }

  const std::vector<Signal::Step>& steps_;
  std::vector<Level> levels_;
  int next_ = -1;
  bool is_name_ = false;
  bool found_ = false;
  double sum_ = 0.0;
};

// Whether the ground or an obstacle presses on this robot: "" is the first one.
bool is_from_world(const msg::PairForce& pair, const std::string& robot) {
  if (pair.body_b() >= 0) return false;
  return robot.empty() ? !is_object(pair.body_a()) : pair.name_a().rfind(robot + "/", 0) == 0;
}

// [m] of the points that obstacles touch, weighed by the sizes of their forces.
double find_mean_height(const msg::ContactForces& forces, const std::string& robot) {
  double sum = 0, weight = 0;
  for (const msg::PairForce& pair : forces.pairs()) {
    if (!is_from_world(pair, robot)) continue;
    for (const msg::PointForce& point : pair.points()) {
      const double size = std::hypot(point.total().x(), point.total().y(), point.total().z());
      sum += size * point.p_WC().z();
      weight += size;
    }
  }
  return weight > 0 ? sum / weight : 0;
}

// Where the line of action of the ground's forces crosses z = height: the moment there has no horizontal part. Where
// there is no plane (NaN), obstacles are the ground (common/scene/ground_contact.h).
double find_zmp(Bytes sample, const std::string& robot, int axis, double height) {
  msg::ContactForces forces;
  decode(sample, &forces);
  const bool plane = !std::isnan(height);
  if (!plane) height = find_mean_height(forces, robot);
  double fx = 0, fy = 0, fz = 0, mx = 0, my = 0;
  for (const msg::PairForce& pair : forces.pairs()) {
    if (!is_from_world(pair, robot) || (plane && pair.body_b() != kGround)) continue;
    const auto& f = pair.total().force();
    const auto& m = pair.total().moment();
    const auto& r = pair.reference();
    fx += f.x();
    fy += f.y();
    fz += f.z();
    mx += m.x() + r.y() * f.z() - (r.z() - height) * f.y();
    my += m.y() + (r.z() - height) * f.x() - r.x() * f.z();
  }
  // Below one newton there is no contact to speak of.
  if (fz < 1.0) return kNoValue;
  return axis == 0 ? -my / fz : mx / fz;
}

}  // namespace

SignalName split_signal(const std::string& text) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) refuse_input({"", text}, "expected topic:path");
  return {text.substr(0, colon), text.substr(colon + 1)};
}

Signal::Signal(const StructType& type, const std::string& path, const std::vector<std::string>& joints, double height)
    : type_(type), path_(path), height_(height) {
  const size_t slash = path.find('/');
  const std::string zmp = slash == std::string::npos ? path : path.substr(slash + 1);
  if (type.name == "hrp::msg::ContactForces" && (zmp == "zmp.x" || zmp == "zmp.y")) {
    zmp_axis_ = zmp == "zmp.x" ? 0 : 1;
    if (slash != std::string::npos) zmp_robot_ = path.substr(0, slash);
    unit_ = "m";
    return;
  }
  steps_ = split_path(path);
  resolve(joints);
}

void Signal::resolve(const std::vector<std::string>& joints) {
  const StructType* structure = &type_;
  for (size_t i = 0; i < steps_.size(); ++i) {
    Step& step = steps_[i];
    const Field* field = nullptr;
    std::vector<std::string> names;
    for (const Field& each : structure ? structure->fields : std::vector<Field>{}) names.push_back(each.name);
    for (size_t k = 0; k < names.size(); ++k) {
      if (names[k] == step.field) field = &structure->fields[k];
    }
    if (!field)
      refuse_input({"", path_}, "there is no '" + step.field + "'; nearest: '" + find_nearest(step.field, names) + "'");
    if (field->type.is_list() != step.has_index)
      refuse_input({"", path_}, "'" + step.field + "' needs " + (step.has_index ? "no" : "an") + " index");
    structure = field->type.structure;
    if (!structure && !step.name.empty()) {
      const auto found = std::find(joints.begin(), joints.end(), step.name);
      if (found == joints.end())
        refuse_input({"", path_}, "no joint '" + step.name + "'; nearest: '" + find_nearest(step.name, joints) + "'");
      step.index = static_cast<size_t>(found - joints.begin());
      step.name.clear();
    }
    unit_ = field->unit;
    if (i + 1 == steps_.size() && (structure || field->type.kind == ValueKind::kString))
      refuse_input({"", path_}, "is not a number");
  }
}

double Signal::find(Bytes sample) const {
  if (zmp_axis_ >= 0) return find_zmp(sample, zmp_robot_, zmp_axis_, height_);
  Finder finder(steps_);
  visit_sample(type_, sample, &finder);
  // A foot in the air is in no pair, and the force on it is zero.
  const bool in_the_air = std::isnan(finder.value()) && steps_[0].field == "pairs" && !steps_[0].name.empty();
  return in_the_air ? 0.0 : finder.value();
}

SampleTime::SampleTime(const StructType& type) : type_(&type) {
  if (type.fields.empty()) return;
  const StructType* first = type.fields[0].type.structure;
  if (first && first->name == "hrp::msg::Header") kind_ = Kind::kHeader;
  if (first && first->name == "std_msgs::msg::dds_::Header_") kind_ = Kind::kStamp;
  for (const Field& field : type.fields) {
    if (kind_ == Kind::kNone && field.name == "time") kind_ = Kind::kField;
  }
}

double SampleTime::find(Bytes sample) const {
  if (kind_ == Kind::kHeader) return read_header(sample).time;
  if (kind_ == Kind::kStamp) return read_stamp(sample);
  return find_number(*type_, sample, FieldPath(*type_, "time")).value_or(kNoValue);
}

HeaderWords read_header(Bytes sample) {
  HeaderWords header;
  constexpr size_t kEncapsulation = 4;
  if (sample.size < kEncapsulation + 24) return header;
  std::memcpy(&header.epoch, sample.data + kEncapsulation, 8);
  std::memcpy(&header.step, sample.data + kEncapsulation + 8, 8);
  std::memcpy(&header.time, sample.data + kEncapsulation + 16, 8);
  return header;
}

double read_stamp(Bytes sample) {
  constexpr size_t kEncapsulation = 4;
  int32_t sec = 0;
  uint32_t nanosec = 0;
  if (sample.size < kEncapsulation + 8) return 0.0;
  std::memcpy(&sec, sample.data + kEncapsulation, 4);
  std::memcpy(&nanosec, sample.data + kEncapsulation + 4, 4);
  return sec + 1e-9 * nanosec;
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/link_sensors.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/base/suggest.h"
#include "common/effects/effect_target.h"
#include "common/robot/link_sensor_keys.h"
#include "common/spatial/gravity.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {
namespace {

std::vector<std::string> list_joints(const Experiment& e) {
  std::vector<std::string> names;
  for (int j = 0; j < e.num_joints(); ++j) names.push_back(e.robot.tree.joint(j).name);
  return names;
}

bool has_all(const Recording& r, const std::string& name, const std::string& parts) {
  for (char part : parts) {
    if (!r.has(name + "/" + part)) return false;
  }
  return true;
}

class Finder {
 public:
  explicit Finder(const Experiment& e) : e_(e), joints_(list_joints(e)) {}

  LinkSensors find() {
    check_columns();
    const LinkSensorKeys keys = parse_link_sensor_keys(e_.scenario.text, e_.path);
    check_declared(keys.joint_torque, "joint_torque", "effort");
    check_declared(keys.link_encoder, "link_encoder", "position");
    for (int j = 0; j < e_.num_joints(); ++j) add_joint(j);
    for (const WrenchSpec& wrench : e_.scenario.sensors.wrenches) add_wrench(wrench);
    for (const ImuSpec& imu : e_.scenario.sensors.imus) add_imu(imu);
    return std::move(out_);
  }

 private:
  // Throws if a column names a joint that the robot does not have.
  void check_columns() const {
    for (const Recording& r : e_.recordings) {
      for (const auto& column : r.other) {
        if (column.first.rfind(kLinkSide, 0) != 0) continue;
        const std::string joint =
            column.first.substr(std::strlen(kLinkSide), column.first.rfind('/') - std::strlen(kLinkSide));
        if (has(joints_, joint)) continue;
        refuse_input(r.find_place(column.first), "the robot has no joint '" + joint + "'" + suggest(joint, joints_));
      }
    }
  }

  void check_declared(const std::vector<DeclaredJoint>& list, const std::string& key, const char* quantity) const {
    for (const DeclaredJoint& d : list) {
      if (!has(joints_, d.joint))
        refuse_input({e_.path, "sensors." + key, d.line, d.column},
                     "the robot has no joint '" + d.joint + "'" + suggest(d.joint, joints_));
      for (const Recording& r : e_.recordings) {
        const std::string column = kLinkSide + d.joint + "/" + quantity;
        if (!r.has(column))
          refuse_input(r.find_place(column),
                       "is missing: sensors." + key + " of the experiment names joint '" + d.joint + "'");
      }
    }
  }

  template <typename Has>
  bool in_all(const std::string& name, Has has) {
    const long there = std::count_if(e_.recordings.begin(), e_.recordings.end(), has);
    if (there > 0 && there < static_cast<long>(e_.recordings.size()))
      out_.notes.push_back(name + " is not in every recording, so it is compared with nothing");
    return there == static_cast<long>(e_.recordings.size());
  }

  void add_joint(int j) {
    const std::string base = kLinkSide + joints_[static_cast<size_t>(j)], effort = base + "/effort",
                      position = base + "/position";
    if (in_all(effort, [&](const Recording& r) { return r.has(effort); })) {
      LinkSensor sensor;
      sensor.kind = LinkSensorKind::kTorque;
      sensor.name = effort;
      sensor.joint = j;
      sensor.link = j + 1;
      out_.sensors.push_back(sensor);
    }
    if (!in_all(position, [&](const Recording& r) { return r.has(position); })) return;
    if (repeats_encoder(j, position))
      out_.notes.push_back(position + " repeats the joint's encoder: no second encoder");
    else
      out_.link_encoders.push_back(j);
  }

  // True if the two positions are identical: a driver may publish one encoder twice.
  bool repeats_encoder(int j, const std::string& position) const {
    for (const Recording& r : e_.recordings) {
      const std::vector<double>&a = r.other.at(position), &b = r.joints[static_cast<size_t>(j)].signal[0];
      for (size_t k = 0; k < a.size() && k < b.size(); ++k) {
        if (std::isfinite(a[k]) && std::isfinite(b[k]) && a[k] != b[k]) return false;
      }
    }
    return true;
  }

  bool set_frame(const std::string& link, LinkSensor* sensor) const {
    sensor->frame = e_.robot.tree.find_frame(link);
    if (sensor->frame < 0) return false;
    sensor->link = e_.robot.tree.frames[static_cast<size_t>(sensor->frame)].link;
    sensor->whole = e_.robot.tree.links[static_cast<size_t>(sensor->link)].name == link;
    return true;
  }

  void add_wrench(const WrenchSpec& spec) {
    LinkSensor sensor;
    sensor.kind = LinkSensorKind::kWrench;
    sensor.name = "/wrench/" + spec.name;
    if (!set_frame(spec.link, &sensor)) return;
    const auto axes = e_.keys.wrench_frame.find(spec.name);
    sensor.world = axes != e_.keys.wrench_frame.end() && axes->second == "world";
    const bool there = in_all(sensor.name, [&](const Recording& r) {
      return has_all(r, sensor.name + "/force", "xyz") && has_all(r, sensor.name + "/torque", "xyz");
    });
    if (!there) return;
    if (sensor.link == 0)
      out_.notes.push_back(sensor.name + " is on a link that does not move, so it is compared with nothing");
    else if (!sensor.whole && !is_last(e_.robot.tree, sensor.link))
      out_.notes.push_back(sensor.name + " sits within link " +
                           e_.robot.tree.links[static_cast<size_t>(sensor.link)].name +
                           ", which carries other joints; name the link behind one of its joints");
    else
      out_.sensors.push_back(sensor);
  }

  void add_imu(const ImuSpec& spec) {
    LinkSensor sensor;
    sensor.kind = LinkSensorKind::kImu;
    sensor.name = "/imu/" + spec.name;
    sensor.p_FS = spec.p_LS;
    if (!set_frame(spec.link, &sensor)) return;
    const bool there = in_all(sensor.name, [&](const Recording& r) {
      return has_all(r, sensor.name + "/angular_velocity", "xyz") &&
             has_all(r, sensor.name + "/linear_acceleration", "xyz");
    });
    if (there) out_.sensors.push_back(sensor);
    if (!there && measures_some(sensor.name))
      out_.notes.push_back(sensor.name + " is compared only with three rates and three accelerations");
  }

  // Of an IMU: rates or accelerations of some axes, in no recording all of them.
  bool measures_some(const std::string& imu) const {
    bool some = false;
    for (const Recording& r : e_.recordings) {
      bool all = true;
      for (const char* quantity : {"/angular_velocity", "/linear_acceleration"}) {
        all = all && has_all(r, imu + quantity, "xyz");
        for (char axis : {'x', 'y', 'z'}) some = some || r.has(imu + quantity + "/" + axis);
      }
      if (all) return false;
    }
    return some;
  }

  const Experiment& e_;
  const std::vector<std::string> joints_;
  LinkSensors out_;
};

}  // namespace

bool LinkSensors::has_torque(int joint) const {
  return std::any_of(sensors.begin(), sensors.end(), [&](const LinkSensor& s) { return s.joint == joint; });
}

bool LinkSensors::has_encoder(int joint) const { return has(link_encoders, joint); }

LinkSensors find_link_sensors(const Experiment& e) {
  if (e.scenario.floating_base || e.num_joints() == 0) return {};
  return Finder(e).find();
}

LinkReadings make_link_readings(const Experiment& e, const LinkSensors& sensors, const std::vector<Effect>& known) {
  NominalRobot nominal = make_nominal(e);
  nominal.force_W.resize(nominal.tree.links.size(), Vector3d::Zero());
  for (const Effect& effect : known) {
    if (effect.place.kind != PlaceKind::kLink) continue;
    const auto link = static_cast<size_t>(effect.place.index);
    EffectTarget target;
    target.link = {&nominal.tree.links[link].inertia};
    target.force_W = &nominal.force_W[link];
    get_effect(effect.id).apply(effect.p.data(), target);
  }
  return LinkReadings(nominal.tree, e.scenario.gravity_W, nominal.force_W, sensors.sensors);
}

namespace {

std::vector<std::string> list_columns(const LinkSensor& sensor, const ReadingGroup& group) {
  if (sensor.kind == LinkSensorKind::kTorque) return {group.name};
  return {group.name + "/x", group.name + "/y", group.name + "/z"};
}

void read_motion(const Experiment& e, const TorqueData& motion, const TorqueRecording& in, const LinkSensors& sensors,
                 const std::vector<Effect>& known, LinkRecording* out) {
  out->q = in.q;
  out->v = in.v;
  out->a = in.a;
  for (const Effect& effect : known) {
    if (get_effect(effect.id).felt_elsewhere) out->q.col(effect.place.index).array() -= effect.p[0];
  }
  for (int j : sensors.link_encoders) {
    out->q.col(j) = read_link_angle(e, j, in, motion.cutoff);
    out->v.col(j) = differentiate(out->q.col(j), in.step);
    out->a.col(j) = differentiate(out->v.col(j), in.step);
  }
}

// Adds a point mass that hung on a link in this recording.
void add_load(const Experiment& e, const LoadSpec& load, const LinkReadings& predict, long row,
              Eigen::MatrixXd* predicted) {
  const int link = e.robot.tree.find_link(load.link);
  if (link > 0) predicted->row(row) += load.mass * predict.calc_load_columns({link, load.p_LC}).col(0).transpose();
}

}  // namespace

LinkData make_link_data(const Experiment& e, const TorqueData& motion, const LinkSensors& sensors,
                        const std::vector<Effect>& known, LinkReadings* predict) {
  LinkData data;
  data.experiment = &e;
  data.cutoff = motion.cutoff;
  for (const TorqueRecording& in : motion.recordings) {
    if (has(motion.frozen, in.index)) continue;
    const Recording& r = e.recordings[in.index];
    if (!r.spec.pushes.empty()) continue;  // forces at other points than a link's centre of mass are not predicted here
    LinkRecording out;
    out.index = in.index;
    out.train = in.train;
    out.step = in.step;
    out.stride = in.stride;
    out.trim = in.trim;
    read_motion(e, motion, in, sensors, known, &out);
    const long rows = in.q.rows();
    out.predicted.resize(rows, predict->size());
    out.read.setZero(rows, predict->size());  // 0 for sensors that are only predicted
    for (const ReadingGroup& group : predict->groups()) {
      const std::vector<std::string> columns = list_columns(predict->sensors()[group.sensor], group);
      for (size_t i = 0; i < columns.size() && r.has(columns[i]); ++i)
        out.read.col(group.first + static_cast<long>(i)) =
            low_pass(resample(r.time, r.other.at(columns[i]), in.begin, in.step, rows), in.step, motion.cutoff);
    }
    for (long k = 0; k < rows; ++k) {
      predict->move(out.q.row(k), out.v.row(k), out.a.row(k));
      out.predicted.row(k) = predict->calc();
      for (const LoadSpec& load : r.spec.loads) add_load(e, load, *predict, k, &out.predicted);
    }
    data.recordings.push_back(std::move(out));
  }
  return data;
}

namespace {

// Relation of a reading to its prediction over all recordings: least-squares factor and correlation.
struct Ratio {
  double factor = 1.0, correlation = 0.0;
};

Ratio find_ratio(const LinkData& data, const ReadingGroup& group) {
  double pp = 0.0, pr = 0.0, rr = 0.0;
  for (const LinkRecording& r : data.recordings) {
    const auto p = r.predicted.middleCols(group.first, group.size), y = r.read.middleCols(group.first, group.size);
    pp += p.squaredNorm();
    pr += p.cwiseProduct(y).sum();
    rr += y.squaredNorm();
  }
  if (pp <= 0.0 || rr <= 0.0) return {};
  return {pr / pp, pr / std::sqrt(pp * rr)};
}

}  // namespace

void check_units(const LinkData& data, const LinkReadings& predict) {
  struct Known {
    const char* unit;
    double factor;
    const char* words;
  };
  static const Known known[] = {
      {"rad/s", kDegrees, "57.3 times the predicted rate: these are degrees, expected rad/s"},
      {"m/s^2", 1.0 / kGravity, "a 9.81th of the predicted one: these are multiples of g, expected m/s^2"},
      {"m/s^2", -1.0, "-1 times the predicted one: expected specific force, which points up at rest"},
      {"N m", 1000.0, "1000 times the predicted torque: these are mN m, expected N m"},
      {"N m", -1.0,
       "-1 times the predicted torque: expected the drive's sign of a joint, and of a wrench what the link exerts on "
       "its parent"},
      {"N", -1.0,
       "-1 times the predicted force: expected what the link exerts on its parent (a hanging load reads downwards)"},
      {"N", 1.0 / kGravity, "a 9.81th of the predicted force: these are kilograms, expected N"}};
  for (const ReadingGroup& group : predict.groups()) {
    const Ratio ratio = find_ratio(data, group);
    for (const Known& k : known) {
      if (group.unit != k.unit || std::abs(ratio.factor / k.factor - 1.0) > kDetail) continue;
      if (std::abs(ratio.correlation) < kNearlyAll) continue;
      const Recording& r = data.experiment->recordings[data.recordings[0].index];
      InputPlace place = r.find_place(group.size == 1 ? group.name : group.name + "/x");
      place.field = group.name;
      refuse_input(place, std::string("reads ") + k.words);
    }
  }
}

}  // namespace hrp::diagnosis

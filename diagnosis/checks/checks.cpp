// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/checks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/checks/motion.h"
#include "diagnosis/checks/samples.h"
#include "diagnosis/data/held_out.h"
#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/velocity_log.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < std::min(kMostNamed, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > kMostNamed ? text + " and " + std::to_string(names.size() - kMostNamed) + " more" : text;
}

// Joins warnings that differ by a recording or a joint only: the first one, and their number.
void remark_warnings(const Experiment& e, Json* remarks) {
  struct Group {
    std::string text;
    int count = 0;
  };
  std::vector<std::pair<std::string, Group>> groups;
  for (const std::string& warning : e.warnings) {
    std::string key = warning;
    const auto blank = [&](const std::string& name) {
      const size_t at = name.empty() ? std::string::npos : key.find(name);
      if (at != std::string::npos) key.replace(at, name.size(), "*");
    };
    for (const RecordingSpec& spec : e.keys.recordings) blank(spec.name + ":");
    for (int j = 0; j < e.num_joints(); ++j) blank("/" + e.robot.tree.joint(j).name + "/");
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == key; });
    if (same == groups.end())
      groups.push_back({key, {warning, 1}});
    else
      ++same->second.count;
  }
  for (const auto& [key, group] : groups)
    remarks->push_back(group.text +
                       (group.count > 1 ? " (and " + std::to_string(group.count - 1) + " more like this)" : ""));
}

void remark_samples(const Json& recordings, Json* remarks) {
  for (const Json& r : recordings) {
    const std::string file = r["file"];
    if (!r["gaps"].empty())
      remarks->push_back(file + ": " + number(r["lost"].get<double>(), 3) +
                         " s without samples in gaps; the first from " + number(r["gaps"][0][0].get<double>(), 5) +
                         " to " + number(r["gaps"][0][1].get<double>(), 5) + " s");
    if (r["jitter"].get<double>() > kHalf)
      remarks->push_back(file + ": samples come unevenly, by " + number(100.0 * r["jitter"].get<double>(), 2) +
                         " % of their period");
    std::vector<std::string> held;
    for (const Json& h : r["held"])
      held.push_back(h["signal"].get<std::string>() + " (" + number(h["rate"].get<double>(), 3) + " Hz)");
    if (!held.empty()) remarks->push_back(file + ": changes less often than samples come: " + join(held));
  }
}

// Root mean square of the recorded velocity over that of the position's rate across 0.05 s, all recordings. Noise and
// steps of an encoder add to the rate, so the true factor is no smaller. Zero: not known.
double calc_least_factor(const Experiment& e, size_t joint) {
  double velocity = 0.0, rate = 0.0;
  for (const Recording& r : e.recordings) {
    const JointColumns& log = r.joints[joint];
    if (!log.has(Quantity::kPosition) || !log.has(Quantity::kVelocity)) continue;
    // In a moment a velocity that is one moves its joint; an encoder's steps matter less.
    for (size_t k = 0, end = 0; k < r.size(); ++k) {
      while (end < r.size() && r.time[end] < r.time[k] + kMoment) ++end;
      if (end == r.size()) break;
      const double v = log.signal[static_cast<int>(Quantity::kVelocity)][k],
                   step = log.signal[0][end] - log.signal[0][k];
      if (!std::isfinite(v) || !std::isfinite(step)) continue;
      velocity += v * v;
      rate += std::pow(step / (r.time[end] - r.time[k]), 2);
    }
  }
  return rate > 0.0 ? std::sqrt(velocity / rate) : 0.0;
}

void remark_velocities(const Experiment& e, Json* remarks) {
  const std::vector<VelocityReading> readings = find_velocity_readings(e);
  std::vector<std::string> late, ahead, scaled, shifted, fast;
  for (size_t j = 0; j < readings.size(); ++j) {
    const JointSpec& joint = e.robot.tree.joint(static_cast<int>(j));
    const std::string& name = joint.name;
    const VelocityReading& log = readings[j];
    const std::string time = name + " (" + number(1e3 * std::abs(log.late), 2) + " ms)";
    if (log.is_late()) late.push_back(time);
    if (log.is_position_late()) ahead.push_back(time);
    if (log.is_scaled())
      scaled.push_back(name + " (" + number(log.scale, 3) + ")");
    else if (const double factor = calc_least_factor(e, j); factor > std::exp(kFactor))
      fast.push_back(name + " (" + number(factor, 2) + ")");
    if (log.is_biased())
      shifted.push_back(name + " (" + number(log.bias, 3) + " " + get_joint_unit(joint, "rad/s") + ")");
  }
  if (!late.empty()) remarks->push_back("the recorded velocity is later than the rate of the position: " + join(late));
  if (!ahead.empty()) remarks->push_back("the recorded position is later than the velocity: " + join(ahead));
  if (!scaled.empty())
    remarks->push_back("the recorded velocity is not the rate of the position, but that times a factor: " +
                       join(scaled));
  if (!fast.empty())
    remarks->push_back("the recorded velocity is at least so many times the rate of the position: " + join(fast) +
                       ": is it in another unit, or that of the motor, before the gear? The position is too coarse to "
                       "tell the factor");
  if (!shifted.empty())
    remarks->push_back("the recorded velocity is off the rate of the position by a constant: " + join(shifted));
}

void remark_roles(const Experiment& e, Json* remarks) {
  if (!has_held_out(e.recordings))
    remarks->push_back(
        "no recording is held out (role: validate): what is found is judged by the recordings that it was fitted to");
}

// Neighbours have the same unit, so one joint that tells it is enough.
void remark_unit(const Json& joints, Json* remarks) {
  bool recorded = false, told = false;
  for (const Json& j : joints) {
    recorded = recorded || j.contains("tells_unit");
    told = told || j.value("tells_unit", false);
  }
  if (recorded && !told)
    remarks->push_back(
        "weight and inertia of the model take too little of the efforts to show their unit: if they are no N m, nor "
        "are the values that are found");
}

void remark_motion(const Json& joints, Json* remarks) {
  std::vector<std::string> still, unknown;
  std::map<std::string, std::vector<std::string>> hidden;  // effect -> joints
  for (const Json& j : joints) {
    const std::string name = j["joint"];
    if (j["effort"] == "unknown") unknown.push_back(name);
    if (j["travel"].get<double>() < kHardlyMoved) {
      still.push_back(name);
      continue;
    }
    for (const Json& t : j["tells"]) {
      if (t["verdict"] == "hidden") hidden[t["effect"].get<std::string>()].push_back(name);
    }
  }
  if (!still.empty()) remarks->push_back("hardly moves, so that nothing can be said of it: " + join(still));
  if (!unknown.empty())
    remarks->push_back("no effort, and no command with servo gains: nothing can be said of the drive of " +
                       join(unknown));
  for (const auto& [effect, names] : hidden) {
    std::string word = effect;
    std::replace(word.begin(), word.end(), '_', ' ');
    remarks->push_back("this motion cannot tell " + word + " of " + join(names));
  }
}

void remark_conventions(const ConventionRemarks& conventions, Json* remarks) {
  for (const std::string& text : conventions.found) remarks->push_back(text);
  for (const std::string& text : conventions.not_looked_for) remarks->push_back(text);
  remarks->push_back(std::string("degrees, milliseconds, turned signs and exchanged columns: ") +
                     (conventions.found.empty() ? "none was found" : "no other was found") +
                     (conventions.not_looked_for.empty() ? "" : ", as far as they could be looked for"));
}

// Parts of one file as one row.
Json gather_recordings(const Experiment& e) {
  Json list = Json::array();
  std::string last;
  for (const Recording& r : e.recordings) {
    Json check = make_sample_check(e, r);
    if (r.spec.file != last || list.empty()) {
      list.push_back(check);
    } else {
      Json& there = list.back();
      const std::string name = there["file"];
      there["file"] = name.substr(0, name.find(" ("));
      there["duration"] = round_to(there["duration"].get<double>() + check["duration"].get<double>(), 5);
      there["samples"] = there["samples"].get<size_t>() + check["samples"].get<size_t>();
      there["parts"] = there.value("parts", 1) + 1;
    }
    last = r.spec.file;
  }
  return list;
}

std::string pad(std::string text, size_t width) {
  if (text.size() < width) text.resize(width, ' ');
  return text;
}

}  // namespace

Json make_checks(const Experiment& e, const Experiment& searched, const ConventionRemarks& conventions) {
  Json joints = Json::array(), remarks = Json::array();
  const Json recordings = gather_recordings(e);
  if (!e.scenario.floating_base && e.scenario.drive != "motion") joints = make_motion_checks(searched);
  remark_warnings(e, &remarks);
  remark_samples(recordings, &remarks);
  remark_velocities(e, &remarks);
  remark_motion(joints, &remarks);
  remark_unit(joints, &remarks);
  remark_roles(searched, &remarks);
  remark_conventions(conventions, &remarks);
  return {{"recordings", recordings}, {"joints", joints}, {"remarks", remarks}};
}

std::string print_checks(const Json& checks) {
  std::string out = pad("recording", 32) + pad("role", 10) + pad("s", 9) + pad("Hz", 8) + "samples\n";
  for (const Json& r : checks["recordings"])
    out += pad(r["file"].get<std::string>(), 32) + pad(r["role"].get<std::string>(), 10) +
           pad(number(r["duration"].get<double>(), 4), 9) + pad(number(r["rate"].get<double>(), 4), 8) +
           std::to_string(r["samples"].get<size_t>()) + "\n";
  if (!checks["joints"].empty())
    out += "\n" + pad("joint", 28) + pad("travel", 9) + pad("speed", 9) + pad("accel.", 9) +
           "least that shows: dry [N m], viscous "
           "[N m s/rad], rotor [kg m^2], gain [1]\n";
  for (const Json& j : checks["joints"]) {
    out += pad(j["joint"].get<std::string>(), 28);
    for (const char* key : {"travel", "speed", "acceleration"}) out += pad(number(j[key].get<double>(), 3), 9);
    for (const Json& t : j["tells"]) {
      if (t["effect"] == "constant_torque") continue;
      out += pad(
          t["verdict"] == "hidden" ? "-" : number(t["least"].get<double>(), 2) + (t["verdict"] == "weak" ? "?" : ""),
          10);
    }
    out += "\n";
  }
  out += "\n";
  for (const Json& text : checks["remarks"]) out += "- " + text.get<std::string>() + "\n";
  return out;
}

}  // namespace hrp::diagnosis

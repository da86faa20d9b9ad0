// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/recorder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

namespace hrp::cases {
namespace {

using Quat = std::array<double, 4>;  // w x y z

Quat multiply(const Quat& a, const Quat& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

Quat from_rpy(const Vec3& rpy) {
  const Quat x{std::cos(rpy[0] / 2), std::sin(rpy[0] / 2), 0, 0}, y{std::cos(rpy[1] / 2), 0, std::sin(rpy[1] / 2), 0},
      z{std::cos(rpy[2] / 2), 0, 0, std::sin(rpy[2] / 2)};
  return multiply(z, multiply(y, x));
}

Vec3 rotate_back(const Quat& q, const Vec3& v) {  // R(q)^T v
  const Quat c{q[0], -q[1], -q[2], -q[3]};
  const Quat r = multiply(multiply(c, {0, v[0], v[1], v[2]}), q);
  return {r[1], r[2], r[3]};
}

// One readable quantity: its column group's name, its parts, its noise, and how it is taken from a reading.
struct Channel {
  std::string sensor;              // "/imu/x/angular_velocity": what a fault may name
  std::vector<std::string> parts;  // "" for a scalar column
  double noise = 0;
  std::function<std::vector<double>(const Reading&)> take;
  bool is_quaternion = false;  // x y z w, noise is a small turn [rad]
  bool is_vector = false;      // turned by a misalignment
  double step = 0;             // readings are whole numbers of it; 0: any
};

std::vector<double> list(const Vec3& v) { return {v[0], v[1], v[2]}; }
std::vector<double> list_xyzw(const Quat& q) { return {q[1], q[2], q[3], q[0]}; }

double read_effort(const RecorderPlan& plan, const Reading& r, std::size_t j) {
  if (plan.ripples.empty()) return r.effort[j];
  const EffortRipple& ripple = plan.ripples[j];
  return r.effort[j] + ripple.amplitude * std::sin(ripple.periods * r.position[j] + ripple.phase);
}

std::vector<Channel> make_joint_channels(const RobotPlan& robot, const RecorderPlan& plan) {
  std::vector<Channel> out;
  for (std::size_t j = 0; j < static_cast<std::size_t>(joint_count(robot)); ++j) {
    const std::string& name = joint(robot, static_cast<int>(j)).name;
    const std::string base = "/joint_states/" + name;
    out.push_back({base + "/position",
                   {""},
                   plan.position_noise,
                   [j](const Reading& r) { return std::vector<double>{r.position[j]}; },
                   false,
                   false,
                   plan.encoder_step});
    if (plan.with_velocity)
      out.push_back({base + "/velocity", {""}, plan.velocity_noise, [j](const Reading& r) {
                       return std::vector<double>{r.velocity[j]};
                     }});
    if (plan.with_effort)
      out.push_back({base + "/effort",
                     {""},
                     plan.effort_noises.empty() ? plan.effort_noise : plan.effort_noises[j],
                     [j, &plan](const Reading& r) { return std::vector<double>{read_effort(plan, r, j)}; }});
    if (robot.joint_torques) {
      out.push_back({"/joint_states_link/" + name + "/effort", {""}, plan.effort_noise, [j](const Reading& r) {
                       return std::vector<double>{r.link_torque[j]};
                     }});
    }
    if (plan.link_encoder == name || robot.link_encoders) {
      out.push_back({"/joint_states_link/" + name + "/position", {""}, plan.position_noise, [j](const Reading& r) {
                       return std::vector<double>{r.link_position[j]};
                     }});
    }
  }
  return out;
}

std::vector<Channel> make_body_channels(const RobotPlan& robot, const RecorderPlan& plan) {
  const std::vector<std::string> xyz{"/x", "/y", "/z"}, xyzw{"/x", "/y", "/z", "/w"};
  std::vector<Channel> out;
  if (!robot.imu.empty()) {
    const std::string base = "/imu/" + robot.imu;
    if (plan.with_attitude)
      out.push_back({base + "/orientation", xyzw, plan.attitude_noise,
                     [](const Reading& r) { return list_xyzw(r.imu_orientation); }, true, true});
    out.push_back({base + "/angular_velocity", xyz, plan.rate_noise, [](const Reading& r) { return list(r.imu_rate); },
                   false, true});
    out.push_back({base + "/linear_acceleration", xyz, plan.acceleration_noise,
                   [](const Reading& r) { return list(r.imu_acceleration); }, false, true});
  }
  if (!robot.wrist.empty()) {
    const std::string base = "/wrench/" + robot.wrist;
    out.push_back(
        {base + "/force", xyz, plan.force_noise, [](const Reading& r) { return list(r.wrist_force); }, false, true});
    out.push_back(
        {base + "/torque", xyz, plan.torque_noise, [](const Reading& r) { return list(r.wrist_torque); }, false, true});
  }
  for (std::size_t f = 0; f < robot.feet.size(); ++f) {
    const std::string base = "/wrench/" + robot.feet[f].wrench;
    out.push_back(
        {base + "/force", xyz, plan.force_noise, [f](const Reading& r) { return list(r.foot_force[f]); }, false, true});
    out.push_back({base + "/torque", xyz, plan.torque_noise, [f](const Reading& r) { return list(r.foot_torque[f]); },
                   false, true});
  }
  if (plan.with_base_pose) {
    out.push_back({"/base/pose/position", xyz, plan.pose_noise, [](const Reading& r) { return list(r.base_position); },
                   false, false});
    out.push_back({"/base/pose/orientation", xyzw, plan.pose_noise,
                   [](const Reading& r) { return list_xyzw(r.base_orientation); }, true, false});
  }
  return out;
}

bool concerns(const Hidden& h, const std::string& sensor) {
  return h.where_kind == "sensor" && (h.where == sensor || sensor.rfind(h.where + "/", 0) == 0);
}

// When the sensor's value was true: its delay and its clock.
double find_true_time(const std::vector<Hidden>& hidden, const std::string& sensor, double t) {
  for (const Hidden& h : hidden) {
    if (!concerns(h, sensor)) continue;
    if (h.effect == "sensor_delay") t -= h.get("delay");
    if (h.effect == "clock_skew") t *= 1 + h.get("skew");
  }
  return t;
}

std::vector<double> add_faults(const std::vector<Hidden>& hidden, const Channel& channel, std::vector<double> v) {
  for (const Hidden& h : hidden) {
    if (!concerns(h, channel.sensor)) continue;
    if (h.effect == "sensor_scale")
      for (double& x : v) x *= h.get("scale");
    if (h.effect == "sensor_bias" && v.size() == 3) {
      for (std::size_t i = 0; i < 3; ++i) v[i] += h.get3("value")[i];
    } else if (h.effect == "sensor_bias") {
      v[0] += h.get("value");
    }
    if (h.effect == "sensor_misalignment" && channel.is_vector) {
      const Quat turn = from_rpy(h.get3("rpy"));
      v = channel.is_quaternion ? list_xyzw(multiply({v[3], v[0], v[1], v[2]}, turn))
                                : list(rotate_back(turn, {v[0], v[1], v[2]}));
    }
  }
  return v;
}

std::vector<double> add_noise(const Channel& channel, std::vector<double> v, Prng& random) {
  if (!channel.is_quaternion) {
    for (double& x : v) {
      x += channel.noise * random.normal();
      if (channel.step > 0) x = channel.step * std::round(x / channel.step);
    }
    return v;
  }
  const Vec3 turn{channel.noise * random.normal(), channel.noise * random.normal(), channel.noise * random.normal()};
  return list_xyzw(multiply({v[3], v[0], v[1], v[2]}, from_rpy(turn)));
}

}  // namespace

RecorderPlan draw_recorder(const RobotPlan& robot, const std::vector<Hidden>& hidden, Prng& r) {
  RecorderPlan plan;
  plan.rate = robot.floating ? r.pick(std::vector<double>{200, 250, 333, 400, 500})
                             : r.pick(std::vector<double>{200, 250, 400, 500, 500, 1000});
  if (r.chance(0.15)) plan.jitter = r.uniform(0.05, 0.3);
  if (r.chance(0.1)) plan.dropped = r.uniform(0.01, 0.06);
  if (r.chance(0.1)) plan.clock_origin = 1.7e9 + std::round(r.uniform(0, 1e7));  // seconds of the epoch, as in a bag
  const double level = r.log_uniform(0.5, 2.5);
  double strongest = 0;  // servo stiffness [N m/rad]
  for (int j = 0; j < joint_count(robot); ++j) strongest = std::max(strongest, joint(robot, j).kp);
  plan.position_noise = 2e-5 * level;
  plan.velocity_noise = 2e-3 * level;
  // One number for all joints, as `noise` in an experiment has it: a drive resolves some 1e-4 of what it can give.
  plan.effort_noise = std::round(1e6 * strongest * 2.5e-5 * level) / 1e6;
  plan.force_noise = 0.5 * level;
  plan.torque_noise = 0.025 * level;
  plan.rate_noise = 2e-3 * level;
  plan.acceleration_noise = 0.03 * level;
  plan.attitude_noise = 1.5e-4 * level;
  plan.pose_noise = 2e-4 * level;
  plan.noise_stated = !robot.floating && r.chance(0.7);
  plan.with_base_pose = robot.floating && r.chance(0.4);
  // A column whose fault is hidden has to be there.
  auto is_needed = [&](const char* quantity) {
    return std::any_of(hidden.begin(), hidden.end(), [&](const Hidden& h) {
      return h.where_kind == "sensor" && h.where.find(quantity) != std::string::npos;
    });
  };
  plan.with_velocity = !r.chance(0.12) || is_needed("/velocity");
  plan.with_effort = !r.chance(0.08) || is_needed("/effort");
  plan.with_attitude = !r.chance(0.08) || is_needed("/imu");
  for (const Hidden& h : hidden) {
    if ((h.effect == "joint_elasticity" || h.effect == "backlash") && r.chance(0.25)) plan.link_encoder = h.where;
  }
  return plan;
}

RecorderPlan without_noise(RecorderPlan plan) {
  plan.position_noise = plan.velocity_noise = plan.effort_noise = plan.force_noise = plan.torque_noise = 0;
  plan.rate_noise = plan.acceleration_noise = plan.attitude_noise = plan.pose_noise = 0;
  plan.encoder_step = plan.stamp_error = 0;
  plan.effort_noises.clear();
  plan.ripples.clear();
  return plan;
}

std::vector<double> draw_row_times(const RecorderPlan& plan, double start, double duration, Prng& random) {
  std::vector<double> times;
  const int count = static_cast<int>(duration * plan.rate) + 1;
  for (int k = 0; k < count; ++k) {
    const double moved = k == 0 ? 0 : plan.jitter * random.uniform(-1, 1);
    if (plan.dropped > 0 && k > 0 && k + 1 < count && random.chance(plan.dropped)) continue;
    times.push_back(std::round(1e6 * (start + (k + moved) / plan.rate)) / 1e6);
  }
  return times;
}

namespace {

// What the clock shows: its origin and its error, ascending.
void stamp(const RecorderPlan& plan, Prng& random, std::vector<double>* times) {
  double last = -1e300;
  for (double& t : *times) {
    const double error = plan.stamp_error > 0 ? plan.stamp_error * random.normal() : 0.0;
    t = std::max(last + 1e-5, t + plan.clock_origin + error);
    last = t;
  }
}

std::vector<Channel> make_channels(const RobotPlan& robot, const RecorderPlan& plan) {
  std::vector<Channel> channels = make_joint_channels(robot, plan);
  for (Channel& channel : make_body_channels(robot, plan)) channels.push_back(std::move(channel));
  return channels;
}

}  // namespace

std::vector<double> list_instants(const RobotPlan& robot, const std::vector<Hidden>& hidden, const RecorderPlan& plan,
                                  const std::vector<double>& times) {
  std::vector<double> instants = times;
  for (const Channel& channel : make_channels(robot, plan)) {
    if (find_true_time(hidden, channel.sensor, 1.0) == 1.0) continue;
    for (double t : times) instants.push_back(find_true_time(hidden, channel.sensor, t));
  }
  std::sort(instants.begin(), instants.end());
  instants.erase(std::unique(instants.begin(), instants.end()), instants.end());
  return instants;
}

std::vector<double> add_sensor_faults(const std::vector<Hidden>& hidden, const std::string& sensor,
                                      std::vector<double> values) {
  Channel channel;
  channel.sensor = sensor;
  channel.is_quaternion = values.size() == 4;
  channel.is_vector = values.size() >= 3;
  return add_faults(hidden, channel, std::move(values));
}

double find_sensor_time(const std::vector<Hidden>& hidden, const std::string& sensor, double t) {
  return find_true_time(hidden, sensor, t);
}

std::vector<Column> record(const RobotPlan& robot, const std::vector<Hidden>& hidden, const RecorderPlan& plan,
                           const RecordingPlan& recording, const Commands& commands, const std::vector<double>& times,
                           Prng& random) {
  const std::vector<double> instants = list_instants(robot, hidden, plan, times);
  const std::vector<Reading> readings =
      Reality(robot, hidden).run(commands, instants, recording.push, recording.soles_lift);
  return make_columns(robot, hidden, plan, commands, times, instants, readings, random);
}

std::vector<Column> make_columns(const RobotPlan& robot, const std::vector<Hidden>& hidden, const RecorderPlan& plan,
                                 const Commands& commands, const std::vector<double>& times,
                                 const std::vector<double>& instants, const std::vector<Reading>& readings,
                                 Prng& random) {
  const std::vector<Channel> channels = make_channels(robot, plan);
  auto at = [&](double t) -> const Reading& {
    return readings[static_cast<std::size_t>(std::lower_bound(instants.begin(), instants.end(), t) - instants.begin())];
  };

  std::vector<Column> out{{"time", times, 0}};
  stamp(plan, random, &out[0].values);
  for (std::size_t j = 0; plan.with_commands && j < commands.position.size(); ++j) {
    const std::string base = "/joint_commands/" + joint(robot, static_cast<int>(j)).name;
    Column q{base + "/position", {}, 0}, v{base + "/velocity", {}, 0};
    for (double t : times) {
      const auto k = static_cast<std::size_t>(std::lower_bound(commands.time.begin(), commands.time.end(), t) -
                                              commands.time.begin());
      q.values.push_back(commands.position[j][k]);
      v.values.push_back(commands.velocity[j][k]);
    }
    out.push_back(std::move(q));
    out.push_back(std::move(v));
  }
  for (const Channel& channel : channels) {
    const std::size_t first = out.size();
    for (const std::string& part : channel.parts) out.push_back({channel.sensor + part, {}, channel.noise});
    for (double t : times) {
      std::vector<double> v = channel.take(at(find_true_time(hidden, channel.sensor, t)));
      v = add_noise(channel, add_faults(hidden, channel, std::move(v)), random);
      for (std::size_t i = 0; i < v.size(); ++i) out[first + i].values.push_back(v[i]);
    }
  }
  return out;
}

std::string make_csv(const std::vector<Column>& columns) {
  std::string out;
  for (std::size_t c = 0; c < columns.size(); ++c) out += (c ? "," : "") + columns[c].name;
  out += '\n';
  char buffer[40];
  for (std::size_t k = 0; k < columns[0].values.size(); ++k) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      // Ten digits for commands: reality was driven by these, so the file must hold them; seven for what was measured.
      const char* format = c == 0 ? "%.6f" : columns[c].name.rfind("/joint_commands", 0) == 0 ? ",%.10g" : ",%.7g";
      std::snprintf(buffer, sizeof buffer, format, columns[c].values[k]);
      out += buffer;
    }
    out += '\n';
  }
  return out;
}

}  // namespace hrp::cases

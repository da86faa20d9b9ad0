// SPDX-License-Identifier: BSD-3-Clause
// openhrp_dds.read_log's other side: logs of runs as arrays.
#include <map>

#include "common/log/log_table.h"
#include "common/messages/cdr.h"
#include "common/messages/topics.h"
#include "hrp_idl/dynamics.h"
#include "python/src/arrays.h"

namespace hrp::python {
namespace {

const mcap::Channel& find_channel(const mcap::Reader& log, const TopicSpec& topic) {
  const mcap::Channel* channel = log.find_channel(topic.name);
  if (channel == nullptr) throw py::value_error(log.path() + ": no log of a simulation (no topic " + topic.name + ")");
  return *channel;
}

// A log that was cut short is read as far as it goes, with a warning.
void warn_of(const std::string& damage, const std::string& path) {
  if (damage.empty()) return;
  const std::string text = path + ": " + damage;
  if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) < 0) throw py::error_already_set();
}

// Returns what is wrong with the log, empty: nothing.
template <typename Message, typename Take>
std::string read_topic(const std::string& path, const TopicSpec& topic, const Take& take) {
  mcap::Reader log(path);
  const mcap::Channel& channel = find_channel(log, topic);
  Message message;
  log.read_messages(
      [&](const mcap::Message& raw) {
        decode(Bytes{raw.data, raw.size}, &message);
        take(message);
        return true;
      },
      {channel.topic});
  return log.damage();
}

py::tuple read_table(const std::string& path) {
  std::vector<std::string> names;
  std::vector<double> values;
  std::string damage;
  {
    const py::gil_scoped_release free;
    mcap::Reader log(path);
    LogTable table = read_log_table(&log);
    names = std::move(table.names);
    for (const std::vector<double>& row : table.rows) values.insert(values.end(), row.begin(), row.end());
    damage = log.damage();
  }
  warn_of(damage, path);
  const size_t columns = names.size();
  return py::make_tuple(names, give(std::move(values), columns));
}

void add(std::vector<double>* row, const msg::Vector3& v) { row->insert(row->end(), {v.x(), v.y(), v.z()}); }

// Every step: what no sensor knows.
py::dict read_states(const std::string& path) {
  std::vector<double> time, q, qd, efforts, pose, velocity;
  std::vector<unsigned long long> hashes;
  size_t n = 0;
  std::string damage;
  {
    const py::gil_scoped_release free;
    damage = read_topic<msg::RobotState>(path, topics::kRobotState, [&](const msg::RobotState& m) {
      n = m.positions().size();
      time.push_back(m.header().time());
      q.insert(q.end(), m.positions().begin(), m.positions().end());
      qd.insert(qd.end(), m.velocities().begin(), m.velocities().end());
      efforts.insert(efforts.end(), m.efforts().begin(), m.efforts().end());
      add(&pose, m.X_WB().translation());
      const auto& R = m.X_WB().rotation();
      pose.insert(pose.end(), {R.w(), R.x(), R.y(), R.z()});
      add(&velocity, m.V_WB().angular());
      add(&velocity, m.V_WB().linear());
      hashes.push_back(m.hash());
    });
  }
  warn_of(damage, path);
  py::dict states;
  states["time"] = give(std::move(time), 1).attr("reshape")(-1);
  states["q"] = give(std::move(q), n);
  states["qd"] = give(std::move(qd), n);
  states["efforts"] = give(std::move(efforts), n);
  states["base_pose"] = give(std::move(pose), 7);
  states["base_velocity"] = give(std::move(velocity), 6);
  states["hash"] = py::array_t<unsigned long long>(static_cast<py::ssize_t>(hashes.size()), hashes.data());
  return states;
}

void add_wrench(std::vector<double>* row, const msg::Wrench3& wrench) {
  add(row, wrench.moment());
  add(row, wrench.force());
}

struct PairRows {
  std::vector<double> time, spring, damper, friction, total;
};

py::dict read_contact_forces(const std::string& path) {
  std::map<std::pair<std::string, std::string>, PairRows> pairs;
  std::string damage;
  {
    const py::gil_scoped_release free;
    damage = read_topic<msg::ContactForces>(path, topics::kContactForces, [&](const msg::ContactForces& m) {
      for (const msg::PairForce& pair : m.pairs()) {
        PairRows& rows = pairs[{pair.name_a(), pair.name_b()}];
        rows.time.push_back(m.header().time());
        add_wrench(&rows.spring, pair.spring());
        add_wrench(&rows.damper, pair.damper());
        add_wrench(&rows.friction, pair.friction());
        add_wrench(&rows.total, pair.total());
      }
    });
  }
  warn_of(damage, path);
  py::dict all;
  for (auto& [names, rows] : pairs) {
    py::dict pair;
    pair["time"] = give(std::move(rows.time), 1).attr("reshape")(-1);
    pair["spring"] = give(std::move(rows.spring), 6);
    pair["damper"] = give(std::move(rows.damper), 6);
    pair["friction"] = give(std::move(rows.friction), 6);
    pair["total"] = give(std::move(rows.total), 6);
    all[py::make_tuple(names.first, names.second)] = pair;
  }
  return all;
}

}  // namespace

void bind_logs(py::module_& m) {
  m.def("read_log_table", &read_table, py::arg("path"),
        "(names, values): one row per sensor sample, values (T, columns), the first column is time [s]; NaN where "
        "there is none.");
  m.def("read_states", &read_states, py::arg("path"),
        "The state of every step: time (T,) [s], q, qd, efforts (T, n), base_pose (T, 7) [m; w x y z], base_velocity "
        "(T, 6)\n"
        "[rad/s; m/s], hash (T,).");
  m.def("read_contact_forces", &read_contact_forces, py::arg("path"),
        "(body_a, body_b) -> time (T,) [s] of the steps in which they touch; spring, damper, friction, total (T, 6) [N "
        "m; N] on A.");
}

}  // namespace hrp::python

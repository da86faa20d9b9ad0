// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/poor.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace hrp::cases {
namespace {

constexpr double kSmall = 0.3;     // of the usual slow motion
constexpr double kShortest = 1.0;  // [s] of a motion that was stopped: less tells nobody anything
constexpr double kMonitor = 0.02;  // [s] before a joint has left its command, that the recording ends

// Numbers of a file by column; the first line has the names.
struct Sheet {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  const std::vector<double>& get(const std::string& name, const std::string& file) const {
    const auto it = std::find(names.begin(), names.end(), name);
    if (it == names.end()) throw std::runtime_error(file + ": no column " + name);
    return columns[static_cast<std::size_t>(it - names.begin())];
  }
};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

Sheet read_sheet(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) throw std::runtime_error(file + ": cannot be read");
  Sheet sheet;
  sheet.names = split(line);
  sheet.columns.resize(sheet.names.size());
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = split(line);
    if (cells.size() != sheet.names.size()) continue;
    for (std::size_t i = 0; i < cells.size(); ++i) sheet.columns[i].push_back(std::stod(cells[i]));
  }
  return sheet;
}

Commands read_commands(const RobotPlan& robot, const std::string& file) {
  const Sheet sheet = read_sheet(file);
  Commands out;
  out.time = sheet.get("time", file);
  for (int j = 0; j < joint_count(robot); ++j) {
    const std::string base = "/joint_commands/" + find_outside_name(robot, joint(robot, j).name);
    out.position.push_back(sheet.get(base + "/position", file));
    out.velocity.push_back(sheet.get(base + "/velocity", file));
  }
  return out;
}

void add(Draft* draft, RecordingPlan plan, Commands commands) {
  draft->times.push_back(commands.time);
  draft->commands.push_back(std::move(commands));
  draft->recordings.push_back(std::move(plan));
}

// Loads that the proposal asks for, stated beside the commands in next.json.
std::vector<Hidden> read_loads(const std::filesystem::path& file) {
  std::vector<Hidden> loads;
  std::ifstream in(file.parent_path() / "next.json");
  if (!in) return loads;
  const nlohmann::ordered_json next = nlohmann::ordered_json::parse(in);
  for (const auto& motion : next["motions"]) {
    if (motion["file"] != file.filename().string()) continue;
    for (const auto& load : motion.value("loads", nlohmann::ordered_json::array()))
      loads.push_back(
          {"payload", "link", load["link"].get<std::string>(), {{"mass", load["mass"]}, {"com", load["com"]}}});
  }
  return loads;
}

RecordingPlan make_plan(const std::string& file, double duration) {
  const std::string name = std::filesystem::path(file).filename().string();
  RecordingPlan plan;
  plan.file = "next_" + name;
  plan.motion = "next";
  plan.duration = duration;
  plan.role = name.rfind("validate", 0) == 0 ? "validate" : "train";
  return plan;
}

// Joints that stand: one of an arm's; of a biped, whose legs have to move together, all that are not in its legs.
std::vector<char> draw_still(const RobotPlan& robot, Prng& random) {
  std::vector<char> still(static_cast<std::size_t>(joint_count(robot)), 0);
  if (!robot.floating) still[static_cast<std::size_t>(random.below(joint_count(robot)))] = 1;
  for (std::size_t j = 0; robot.floating && j < still.size(); ++j) {
    const std::string& role = joint(robot, static_cast<int>(j)).role;
    still[j] = role.find("hip") == std::string::npos && role.find("knee") == std::string::npos &&
               role.find("ankle") == std::string::npos;
  }
  return still;
}

void play_commands(Draft* draft, const std::vector<std::string>& files, Prng& random) {
  for (const std::string& file : files) {
    const Commands commands = read_commands(draft->robot, file);
    const double duration = commands.time.back() - commands.time.front();
    RecordingPlan plan = make_plan(file, duration);
    plan.loads = read_loads(file);
    add(draft, plan, commands.sample(draw_row_times(draft->recorder, 0, duration, random)));
  }
}

void play_multisines(Draft* draft, const std::vector<std::string>& files, Prng& random) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string& file = files[i];
    const std::vector<double> time = read_sheet(file).get("time", file);
    RecordingPlan plan = make_plan(file, time.back() - time.front());
    const std::vector<double> rows = draw_row_times(draft->recorder, 0, plan.duration, random);
    add(draft, plan,
        make_commands(draft->robot, draft->robot.floating ? (i % 2 == 0 ? "squat" : "limbs") : "multisine", rows,
                      random));
  }
}

// A divergence that shorter steps do not show is the integrator's, not the robot's: the recording is made with these.
void try_to_play(Draft* draft, std::size_t i) {
  RecordingPlan& plan = draft->recordings[i];
  const auto run = [&] {
    Reality(draft->robot, list_in(*draft, i)).run(draft->commands[i], draft->times[i], plan.push, plan.soles_lift);
  };
  try {
    run();
  } catch (const InsaneCase& insane) {
    if (insane.why != kDiverges) throw;
    plan.soles_lift = true;
    run();
  }
}

void stop_where_joints_leave(Draft* draft) {
  for (std::size_t i = 0; i < draft->recordings.size(); ++i) {
    std::vector<double>& times = draft->times[i];
    if (draft->recordings[i].motion != "next") continue;
    try {
      try_to_play(draft, i);
    } catch (const InsaneCase& insane) {
      if (insane.time < kShortest) throw;
      times.erase(std::lower_bound(times.begin(), times.end(), insane.time - kMonitor), times.end());
      draft->recordings[i].motion = "next, stopped";
      draft->recordings[i].duration = times.back();
    }
  }
}

}  // namespace

void impoverish(Draft* draft, double seconds, Prng random) {
  const std::vector<char> still = draw_still(draft->robot, random);
  draft->recordings.clear();
  draft->commands.clear();
  draft->times.clear();
  for (const char* name : {"train_1", "train_2", "validate_1"}) {
    RecordingPlan plan;
    plan.file = std::string(name) + ".csv";
    plan.role = name[0] == 't' ? "train" : "validate";
    plan.motion = draft->robot.floating ? "sway" : "slow";
    plan.duration = seconds;
    const std::vector<double> rows = draw_row_times(draft->recorder, 0, seconds, random);
    Commands commands = make_commands(draft->robot, plan.motion, rows, random);
    for (std::size_t j = 0; j < commands.position.size(); ++j) {
      const double factor = still[j] ? 0.0 : kSmall, start = joint(draft->robot, static_cast<int>(j)).start;
      for (double& q : commands.position[j]) q = start + factor * (q - start);
      for (double& v : commands.velocity[j]) v *= factor;
    }
    add(draft, plan, std::move(commands));
  }
}

void play(Draft* draft, const std::vector<std::string>& files, bool multisines, Prng random) {
  multisines ? play_multisines(draft, files, random) : play_commands(draft, files, random);
  if (!files.empty()) stop_where_joints_leave(draft);
}

}  // namespace hrp::cases

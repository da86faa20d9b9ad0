// SPDX-License-Identifier: BSD-3-Clause
// Writes a proposal: commands that a robot can play, next.json for programs, next.html for people.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/base/write_file.h"
#include "diagnosis/next/hung_loads.h"
#include "diagnosis/next/page.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/report/print_json.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

std::string make_csv(const Experiment& e, const Proposal& p) {
  const Commands& commands = p.commands;
  std::string text = "time";
  for (int j = 0; j < e.num_joints(); ++j) {
    const std::string base = ",/joint_commands/" + e.robot.tree.joint(j).name;
    text += base + "/position" + base + "/velocity" + (p.effort.empty() ? "" : base + "/effort");
  }
  for (size_t k = 0; k < commands.time.size(); ++k) {
    text += "\n" + number(commands.time[k], 10);
    for (size_t j = 0; j < commands.position.size(); ++j) {
      text += "," + number(commands.position[j][k], 10) + "," + number(commands.velocity[j][k], 10);
      if (!p.effort.empty()) text += "," + number(p.effort[j][k], 6);
    }
  }
  return text + "\n";
}

// By joint that moves: share of the range that limits leave.
Json make_sizes(const Proposal& p, const std::vector<std::string>& joints) {
  Json sizes = Json::object();
  for (size_t j = 0; j < p.plan.moves.size(); ++j) {
    if (p.plan.moves[j]) sizes[joints[j]] = round_to(get_size(p.plan, j), 3);
  }
  return sizes;
}

// [rad or m] A joint that comes back to where it was, up to rounding, is there.
double round_end(double q) { return std::round(1e4 * q) / 1e4 + 0.0; }

// By joint that moves: least and largest command [rad or m], the space that has to be free.
Json make_ranges(const Proposal& p, const std::vector<std::string>& joints) {
  constexpr double kMoves = 1e-4;  // below it, legs that hold a foot only round
  Json ranges = Json::object();
  for (size_t j = 0; j < p.commands.position.size(); ++j) {
    const auto [low, high] = std::minmax_element(p.commands.position[j].begin(), p.commands.position[j].end());
    if (*high - *low > kMoves) ranges[joints[j]] = {round_end(*low), round_end(*high)};
  }
  return ranges;
}

Json make_stop(const Proposal& p, const std::vector<std::string>& joints) {
  Json stop = Json::object();
  for (size_t j = 0; j < p.stop.size(); ++j) stop[joints[j]] = round_to(p.stop[j], 3);
  return stop;
}

Json make_loads(const std::vector<LoadSpec>& loads) {
  Json list = Json::array();
  for (const LoadSpec& load : loads)
    list.push_back({{"link", load.link},
                    {"mass", load.mass},
                    {"com", {load.p_LC.x(), load.p_LC.y(), load.p_LC.z()}},
                    {"sentence", describe(load)}});
  return list;
}

std::string get_role(const Proposal& p) { return p.file.rfind("train", 0) == 0 ? "train" : "validate"; }

// The line for the experiment that states the recording.
std::string make_line(const Proposal& p) {
  std::string loads;
  for (const LoadSpec& load : p.plan.loads) {
    loads += std::string(loads.empty() ? "" : ", ") + "{link: " + load.link + ", mass: " + number(load.mass, 3) +
             ", com: [" + number(load.p_LC.x(), 4) + ", " + number(load.p_LC.y(), 4) + ", " + number(load.p_LC.z(), 4) +
             "]}";
  }
  return "- {file: round_1_" + p.file + ", role: " + get_role(p) + (loads.empty() ? "" : ", loads: [" + loads + "]") +
         "}";
}

Json make_json(const Proposal& p, const std::vector<std::string>& joints) {
  Json expected = Json::array(), intervals = Json::array();
  for (const Expected& one : p.expected)
    expected.push_back({{"against", one.label},
                        {"probability", round_to(one.probability, 3)},
                        {"difference", round_to(one.difference, 3)}});
  for (const ExpectedInterval& one : p.intervals)
    intervals.push_back({{"effect", one.label},
                         {"parameter", one.parameter},
                         {"unit", one.unit},
                         {"value", round_to(one.value, 6)},
                         {"half_width", round_to(one.before, 4)},
                         {"expected_half_width", round_to(one.after, 4)},
                         {"least_half_width", round_to(one.least, 4)}});
  return {{"file", p.file},
          {"role", get_role(p)},
          {"loads", make_loads(p.plan.loads)},
          {"line", make_line(p)},
          {"family", get_family_word(p.plan.family)},
          {"sentence", get_family_sentence(p.plan.family)},
          {"seconds", round_to(p.plan.seconds, 4)},
          {"size", round_to(p.plan.size, 3)},
          {"sizes", make_sizes(p, joints)},
          {"joints", p.moving},
          {"ranges", make_ranges(p, joints)},
          {"stop", make_stop(p, joints)},
          {"worth", round_to(p.worth, 3)},
          {"expected", expected},
          {"intervals", intervals},
          {"overlay",
           {{"signal", p.overlay.signal},
            {"unit", p.overlay.unit},
            {"time", p.overlay.time},
            {"curves", p.overlay.curves},
            {"labels", p.overlay.labels}}}};
}

Json make_json(const Next& next, const std::vector<std::string>& joints) {
  Json motions = Json::array();
  for (const Proposal& p : next.proposals) motions.push_back(make_json(p, joints));
  return {{"schema", 1},
          {"nothing", next.nothing},
          {"unseen", next.unseen},
          {"explanations", next.explanations},
          {"motions", motions},
          {"tried", next.tried},
          {"rejected", next.rejected},
          {"words", next.words},
          {"untold", next.untold},
          {"checked", next.checked},
          {"scale", next.scale},
          {"remarks", next.remarks}};
}

}  // namespace

void write_next(const Experiment& experiment, const Next& next, const std::string& folder) {
  const fs::path out = fs::path(folder) / "next";
  fs::remove_all(out);
  fs::create_directories(out);
  for (const Proposal& p : next.proposals) write_file(out / p.file, make_csv(experiment, p));
  std::vector<std::string> joints;
  for (int j = 0; j < experiment.num_joints(); ++j) joints.push_back(experiment.robot.tree.joint(j).name);
  const Json json = make_json(next, joints);
  write_file(out / "next.json", print_json(json, 1) + "\n");
  write_file(out / "next.html", make_next_page(json, experiment.robot.tree.name));
}

std::string propose_next(const Experiment& experiment, const std::string& folder, const Json& report,
                         const NextOptions& options, const Progress& progress) {
  const Next next = propose(experiment, report, options, progress);
  write_next(experiment, next, folder);
  std::string text;
  for (const std::string& one : next.words) text += "  " + one + ".\n";
  if (!next.nothing.empty())
    return "\nNext experiment: none. " + next.nothing + "\n" + (text.empty() ? "" : "Motions that would tell:\n") +
           text;
  text = "\nNext experiment (" + folder + "/next/next.html):\n";
  for (const Proposal& p : next.proposals) {
    double decided = 0.0;
    for (const Expected& one : p.expected) decided += one.probability / static_cast<double>(p.expected.size());
    text += "  " + p.file + ": ";
    for (const LoadSpec& load : p.plan.loads) text += describe(load) + " ";
    text +=
        get_family_sentence(p.plan.family) +
        std::string(p.expected.empty() ? ""
                                       : " Expected to rule out " + number(std::round(100.0 * decided), 3) + " % of " +
                                             number(static_cast<double>(p.expected.size())) + " other explanations.") +
        "\n";
  }
  return text;
}

}  // namespace hrp::diagnosis

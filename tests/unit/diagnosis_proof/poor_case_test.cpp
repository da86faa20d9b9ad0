// SPDX-License-Identifier: BSD-3-Clause
// First recordings that tell little, and motions that were proposed for a case.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "diagnosis/generator/make_case.h"
#include "tests/test_places.h"

namespace hrp::cases {
namespace {

namespace fs = std::filesystem;

// Smallest and largest number of every column.
std::map<std::string, std::pair<double, double>> find_ranges(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) names.push_back(cell);
  std::map<std::string, std::pair<double, double>> ranges;
  for (const std::string& name : names) ranges[name] = {1e300, -1e300};
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (const std::string& name : names) {
      std::getline(cells, cell, ',');
      if (cell.empty()) continue;
      auto& [low, high] = ranges[name];
      low = std::min(low, std::stod(cell));
      high = std::max(high, std::stod(cell));
    }
  }
  return ranges;
}

std::string make_lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_of_leg(const std::string& column) {
  const std::string name = make_lower(column);
  return name.find("hip") != std::string::npos || name.find("knee") != std::string::npos ||
         name.find("ankle") != std::string::npos;
}

bool is_command(const std::string& column) {
  return column.rfind("/joint_commands/", 0) == 0 && column.find("/position") != std::string::npos;
}

CaseOptions make_options() {
  CaseOptions options;
  options.duration = 1.2;
  options.poor = 1;
  return options;
}

// A biped whose joints have the names of its maker; one of the seeds that need few draws of robot and effect.
constexpr std::uint64_t kBiped = 11;

const Case& get_biped() {
  static const Case made = make_case(parse_request("stand:foot_compliance"), kBiped, make_options());
  return made;
}

// A pure function stands for the draws: a real case that fails takes minutes.
TEST(CasesThatCannotBe, AnotherOneOfTheKindIsDrawnAndTheTruthSaysSo) {
  std::vector<std::uint64_t> asked;
  const auto make = [&](std::uint64_t seed) {
    asked.push_back(seed);
    if (asked.size() < 3) throw std::runtime_error("no sane walk");
    return Case{};
  };
  EXPECT_EQ(make_with_other_seeds(make, 7).truth["given_up"], 2);
  EXPECT_EQ(asked[0], 7u);
  EXPECT_NE(asked[1], asked[2]);
  asked.clear();
  make_with_other_seeds(
      [&](std::uint64_t seed) {
        asked.push_back(seed);
        return Case{};
      },
      7);
  EXPECT_EQ(asked.size(), 1u) << "what can be made is made once";
  EXPECT_THROW(make_with_other_seeds([](std::uint64_t) -> Case { throw std::runtime_error("never"); }, 7),
               std::runtime_error);
}

TEST(PoorCase, ABipedsFirstRecordingsMoveItsLegsOnly) {
  const Case& made = get_biped();
  double moved = 0;
  for (const auto& [column, range] : find_ranges(made.files.at("train_1.csv"))) {
    if (!is_command(column)) continue;
    if (is_of_leg(column))
      moved = std::max(moved, range.second - range.first);
    else
      EXPECT_DOUBLE_EQ(range.first, range.second) << column;
  }
  EXPECT_GT(moved, 1e-3);
}

std::string write_next(const std::string& name, const std::string& csv, const std::string& json) {
  const fs::path folder = fs::temp_directory_path() / ("hrp_poor_" + name);
  fs::create_directories(folder);
  std::ofstream(folder / "train_1.csv") << csv;
  std::ofstream(folder / "next.json") << json;
  return (folder / "train_1.csv").string();
}

// Outside the generator a biped's joints have the names of its maker.
TEST(PoorCase, AProposedMotionIsPlayedByTheNamesOfTheCase) {
  const std::string& commands = get_biped().files.at("train_1.csv");
  ASSERT_EQ(commands.find("left_"), std::string::npos)
      << "the seed no longer gives a biped with other names: choose another";
  CaseOptions options = make_options();
  options.played = {write_next("names", commands, "{\"motions\": []}")};
  EXPECT_EQ(make_case(parse_request("stand:foot_compliance"), kBiped, options).files.count("next_train_1.csv"), 1u);
}

TEST(PoorCase, ALoadThatIsAskedForHangsInItsRecordingAndIsStated) {
  CaseOptions options = make_options();
  const Case first = make_case(parse_request("arm:coulomb_friction"), 5, options);
  const std::string urdf = first.files.at("robot.urdf"), key = "<link name=\"";
  const size_t at = urdf.rfind(key) + key.size();
  const std::string link = urdf.substr(at, urdf.find('"', at) - at);
  const std::string motion = "{\"motions\": [{\"file\": \"train_1.csv\", \"loads\": [{\"link\": \"" + link +
                             "\", \"mass\": 0.5, \"com\": [0, 0, 0.1]}]}]}";
  options.noise_scale = 0;
  options.played = {write_next("load", first.files.at("train_1.csv"), motion)};
  const Case loaded = make_case(parse_request("arm:coulomb_friction"), 5, options);
  options.played = {write_next("bare", first.files.at("train_1.csv"), "{\"motions\": []}")};
  const Case bare = make_case(parse_request("arm:coulomb_friction"), 5, options);
  EXPECT_NE(
      loaded.files.at("experiment.yaml").find("next_train_1.csv, role: train, loads: [{link: " + link + ", mass: 0.5"),
      std::string::npos);
  EXPECT_EQ(bare.files.at("experiment.yaml").find("loads"), std::string::npos);
  EXPECT_NE(loaded.files.at("next_train_1.csv"), bare.files.at("next_train_1.csv"));
  EXPECT_EQ(loaded.files.at("train_1.csv"), bare.files.at("train_1.csv"));  // it hangs in no other recording
}

// The commands of a recording's first row, held for two seconds.
std::string make_hold(const std::string& csv) {
  std::istringstream lines(csv);
  std::string names, row, cell;
  std::getline(lines, names);
  std::getline(lines, row);
  std::string out = names + "\n";
  for (double time : {0.0, 2.0}) {
    std::istringstream cells(row);
    std::getline(cells, cell, ',');
    out += std::to_string(time);
    while (std::getline(cells, cell, ',')) out += "," + (cell.empty() ? "0" : cell);
    out += "\n";
  }
  return out;
}

// Two short walks; what is proposed for them is played by the same robot, on its feet.
TEST(PoorCaseNightly, AWalkerPlaysAProposedMotionAfterItsWalks) {
  CaseOptions options;
  options.poor = 4.5;
  options.models = source_dir() + "/models";
  const CaseRequest request = parse_request("walk:viscous_friction");
  const Case first = make_case(request, 3, options);
  EXPECT_EQ(first.files.count("walk_2.csv"), 1u);
  EXPECT_EQ(first.files.count("walk_3.csv"), 0u);
  ASSERT_NE(first.files.at("walk_1.csv").find("/joint_commands/"), std::string::npos)
      << "the seed gives a case without commands: choose another";
  options.played = {write_next("walk", make_hold(first.files.at("walk_1.csv")), "{\"motions\": []}")};
  const Case played = make_case(request, 3, options);
  EXPECT_EQ(played.files.at("walk_1.csv"), first.files.at("walk_1.csv"));
  const std::string& held = played.files.at("next_train_1.csv");
  EXPECT_EQ(held.substr(0, held.find('\n')),
            first.files.at("walk_1.csv").substr(0, held.find('\n')));  // the same sensors
  EXPECT_NE(played.files.at("experiment.yaml").find("next_train_1.csv, role: train"), std::string::npos);
}

}  // namespace
}  // namespace hrp::cases

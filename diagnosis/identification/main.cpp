// SPDX-License-Identifier: BSD-3-Clause
// hrp-identify-foot: makes the motions, runs them, identifies the rubber in the feet, writes the report.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "common/base/command_line.h"
#include "common/base/diagnostics.h"
#include "common/base/number_option.h"
#include "common/base/read_file.h"
#include "common/base/version.h"
#include "common/base/write_file.h"
#include "common/robot/experiment_keys.h"
#include "diagnosis/identification/improve.h"
#include "diagnosis/identification/motions.h"
#include "diagnosis/identification/report.h"
#include "diagnosis/identification/robot_log.h"

namespace {

namespace fs = std::filesystem;
using namespace hrp;
using namespace hrp::identification;

enum class MotionSet { kRich, kPaper };

// Motions that identify; the others only validate. Of ours all but sweeps, squat, bounce and the last swing; of the
// paper's the five sways.
bool is_training(const std::string& name, MotionSet set) {
  if (name.rfind("sway", 0) == 0) return true;
  return set == MotionSet::kRich && (name.rfind("tilt", 0) == 0 || name == "swing1" || name == "swing2");
}

struct ListedMotion {
  std::string name;
  bool training = false;
};

// Lines "NAME" or "NAME train" of motions.txt. Throws InputError when there are none.
std::vector<ListedMotion> read_list(const std::string& folder) {
  const std::string path = fs::path(folder) / "motions.txt";
  std::ifstream file = open_input(path);
  std::vector<ListedMotion> list;
  for (std::string line; std::getline(file, line);) {
    const size_t space = line.find(' ');
    if (!line.empty()) list.push_back({line.substr(0, space), space != std::string::npos});
  }
  check_end(file, path);
  if (list.empty()) refuse_input(path, "names no motion: expected lines NAME or NAME train");
  return list;
}

constexpr double kLongest = 20.0;  // [s] of a proposed motion

// More motions that identify, from the machine that proposes experiments.
void add_proposed(const Scenario& base, const std::vector<MotionCheck>& known, int seeds, double seconds,
                  const std::string& folder, std::string* list) {
  std::printf("least known stiffness or damping: deviation %.3g\n", find_largest_deviation(known));
  for (const ProposedMotion& motion : propose_motions(base, known, seeds, seconds, folder)) {
    std::printf("%-8s proposed: %s Centre of pressure stays %.0f mm inside the soles; the deviation falls to %.3g\n",
                motion.name.c_str(), motion.meaning.c_str(), 1e3 * motion.check.margin, motion.largest);
    *list += motion.name + " train\n";
  }
}

// Scenarios of all motions into a folder, each looked at before it is used. One name a line into motions.txt; the robot
// into robot.yaml.
int make_scenarios(const std::string& base_path, const std::string& folder, Rubber rubber, int tries, double scale,
                   MotionSet set) {
  prepare_folder(folder);
  const Scenario base = load_scenario(write_robot(load_scenario(base_path), rubber, folder));
  write_hanging(base, folder);
  std::string list = std::string(kHanging) + "\n";
  int refused = 0;
  std::vector<MotionCheck> known;  // of motions that identify
  for (const MotionPlan& plan : set == MotionSet::kPaper ? make_paper_plans(scale) : make_plans(scale)) {
    MotionCheck check;
    try {
      check = check_motion(write_motion(plan, base, folder), plan.lifted);
    } catch (const std::runtime_error& error) {
      std::printf("%-8s refused: %s\n", plan.name.c_str(), error.what());
      ++refused;
      continue;
    }
    std::printf(
        "%-8s %s: %s; centre of pressure stays %.0f mm inside the soles, a foot that stands carries at least %.0f N, "
        "condition number %.1f",
        plan.name.c_str(), check.ok() ? "used" : "refused", plan.meaning.c_str(), 1e3 * check.margin,
        check.smallest_load, check.condition);
    if (plan.lifted >= 0)
      std::printf(", %s foot in the air for %.1f s", plan.lifted ? "left" : "right", check.in_the_air);
    std::printf("%s\n", check.as_planned ? "" : "; the feet do not stand as planned");
    std::fflush(stdout);
    if (!check.ok()) {
      ++refused;
      continue;
    }
    list += plan.name + (is_training(plan.name, set) ? " train\n" : "\n");
    if (is_training(plan.name, set)) known.push_back(check);
  }
  if (tries > 0) add_proposed(base, known, tries, kLongest * scale, folder, &list);
  write_file(fs::path(folder) / "motions.txt", list);
  return refused == 0 ? 0 : 1;
}

std::vector<Source> read_folder(const std::string& folder, bool in_process) {
  std::vector<Source> sources;
  for (const auto& [name, training] : read_list(folder)) {
    const fs::path stem = fs::path(folder) / name;
    sources.push_back(
        {name, in_process ? run_in_process(load_scenario(stem.string() + ".yaml")) : read_mcap(stem.string() + ".mcap"),
         training});
    std::printf("%s: %ld samples\n", name.c_str(), static_cast<long>(sources.back().log.size()));
    std::fflush(stdout);
  }
  return sources;
}

std::vector<Source> read_experiment(const Scenario& scenario) {
  std::vector<Source> sources;
  for (const RecordingSpec& recording : parse_experiment_keys(scenario.text, scenario.path).recordings) {
    const fs::path path(recording.file);
    sources.push_back({path.stem().string(),
                       path.extension() == ".mcap" ? read_mcap(recording.file) : read_table(recording.file, scenario),
                       recording.train});
  }
  if (sources.empty()) throw InputError(scenario.make_diagnostic("recordings", "names none"));
  return sources;
}

void report(const Scenario& scenario, const std::vector<Source>& sources, bool simulated, const std::string& out) {
  const Identification result = identify(scenario, sources, simulated);
  const std::string page = (fs::path(out) / "report.html").string();
  write_report(result, page);
  const std::string found = write_identified_scenario(result, out);
  std::printf("%s\nreport: %s\nscenario with the bush found: %s\n", make_text(result).c_str(), page.c_str(),
              found.c_str());
}

// The folder's motions without sensor errors, then with those of many seeds.
void print_coverage(const Scenario& scenario, const std::string& folder, int seeds) {
  std::vector<Source> sources;
  for (const auto& [name, training] : read_list(folder)) {
    const Scenario clean = without_sensor_errors(load_scenario((fs::path(folder) / (name + ".yaml")).string()));
    sources.push_back({name, run_in_process(clean), training});
  }
  std::printf("%s", make_text(study_coverage(scenario, sources, seeds), scenario).c_str());
}

struct CommandLine {
  std::string scenario, folder, out;
  int tries = 0, seeds = 100;
  double scale = 1.0;
  bool in_process = false;
  Rubber rubber = Rubber::kAsGiven;
  MotionSet set = MotionSet::kRich;
};

// Each adds a subcommand.
CLI::App* add_make(CLI::App* app, CommandLine* c) {
  CLI::App* make =
      app->add_subcommand("make", "writes a scenario for each motion, and checks stability and excitation");
  make->add_option("scenario", c->scenario, "scenario of the robot, with its bush (foot_bush)")->required();
  make->add_option("folder", c->folder, "folder for scenarios and motions")->required();
  make->add_option("--improve", c->tries,
                   "proposes more motions on the feet for the least known parameters; tries this many of each family")
      ->check(CLI::Range(0, 1000));
  make->add_option("--rubber", c->rubber, "replaces the scenario's rubber by one with hardening or hysteresis")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Rubber>{
          {"given", Rubber::kAsGiven}, {"hardening", Rubber::kHardening}, {"hysteresis", Rubber::kHysteresis}}));
  make->add_option("--motions", c->set, "rich: our 18 motions; paper: the 14 of Mikami et al. 2014")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, MotionSet>{{"rich", MotionSet::kRich}, {"paper", MotionSet::kPaper}}));
  make->add_option("--scale", c->scale, "factor on the length of the motions (1)")
      ->check(refuse_nan)
      ->check(CLI::Range(0.1, 10.0));
  return make;
}

CLI::App* add_fit(CLI::App* app, CommandLine* c) {
  CLI::App* fit = app->add_subcommand(
      "fit", "identifies from the logs of the runs: NAME.mcap in the folder of `make`, for each NAME.yaml");
  fit->add_option("scenario", c->scenario, "scenario of the robot, with its bush (foot_bush)")->required();
  fit->add_option("folder", c->folder, "folder that `make` wrote")->required();
  fit->add_option("--out", c->out, "folder for report.html and identified.yaml")->required();
  fit->add_flag("--in-process", c->in_process, "runs the scenarios in this process instead of reading their logs");
  return fit;
}

void add_experiment(CLI::App* app, CommandLine* c) {
  CLI::App* experiment = app->add_subcommand("experiment", "identifies from an experiment's recordings (CSV or MCAP)");
  experiment
      ->add_option("experiment", c->scenario, "experiment.yaml; a recording named 'hanging' zeroes the force sensors")
      ->required();
  experiment->add_option("--out", c->out, "folder for report.html and identified.yaml")->required();
}

CLI::App* add_coverage(CLI::App* app, CommandLine* c) {
  CLI::App* coverage = app->add_subcommand(
      "coverage", "counts how often the 95 % intervals contain the truth, over many seeds of the sensor noise");
  coverage->add_option("scenario", c->scenario, "scenario of the robot, with its bush (foot_bush)")->required();
  coverage->add_option("folder", c->folder, "folder that `make` wrote")->required();
  coverage->add_option("--seeds", c->seeds, "number of seeds (100)")->check(CLI::Range(1, 100000));
  return coverage;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Identifies the rubber in a robot's feet from encoders, force sensors and the chest IMU.",
               "hrp-identify-foot");
  app.set_version_flag("--version", hrp::get_version_text("hrp-identify-foot"));
  app.require_subcommand(1);
  CommandLine c;
  const CLI::App &make = *add_make(&app, &c), &fit = *add_fit(&app, &c);
  add_experiment(&app, &c);
  const CLI::App& coverage = *add_coverage(&app, &c);
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  try {
    // Before the work whose results go there.
    if (!c.out.empty()) prepare_folder(c.out);
    if (make) return make_scenarios(c.scenario, c.folder, c.rubber, c.tries, c.scale, c.set);
    const Scenario base = load_scenario(c.scenario);
    if (coverage)
      print_coverage(base, c.folder, c.seeds);
    else if (fit)
      report(base, read_folder(c.folder, c.in_process), true, c.out);
    else
      report(base, read_experiment(base), false, c.out);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-identify-foot: %s\n", error.what());
    return 2;
  }
  return 0;
}

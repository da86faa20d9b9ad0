// SPDX-License-Identifier: BSD-3-Clause
#include <mujoco/mujoco.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <thread>

#include "common/base/command_line.h"
#include "common/base/number_option.h"
#include "common/base/shared_files.h"
#include "common/base/version.h"
#include "common/base/write_file.h"
#include "diagnosis/generator/make_case.h"
#include "diagnosis/generator/robot_parts.h"

namespace {

namespace fs = std::filesystem;
using namespace hrp::cases;

struct Job {
  std::string name;
  CaseRequest request;
  std::uint64_t seed = 0;
};

std::vector<Job> make_jobs(int count, std::uint64_t seed, const std::string& effect, const std::string& family) {
  std::vector<CaseRequest> requests =
      effect.empty() ? make_case_plan(count, seed, family)
                     : std::vector<CaseRequest>(static_cast<std::size_t>(count), parse_request(effect));
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "case-%03zu", i + 1);
    jobs.push_back({name, requests[i], seed * 1000003ULL + i});
  }
  return jobs;
}

// Commands that were proposed for a case: FOLDER/NAME/next/*.csv.
std::vector<std::string> list_played(const fs::path& folder) {
  std::vector<std::string> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void run_job(const Job& job, const fs::path& out, CaseOptions options, const std::string& played) {
  if (!played.empty()) options.played = list_played(fs::path(played) / job.name / "next");
  // Other robots would not be those whose commands are played.
  const auto make = [&](std::uint64_t seed) { return make_case(job.request, seed, options); };
  const Case made = options.played.empty() ? make_with_other_seeds(make, job.seed) : make(job.seed);
  fs::create_directories(out / "cases" / job.name);
  for (const auto& [file, contents] : made.files) hrp::write_file(out / "cases" / job.name / file, contents);
  hrp::write_file(out / "truths" / (job.name + ".json"), made.truth.dump(1) + "\n");
}

// Before the work, what would fail in every case: the folder, the name of a case, the robot.
void check_jobs(const std::vector<Job>& jobs, const fs::path& out, const std::string& only,
                const CaseOptions& options) {
  hrp::prepare_folder(out / "truths");
  if (jobs.empty())
    throw std::invalid_argument("--only: no case is called '" + only +
                                "'; they are case-001, case-002, ... up to --cases");
  if (!options.urdf.empty()) read_urdf_links(options.urdf, nullptr);
}

int run_jobs(const std::vector<Job>& jobs, const fs::path& out, const CaseOptions& options, const std::string& played,
             int threads) {
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<int> failed{0};
  std::mutex print;
  auto work = [&] {
    for (std::size_t i; (i = next++) < jobs.size();) {
      std::string fault;
      try {
        run_job(jobs[i], out, options, played);
      } catch (const std::exception& error) {
        fault = error.what();
        ++failed;
      }
      const std::lock_guard lock(print);
      ++done;
      if (!fault.empty()) std::fprintf(stderr, "%s: %s\n", jobs[i].name.c_str(), fault.c_str());
      std::fprintf(stderr, "\rmade %zu of %zu cases%s", done.load(), jobs.size(), done == jobs.size() ? "\n" : "");
    }
  };
  std::vector<std::thread> pool;
  for (int i = 0; i < threads; ++i) pool.emplace_back(work);
  for (std::thread& thread : pool) thread.join();
  return failed;
}

struct CommandLine {
  std::string out = "cases-out", effect, family, played, only;
  int count = 10, jobs = 2;
  std::uint64_t seed = 1;
  CaseOptions options;
  bool clean = false;
};

void add_options(CLI::App* app, CommandLine* c) {
  app->add_option("--out", c->out, "folder to write to")->capture_default_str();
  app->add_option("--cases", c->count, "number of cases")->check(CLI::Range(1, 100000))->capture_default_str();
  app->add_option("--seed", c->seed, "the same seed gives the same cases")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->add_option("--jobs", c->jobs, "number of threads")->check(CLI::Range(1, 256))->capture_default_str();
  app->add_option("--duration", c->options.duration, "[s] length of each recording")
      ->check(hrp::refuse_nan)
      ->check(CLI::Range(1.0, 60.0))
      ->capture_default_str();
  app->add_option("--effect", c->effect,
                  "hides only this: an effect, two joined by '+', or 'none'; 'arm:EFFECT', 'stand:EFFECT' or "
                  "'walk:EFFECT' chooses the robot, too");
  app->add_option(
      "--family", c->family,
      "only these families, a comma list. Groups: arm, stand, single, dirty, walk.\n"
      "Arms: none, joint, link, sensor, pair, pair_same_joint, triple, unknown, arm_dirty.\n"
      "Standing: stand_none, stand_foot, stand_sensor, stand_joint, stand_link, stand_pair, stand_unknown, "
      "stand_dirty.\n"
      "Walks: walk_none, walk_foot, walk_sensor, walk_joint, walk_link, walk_pair, walk_unknown, walk_dirty");
  app->add_option("--urdf", c->options.urdf,
                  "robot of all cases, held by its root link or on its feet; default: random arms and bipeds")
      ->check(CLI::ExistingFile);
  app->add_option("--sensors", c->options.sensors,
                  "sensors of arms behind their gears, a comma list: joint_torque, link_encoder, imu, wrench")
      ->delimiter(',')
      ->check(CLI::IsMember({"joint_torque", "link_encoder", "imu", "wrench"}));
  app->add_option("--models", c->options.models, "folder with the models of walking robots; default: the installed one")
      ->check(CLI::ExistingDirectory);
  app->add_option("--poor", c->options.poor,
                  "[s] recordings of this length with little information: of arms slow, small, one joint still; of "
                  "walks two short ones")
      ->check(hrp::refuse_nan)
      ->check(CLI::Range(1.0, 20.0));
  app->add_option(
         "--play", c->played,
         "adds recordings of the same robots, which play the commands in DIR/NAME/next/*.csv; files whose names begin\n"
         "with validate are held out")
      ->check(CLI::ExistingDirectory);
  app->add_flag("--multisines", c->options.multisines,
                "with --play: plays multisines of the same length instead of those commands");
  app->add_option("--only", c->only, "makes only the case of this name, such as case-003");
  app->add_flag("--no-noise", c->clean, "recordings without noise (for self-checks)");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Makes recordings of simulated robots (MuJoCo) with hidden physics, for blind trials of hrp-diagnose.\n"
      "Writes OUT/cases/NAME (experiment, URDF, CSV) and OUT/truths/NAME.json."};
  app.set_version_flag("--version", hrp::get_version_text("hrp-make-cases"));
  CommandLine c;
  add_options(&app, &c);
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  c.options.noise_scale = c.clean ? 0 : 1;
  if (c.options.models.empty()) c.options.models = hrp::find_shared_file("models");
  mju_user_warning = [](const char*) {};  // MuJoCo would write a log file into the working directory
  try {
    std::vector<Job> plan = make_jobs(c.count, c.seed, c.effect, c.family);
    if (!c.only.empty())
      plan.erase(std::remove_if(plan.begin(), plan.end(), [&](const Job& job) { return job.name != c.only; }),
                 plan.end());
    check_jobs(plan, c.out, c.only, c.options);
    return run_jobs(plan, c.out, c.options, c.played, c.jobs) == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-make-cases: %s\n", error.what());
    return 2;
  }
}

// SPDX-License-Identifier: BSD-3-Clause
// hrp-trial SCENARIO...: runs without bus and log, one line of JSON each.
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/diagnostics.h"
#include "common/base/version.h"
#include "common/base/write_file.h"
#include "servers/console/trial/trial.h"

namespace {

// Time, vertical force of each foot, then force and torque of each force sensor, lean of each IMU, position and lean of
// the base.
class Table {
 public:
  explicit Table(const std::string& path) : file_(std::fopen(path.c_str(), "w")) {}
  ~Table() {
    if (file_ != nullptr) std::fclose(file_);
  }
  bool good() const { return file_ != nullptr; }
  // False where a part of the table did not reach the disk.
  bool close() {
    const bool written = std::ferror(file_) == 0;
    return std::fclose(std::exchange(file_, nullptr)) == 0 && written;
  }
  void write_head(const hrp::Scenario& scenario) {
    std::fprintf(file_, "time");
    for (const std::string& foot : scenario.feet) std::fprintf(file_, ",%s/force_z", foot.c_str());
    for (const hrp::WrenchSpec& wrench : scenario.sensors.wrenches) {
      for (const char* part : {"fx", "fy", "fz", "tx", "ty", "tz"})
        std::fprintf(file_, ",%s/%s", wrench.name.c_str(), part);
    }
    for (const hrp::ImuSpec& imu : scenario.sensors.imus) {
      std::fprintf(file_, ",%s/roll,%s/pitch", imu.name.c_str(), imu.name.c_str());
    }
    std::fprintf(file_, ",base/x,base/y,base/z,base/roll,base/pitch\n");
  }
  void write(const hrp::Trial& trial) {
    std::fprintf(file_, "%.4f", trial.time());
    for (double force : trial.engine().foot_forces()) std::fprintf(file_, ",%.3f", force);
    for (const hrp::WrenchSample& w : trial.engine().sensors().wrenches) {
      for (int i = 0; i < 3; ++i) std::fprintf(file_, ",%.4f", w.force[i]);
      for (int i = 0; i < 3; ++i) std::fprintf(file_, ",%.4f", w.torque[i]);
    }
    for (const hrp::ImuSample& imu : trial.engine().sensors().imus) write_lean(imu.R_WS.toRotationMatrix());
    const hrp::State& state = trial.engine().state();
    for (int i = 0; i < 3; ++i) std::fprintf(file_, ",%.5f", state.p_WB[i]);
    write_lean(state.R_WB.toRotationMatrix());
    std::fprintf(file_, "\n");
  }

 private:
  // Roll and pitch [rad].
  void write_lean(const hrp::Matrix3d& R) {
    std::fprintf(file_, ",%.6f,%.6f", std::atan2(R(2, 1), R(2, 2)),
                 -std::asin(std::fmin(1.0, std::fmax(-1.0, R(2, 0)))));
  }

  std::FILE* file_;
};

void print(const std::string& name, const hrp::Trial& trial, const hrp::TrialResult& r) {
  std::printf(
      "{\"scenario\": \"%s\", \"fallen\": %s, \"fall_time\": %.3f, \"duration\": %.3f, \"largest_lean\": %.4f, "
      "\"travelled\": [%.4f, %.4f, %.4f], \"turned\": %.4f, \"landings\": [",
      name.c_str(), r.fallen ? "true" : "false", r.fall_time, r.duration, r.largest_lean, r.travelled.x(),
      r.travelled.y(), r.travelled.z(), r.turned);
  for (size_t i = 0; i < r.landings.size(); ++i) std::printf("%s%d", i ? ", " : "", r.landings[i]);
  std::printf("], \"state_hash\": \"%016llx\", \"fault\": \"%s\"}\n", trial.engine().state_hash(), r.fault.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Runs scenarios in this process, without bus and log. Prints one line of JSON per scenario.",
               "hrp-trial");
  app.set_version_flag("--version", hrp::get_version_text("hrp-trial"));
  std::vector<std::string> paths;
  std::string csv;
  bool to_the_end = false;
  app.add_option("scenario", paths, "scenario files")->required();
  app.add_option("--csv", csv, "CSV table of the last run: contact forces, force sensors, base");
  app.add_flag("--to-the-end", to_the_end, "continue after a fall, as the server set does");
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  try {
    for (const std::string& path : paths) {
      hrp::Trial trial(hrp::load_scenario(path));
      trial.go_on_after_fall = to_the_end;
      if (csv.empty()) {
        print(path, trial, trial.run());
        continue;
      }
      Table table(csv);
      if (!table.good()) throw std::runtime_error(csv + ": cannot be written");
      table.write_head(trial.scenario());
      print(path, trial, trial.run([&](const hrp::Trial& t) { table.write(t); }));
      if (!table.close()) throw std::runtime_error(csv + ": cannot be written: it is not whole");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-trial: %s\n", error.what());
    return 2;
  }
  return hrp::finish_output("hrp-trial") ? 0 : 1;
}

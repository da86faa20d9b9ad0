// SPDX-License-Identifier: BSD-3-Clause
// What the walking controller costs: one call a control period, fed with the sensor data of a walk of its own. The
// first call of a walk makes the whole pattern and is timed apart. No pass or fail.
#include <benchmark/benchmark.h>

#include <time.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "controller/node.h"
#include "controller/play.h"
#include "servers/console/trial/trial.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

// The walk's sensor data, recorded once, and a controller to hear them.
struct Walk {
  std::vector<SensorData> heard;
  Robot robot;
  std::unique_ptr<Controller> controller;
};

bool prepare(benchmark::State& loop, const char* name, RobotDescription* description, Scenario* scenario, Walk* walk) {
  const std::string path = source_dir() + "/models/scenarios/paper_a/" + name + ".yaml";
  try {
    *scenario = load_scenario(path);
    Trial trial(*scenario);
    trial.tamper = [walk](SensorData* sensors) { walk->heard.push_back(*sensors); };
    trial.run();
    *description = load_robot(*scenario);
    walk->robot = make_robot(*description, *scenario);
    walk->controller = make_scenario_controller(walk->robot);
  } catch (const std::exception& error) {
    loop.SkipWithError(error.what());
    return false;
  }
  return true;
}

// [s] of processor: whoever else runs on the machine does not count.
double get_processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// One period after the first, over a whole walk.
void control_period(benchmark::State& loop, const char* name) {
  RobotDescription description;
  Scenario scenario;
  Walk walk;
  if (!prepare(loop, name, &description, &scenario, &walk)) return;
  double largest = 0.0, sum = 0.0;  // [s]
  size_t k = walk.heard.size();
  for ([[maybe_unused]] auto _ : loop) {
    if (k >= walk.heard.size()) {
      loop.PauseTiming();
      walk.controller->start(walk.robot);
      benchmark::DoNotOptimize(walk.controller->control(walk.heard[0], walk.robot));
      k = 1;
      loop.ResumeTiming();
    }
    const double begin = get_processor_time();
    benchmark::DoNotOptimize(walk.controller->control(walk.heard[k++], walk.robot));
    const double taken = get_processor_time() - begin;
    largest = std::max(largest, taken);
    sum += taken;
  }
  const double period = scenario.control_period * scenario.time_step;
  loop.counters["largest_us"] = 1e6 * largest;
  loop.counters["percent_of_period"] = 100.0 * sum / static_cast<double>(loop.iterations()) / period;
}

// The first call: footsteps, pattern, first inverse kinematics.
void make_walk(benchmark::State& loop, const char* name) {
  RobotDescription description;
  Scenario scenario;
  Walk walk;
  if (!prepare(loop, name, &description, &scenario, &walk)) return;
  for ([[maybe_unused]] auto _ : loop) {
    walk.controller->start(walk.robot);
    benchmark::DoNotOptimize(walk.controller->control(walk.heard[0], walk.robot));
  }
}

BENCHMARK_CAPTURE(control_period, hrp2p_like, "fig9")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(control_period, hrp1s_like, "fig7")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(control_period, ten_metres, "beyond_10m")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(make_walk, hrp2p_like, "fig9")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(make_walk, ten_metres, "beyond_10m")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hrp

BENCHMARK_MAIN();

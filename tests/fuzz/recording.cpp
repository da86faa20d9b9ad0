// SPDX-License-Identifier: BSD-3-Clause
// Text recordings as the diagnosis reads them: cells, stamps and units, spikes and turns, noise, suspicions.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/base/diagnostics.h"
#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/make_recording.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/repair.h"
#include "tests/fuzz/fuzz.h"

namespace {

namespace fs = std::filesystem;
using namespace hrp::diagnosis;

constexpr const char* kRobot = R"(<robot name="two"><link name="base"/>
<link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="one" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
<joint name="two" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint></robot>)";
constexpr const char* kScenario =
    "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 100, kd: 1}}\nrecordings:\n  - {file: r.csv}\n";

// The robot with a sound recording, read once.
Experiment make_experiment() {
  const fs::path folder = fs::temp_directory_path() / ("hrp_fuzz_recording_" + std::to_string(getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kRobot;
  std::ofstream(folder / "experiment.yaml") << kScenario;
  std::ofstream csv(folder / "r.csv");
  csv << "time,/joint_commands/one/position,/joint_states/one/position,/joint_commands/two/position,/joint_states/two/"
         "position\n";
  for (int k = 0; k < 100; ++k) csv << 0.01 * k << "," << std::sin(0.1 * k) << "," << std::sin(0.1 * k) << ",0,0\n";
  csv.close();
  Experiment e = load_experiment((folder / "experiment.yaml").string());
  fs::remove_all(folder);
  return e;
}

void read_all(const std::string& path, Experiment* e) {
  e->recordings.clear();
  e->warnings.clear();
  e->other_noise.clear();
  hrp::RecordingSpec spec;
  spec.file = spec.name = path;
  probe_csv(path);
  read_csv_averaged(path, 3, &e->warnings);
  const Table table = read_csv(path, &e->warnings);
  for (const auto& column : table.columns) {
    if (column.size() != table.rows()) std::abort();
  }
  e->recordings.push_back(make_recording(*e, spec, table, &e->warnings));
  repair_recording(*e, &e->recordings[0], &e->warnings);
  check_plausibility(e);
  find_noise(e);
  for (const auto& joint : e->joint_noise) {
    for (const Noise& noise : joint) {
      if (!(noise.sigma > 0.0 && std::isfinite(noise.sigma))) std::abort();  // it is divided by
    }
  }
}

// A file whose header says nothing, or that has none.
void read_by_numbers(const std::string& path, Experiment* e) {
  const hrp::ColumnMap map{
      {{"time", "", 1, 1e-3, 0.0}, {"/joint_states/one/position", "", 2, 1.0, 0.0}, {"a note", "", 3, 1.0, 0.0}},
      100.0};
  probe_csv(path, map);
  const Table table = read_csv_averaged(path, 2, &e->warnings, map);
  for (const auto& column : table.columns) {
    if (column.size() != table.rows()) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static Experiment e = make_experiment();
  const hrp::test::MemoryFile file(data, size);
  for (const auto read : {read_all, read_by_numbers}) {
    try {
      read(file.path(), &e);
    } catch (const hrp::InputError&) {
    }
  }
  return 0;
}

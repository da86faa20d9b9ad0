// SPDX-License-Identifier: BSD-3-Clause
// From an outcome to report.json, series.json and the updated experiment.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/report/json.h"
#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

struct Reports {
  Json report, series;
  std::string urdf;  // of the updated model, where it is not the experiment's own
};

namespace standing {
// A standing robot with an IMU and force sensors in its feet, by equations along the recorded motion
// (standing/channels.h). False when the recordings lack what that needs.
bool diagnose_standing(const Problem& problem, const std::function<void(const std::string&)>& progress, Reports* out);
}  // namespace standing

// The whole diagnosis, for every kind of base and drive.
Reports diagnose(const Problem& problem, const Progress& progress);

// Standard deviation of a channel (joint * 3 + quantity) over recordings, in the channel's unit; 0: not recorded.
double calc_channel_spread(const Experiment& e, const std::vector<int>& recordings, size_t channel);
// Simulated readings of two models, signal by signal in SI units, on recordings that nothing was fitted to.
Fit calc_simulation_fit(const Problem& problem, const Trial& before, const Trial& after);

Reports make_reports(const Problem& problem, const Outcome& outcome);

// For recordings that the tool cannot yet compute with: says so, names nothing.
Reports make_empty_reports(const Problem& problem, const std::string& reason);

// DIR/report.json, DIR/series.json, DIR/report.html, and DIR/updated/: scenario.yaml (the experiment with the findings
// as `effects`, replaying a recording's commands), nominal.yaml (without them). Throws std::runtime_error naming what
// failed.
void write_reports(const Experiment& experiment, const std::string& folder, Reports reports);

// The experiment as a scenario of its robot with these findings as `effects`; what no simulator knows stands in a line
// that begins with "# not simulated".
std::string make_scenario_text(const Experiment& experiment, const nlohmann::json& effects);

// Values of parameters that were fitted beside those, and that a scenario may state: teeth behind a gap.
Json list_also_fitted(const Effect& effect);

}  // namespace hrp::diagnosis

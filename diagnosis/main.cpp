// SPDX-License-Identifier: BSD-3-Clause
// hrp-diagnose EXPERIMENT.yaml --out DIR: finds what a simulation left out.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "common/base/command_line.h"
#include "common/base/number_option.h"
#include "common/base/run_main.h"
#include "common/base/version.h"
#include "common/base/write_file.h"
#include "diagnosis/diagnose_recordings.h"
#include "diagnosis/next/limits.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/page/terminal.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kHelp =
    "Compares recordings of a robot with its model. Finds and fits the physics and sensor faults that the model "
    "lacks.\n"
    "Writes DIR/report.html, DIR/report.json, DIR/series.json and DIR/updated/.\n"
    "Example: hrp-diagnose models/experiments/arm --out diagnosed\n"
    "Exit status: 0 a verdict was reached, 2 bad input (the message has file, line and column), 1 results could not "
    "be\n"
    "written (the message has the reason), or a fault of the tool.";

struct Options {
  std::string experiment_path, out;
  int jobs = static_cast<int>(std::thread::hardware_concurrency());
  double patience = 1.0;
  bool quiet = false, check = false, next = false;
  NextOptions motions;
};

void add_options(CLI::App* app, Options* o) {
  app->add_option("experiment", o->experiment_path, "experiment.yaml, or its folder")->required();
  app->add_option("--out", o->out, "DIR, the folder for the report; required, except with --check");
  app->add_flag("--check", o->check,
                "only checks the recordings: rates, gaps, clocks, motion, and which effects this motion can show");
  app->add_option("--jobs", o->jobs, "number of threads; the report does not depend on it")->check(CLI::Range(1, 256));
  app->add_option(
         "--patience", o->patience,
         "factor on the work of a search on a fixed base; 1 is about two minutes of two cores. Raise it if the\n"
         "report says that not all sets of effects were tried. The report depends on it")
      ->check(hrp::refuse_nan)
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  app->add_flag(
      "--next", o->next,
      "also proposes motions that decide between the remaining explanations, and are safe under all of them.\n"
      "For fixed bases and standing robots. Writes DIR/next/*.csv, next.json, next.html");
  app->add_option("--limit", o->motions.limits,
                  "limits of these motions (SI units): speed=0.5, effort=20, elbow.upper=1, reach=2.5 (usually 1 rad), "
                  "or a YAML file")
      ->needs("--next");
  app->add_option("--seconds", o->motions.seconds, "[s] length of each of these motions")
      ->check(hrp::refuse_nan)
      ->check(CLI::Range(4.0, 20.0))
      ->capture_default_str();
  app->add_option("--motions", o->motions.count,
                  "number of motions, best first; every second one is meant as a held-out recording")
      ->check(CLI::Range(1, 12))
      ->capture_default_str();
  app->add_flag("--quiet", o->quiet, "no progress on the terminal");
}

// Lines on the terminal with the time since the start [s].
Progress make_progress(bool quiet) {
  if (quiet) return [](const std::string&) {};
  return [begin = std::chrono::steady_clock::now()](const std::string& text) {
    const double since = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::fprintf(stderr, "%7.1f s  %s\n", since, text.c_str());
  };
}

void diagnose(const Experiment& experiment, const Options& o) {
  prepare_folder(o.out, 1 << 15);                                            // every report has more
  if (!o.motions.limits.empty()) make_limits(experiment, o.motions.limits);  // refuses wrong ones before the search
  const Progress say = make_progress(o.quiet);
  const auto write_first = [&](const Reports& first) { write_first_report(o.out, first); };
  const Reports reports = diagnose_recordings(experiment, {o.jobs, o.patience}, say, write_first);
  write_reports(experiment, o.out, reports);
  std::printf("%s", make_terminal_text(reports.report).c_str());
  if (o.next) std::printf("%s", propose_next(experiment, o.out, reports.report, o.motions, say).c_str());
  std::printf("\nReport: %s/report.html. Model: %s/updated/scenario.yaml.\n", o.out.c_str(), o.out.c_str());
}

int run(Options o) {
  if (o.out.empty() && !o.check) {
    std::fprintf(stderr, "hrp-diagnose: --out is required: a folder for the report\n");
    return 2;
  }
  o.motions.jobs = o.jobs;
  std::error_code error;
  if (std::filesystem::is_directory(o.experiment_path, error)) o.experiment_path += "/experiment.yaml";
  const Experiment experiment = load_experiment(o.experiment_path);
  if (o.check)
    std::printf("%s", check_recordings(experiment).c_str());
  else
    diagnose(experiment, o);
  return finish_output("hrp-diagnose") ? 0 : 1;
}

}  // namespace
}  // namespace hrp::diagnosis

int main(int argc, char** argv) {
  CLI::App app{hrp::diagnosis::kHelp};
  app.set_version_flag("--version", hrp::get_version_text("hrp-diagnose"));
  hrp::diagnosis::Options options;
  hrp::diagnosis::add_options(&app, &options);
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  return hrp::run_main("hrp-diagnose", [&] { return hrp::diagnosis::run(options); });
}

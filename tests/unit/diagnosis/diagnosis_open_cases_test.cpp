// SPDX-License-Identifier: BSD-3-Clause
// A few of the open cases (made with another engine), for continuous integration; scripts/diagnose_open_cases.sh runs
// all.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "diagnosis/diagnose_recordings.h"
#include "tests/test_places.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

class OpenCase : public testing::TestWithParam<const char*> {};

TEST_P(OpenCase, IsNamedInTheRightPlace) {
  const fs::path folder = fs::path(source_dir()) / "../shared/cases/open" / GetParam();
  if (!fs::exists(folder / "truth.json"))
    GTEST_SKIP() << "no open cases beside the tree: " << folder << " is absent, NOTHING was checked";
  std::ifstream file(folder / "truth.json");
  const auto truth = nlohmann::json::parse(file)["hidden"];
  const Experiment e = load_experiment((folder / "experiment.yaml").string());
  DiagnosisOptions options;
  options.jobs = 2;
  const auto report = diagnose_recordings(
                          e, options, [](const std::string&) {}, [](const Reports&) {})
                          .report;
  ASSERT_EQ(report["findings"].size(), truth.size());
  if (truth.empty()) {
    EXPECT_EQ(report["verdict"], "no_mismatch");
    return;
  }
  EXPECT_EQ(report["verdict"], "explained");
  EXPECT_EQ(report["findings"][0]["effect"], truth[0]["effect"].get<std::string>());
  for (const char* kind : {"joint", "link", "sensor"}) {
    if (!truth[0].contains(kind)) continue;
    EXPECT_EQ(report["findings"][0]["where"][kind], truth[0][kind].get<std::string>());
  }
  EXPECT_LE(report["fit"]["validate"]["after"].get<double>(), 1.2);  // noise deviations: the bar of a held-out fit
}

// An arm with nothing hidden; at night a biped with an effect that is named, both the other way round, and one more.
INSTANTIATE_TEST_SUITE_P(Few, OpenCase, testing::Values("open-03"));
INSTANTIATE_TEST_SUITE_P(Nightly, OpenCase, testing::Values("open-04", "open-05", "open-08", "open-16"));

}  // namespace
}  // namespace hrp::diagnosis

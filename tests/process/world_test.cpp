// SPDX-License-Identifier: BSD-3-Clause
// The world of a scenario in the server set: surfaces reach every server over DDS, and the run has the bits of one
// process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/process/run_and_digest.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

const std::string kModels = source_dir() + "/models";

// The box of test_robots falls askew onto the stairs and the hills of models/terrain.
std::string write_world() {
  std::string path = get_test_folder() + "/world.yaml";
  std::ofstream(path) << "robot: " << kModels << "/test_robots/box.urdf\nfeet: [box]\nground: {type: none}\n"
                      << "initial: {position: [0.5, 0.1, 0.7], rpy: [0.2, 0.1, 0.3]}\n"
                      << "obstacles:\n  stairs: {shape: mesh, file: " << kModels << "/terrain/stairs.obj}\n"
                      << "  hills: {shape: height_field, file: " << kModels
                      << "/terrain/hills.png, spacing: 0.05, low: -0.1, high: 0.2}\n"
                      << "controller: {type: hold}\nsteps: {duration: 0.5}\n";
  return path;
}

TEST(World, ARunOnStairsAndHillsHasTheSameBitsInOneProcessAndInSix) {
  const auto reference = run_and_digest("world-one", write_world(), {"--in-process"});
  EXPECT_EQ(reference.at("hrp/robot_state").count, 501u);
  EXPECT_EQ(run_and_digest("world-cyclone", write_world(), {"--dds", "cyclone"}), reference);
  EXPECT_EQ(run_and_digest("world-fast", write_world(), {"--dds", "fast"}), reference);
}

TEST(World, AFieldOfTheLargestSizeReachesEveryServer) {
  const std::string field = get_test_folder() + "/large.csv", path = get_test_folder() + "/large.yaml";
  std::ofstream out(field);
  for (int i = 0; i < 500; ++i) {
    for (int j = 0; j < 500; ++j) out << (i * j % 7) * 1e-4 << (j == 499 ? '\n' : ',');
  }
  out.close();
  std::ofstream(path) << "robot: " << kModels << "/test_robots/box.urdf\nfeet: [box]\nground: {type: none}\n"
                      << "obstacles: {land: {shape: height_field, file: " << field << ", spacing: 0.01}}\n"
                      << "controller: {type: hold}\nsteps: {duration: 0.05}\n";
  for (const char* vendor : {"cyclone", "fast"}) {
    ServerSet set(std::string("large-") + vendor, {path, "--force", "--dds", vendor});
    EXPECT_EQ(set.wait(), 0) << vendor << ": " << set.output();
  }
}

TEST(World, AMissingFileIsSaidWithItsLine) {
  const std::string path = get_test_folder() + "/missing.yaml";
  std::ofstream(path) << "robot: " << kModels
                      << "/test_robots/box.urdf\nobstacles:\n  land: {shape: mesh, file: nowhere.obj}\n";
  ServerSet set("missing", {path});
  EXPECT_NE(set.wait(), 0);
  EXPECT_THAT(set.output(), HasSubstr("missing.yaml:3:"));
  EXPECT_THAT(set.output(), HasSubstr("there is no file"));
}

}  // namespace
}  // namespace hrp::test

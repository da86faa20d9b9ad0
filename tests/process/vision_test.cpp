// SPDX-License-Identifier: BSD-3-Clause
// Cameras and lidars in the server set: pictures repeat to the bit, and a run goes as it does without them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <mutex>
#include <set>

#include "common/messages/ros_topics.h"
#include "hrp_idl/ros_views.h"
#include "hrp_idl/vision.h"
#include "tests/process/run_and_digest.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

using Image = ::sensor_msgs::msg::dds_::Image_;

constexpr char kEyes[] =
    "  camera:\n    head: {link: NECK_P_LINK, xyz: [0.1, 0, 0.1], rpy: [0, 0.4, 0], width: 80, height: 60, near: 0.1, "
    "rate: 30}\n"
    "    beside: {xyz: [0, -2, 1], rpy: [0, 0.1, 1.57], width: 160, height: 120, depth: false, rate: 10, color_noise: "
    "0.01}\n"
    "  lidar:\n    scan: {link: WAIST_P_LINK, xyz: [0.2, 0, 0.2], columns: 90, rows: 4, elevation: [-0.5, 0.1], rate: "
    "20, noise: 0.01}\n";

// hrp2p_stand.yaml with these lines under `sensors`, and more lines at the end.
std::string write_looking_scenario(const std::string& name, const std::string& sensors, const std::string& more = "") {
  std::string path = write_scenario(name);
  std::ifstream in(path);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  in.close();
  const size_t at = text.find("\nsensors:\n");
  if (at == std::string::npos) throw std::runtime_error("the scenario has no block of sensors");
  text.insert(at + 10, sensors);
  std::ofstream(path) << text << more;
  return path;
}

TEST(Pictures, AreLoggedWithTheSameBitsInOneProcessAndOnEitherVendor) {
  const std::string scenario = write_looking_scenario("logged", kEyes, "logging: {pictures: true}\n");
  const auto reference = run_and_digest("logged-one", scenario, {"--in-process"});
  EXPECT_EQ(reference.at("hrp/robot_state").count, 501u);
  // Half a second, and nothing of the last step, whose answers nobody uses.
  EXPECT_EQ(reference.at("rt/head/image_raw").count, 15u);
  EXPECT_EQ(reference.at("rt/head/depth/image_raw").count, 15u);
  EXPECT_EQ(reference.at("rt/head/camera_info").count, 15u);
  EXPECT_EQ(reference.at("rt/beside/image_raw").count, 5u);
  EXPECT_EQ(reference.count("rt/beside/depth/image_raw"), 0u);
  EXPECT_EQ(reference.at("rt/scan/points").count, 10u);
  EXPECT_EQ(run_and_digest("logged-cyclone", scenario, {"--dds", "cyclone"}), reference);
  EXPECT_EQ(run_and_digest("logged-fast", scenario, {"--dds", "fast"}), reference);
  EXPECT_EQ(run_and_digest("logged-mix", scenario, {"--dds", "fast", "--dds-for", "vision=cyclone"}), reference);
}

TEST(Pictures, LeaveTheRunAsItIsWithoutThem) {
  auto blind = run_and_digest("blind", write_scenario("blind"), {});
  for (const char* more : {"", "logging: {pictures: true}\n"}) {
    auto seen = run_and_digest("seen", write_looking_scenario("seen", kEyes, more), {});
    for (const auto& [topic, digest] : blind) {
      if (topic == "hrp/robot_description") continue;  // it holds the scenario
      EXPECT_EQ(seen[topic], digest) << topic << " " << more;
    }
    EXPECT_EQ(seen.count("rt/head/image_raw"), *more == '\0' ? 0u : 1u) << "logged only when asked for";
  }
  auto without = run_and_digest("without", write_looking_scenario("without", kEyes), {"--without", "vision"});
  EXPECT_EQ(without["hrp/robot_state"], blind["hrp/robot_state"]);
}

// Counts what comes on a topic while a run goes on.
class Watcher {
 public:
  template <typename Message, typename OnMessage>
  Watcher(ServerSet* set, const TopicSpec& topic, OnMessage on_message, const Message*) {
    reader_ = subscribe<Message>(set->bus(), topic, Delivery::kReliable, [this, on_message](const Message& m) {
      on_message(m);
      ++count_;
    });
  }
  int count() const { return count_; }

 private:
  std::atomic<int> count_{0};
  std::unique_ptr<Reader> reader_;
};

class EachVendor : public ::testing::TestWithParam<const char*> {};

TEST_P(EachVendor, AReaderOfRosSeesTheCamera) {
  const std::string scenario = write_looking_scenario("live", kEyes);
  ServerSet set(std::string("live-") + GetParam(), {scenario, "--realtime", "--duration", "0", "--dds", GetParam()});
  std::atomic<bool> whole{true};
  Watcher watcher(
      &set, topics::make_color_image_topic("head"),
      [&](const Image& image) {
        if (image.encoding() != "rgb8" || image.width() != 80 || image.data().size() != 80u * 60 * 3) whole = false;
      },
      static_cast<const Image*>(nullptr));
  EXPECT_TRUE(wait_until([&] { return watcher.count() >= 5; })) << set.output();
  EXPECT_TRUE(whole);
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

TEST_P(EachVendor, AControllerThatWaitsForPicturesGetsThemInLockstep) {
  const std::string scenario = write_looking_scenario("lockstep", kEyes);
  const std::string controller = "controller=" + bin_dir() + "/hrp-odd-looking-controller";
  const auto one =
      run_and_digest(std::string("lockstep-") + GetParam(), scenario, {"--program", controller, "--dds", GetParam()});
  EXPECT_EQ(one.at("hrp/robot_state").count, 501u);
  EXPECT_EQ(run_and_digest("lockstep-reference", scenario, {"--program", controller}), one)
      << "what it saw moved the robot";
}

TEST_P(EachVendor, NothingIsDroppedWhereTheScenarioSaysSo) {
  // Large enough that the run would leave the camera behind.
  const std::string eye =
      "  every_picture: true\n  camera: {wide: {xyz: [0, -2, 1], rpy: [0, 0.1, 1.57], width: 640, height: 480, rate: "
      "20}}\n";
  const std::string scenario = write_looking_scenario("every", eye);
  ServerSet set(std::string("every-") + GetParam(), {scenario, "--paused", "--dds", GetParam()});
  std::set<uint64_t> steps;  // under the mutex of the bus
  Watcher watcher(
      &set, topics::kPictures, [&](const msg::Pictures& m) { steps.insert(m.header().step()); },
      static_cast<const msg::Pictures*>(nullptr));
  ASSERT_TRUE(wait_until([&] { return set.run_status().phase() == msg::RUN_PAUSED; })) << set.output();
  Program tool({"hrp-run", "--domain", std::to_string(set.find_domain()), "run"});
  EXPECT_EQ(tool.wait(), 0) << tool.output();
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_THAT(set.output(), ::testing::Not(HasSubstr("dropped")));
  std::lock_guard<std::recursive_mutex> lock(set.bus().mutex());
  for (uint64_t step = 50; step <= 500; step += 50) EXPECT_EQ(steps.count(step), 1u) << "the picture of step " << step;
}

INSTANTIATE_TEST_SUITE_P(Dds, EachVendor, ::testing::Values("cyclone", "fast"),
                         [](const auto& info) { return info.param; });

TEST(Pictures, OfARunThatIsFasterAreDroppedWholeAndThatIsSaid) {
  const std::string eye =
      "  camera: {wide: {xyz: [0, -2, 1], rpy: [0, 0.1, 1.57], width: 1280, height: 960, rate: 200}}\n";
  ServerSet set("late", {write_looking_scenario("late", eye), "--duration", "0"});
  std::atomic<bool> whole{true};
  Watcher watcher(
      &set, topics::make_color_image_topic("wide"),
      [&](const Image& image) {
        if (image.data().size() != 1280u * 960 * 3) whole = false;
      },
      static_cast<const Image*>(nullptr));
  EXPECT_TRUE(wait_until([&] { return watcher.count() >= 2; })) << set.output();
  EXPECT_TRUE(wait_until([&] { return set.output().find("pictures are dropped") != std::string::npos; }))
      << set.output();
  EXPECT_TRUE(whole);
  set.send_signal(SIGINT);
  EXPECT_EQ(set.wait(), 0) << set.output();
}

TEST(BadCamera, OnAnUnknownLinkIsRefusedWithFileAndLine) {
  ServerSet set("bad-camera", {write_looking_scenario("bad-camera", "  camera:\n    head: {link: NECK_LINK}\n")});
  EXPECT_EQ(set.wait(), 2);
  EXPECT_THAT(set.output(), HasSubstr("bad-camera.yaml:"));
  EXPECT_THAT(set.output(),
              HasSubstr("sensors.camera.head.link: the robot has no link 'NECK_LINK'; did you mean 'NECK_"));
}

}  // namespace
}  // namespace hrp::test

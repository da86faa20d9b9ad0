// SPDX-License-Identifier: BSD-3-Clause
// Signals, series and access rules of the viewer; the page itself is tested in tests/browser.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "common/base/diagnostics.h"
#include "common/messages/cdr.h"
#include "common/robot/signals.h"
#include "hrp_idl/dynamics.h"
#include "servers/viewer/access.h"
#include "servers/viewer/recording.h"
#include "servers/viewer/signal.h"
#include "servers/viewer/viewer.h"

namespace hrp {
namespace {

const StructType& find_type(const std::string& name) { return *get_schema().find_struct("hrp::msg::" + name); }

msg::PairForce make_pair(const std::string& name, double fz, double x) {
  msg::PairForce pair;
  pair.body_b(-1);
  pair.name_a(name);
  pair.total().force().z(fz);
  pair.reference().x(x);
  return pair;
}

class ContactSignals : public ::testing::Test {
 protected:
  ContactSignals() {
    // "left" twice: on the ground and on a step. Its points come after the sums, as in the IDL.
    for (const auto& pair : {make_pair("left", 100, 0.1), make_pair("right", 300, -0.1), make_pair("left", 50, 0.1)})
      forces_.pairs().push_back(pair);
    forces_.header().time(0.25);
  }
  double find(const std::string& path) {
    return Signal(find_type("ContactForces"), path, {}, 0.0).find(encode(forces_, &buffer_));
  }
  msg::ContactForces forces_;
  std::vector<char> buffer_;
};

TEST_F(ContactSignals, AddUpAllPairsOfAName) {
  EXPECT_EQ(find("pairs[left].total.force.z"), 150.0);
  EXPECT_EQ(find("pairs[right].total.force.z"), 300.0);
  EXPECT_EQ(find("pairs[1].total.force.z"), 300.0);
}

TEST_F(ContactSignals, AreZeroForAFootInTheAirAndNothingForAPairThatIsNotThere) {
  EXPECT_EQ(find("pairs[third].total.force.z"), 0.0);
  EXPECT_TRUE(std::isnan(find("pairs[7].total.force.z")));
}

TEST_F(ContactSignals, PlaceTheZmpAtTheCentreOfVerticalForces) {
  // (150 x 0.1 - 300 x 0.1) / 450; exact but for the rounding of a few sums.
  EXPECT_NEAR(find("zmp.x"), -15.0 / 450.0, 1e-15);
  EXPECT_NEAR(find("zmp.y"), 0.0, 1e-15);
}

TEST_F(ContactSignals, PlaceTheZmpOnObstaclesAtTheHeightOfTheirPointsWhereThereIsNoPlane) {
  for (auto& pair : forces_.pairs()) {
    pair.body_b(-2);
    pair.total().force().x(10);
    msg::PointForce point;
    point.p_WC().z(0.5);
    point.total().z(pair.total().force().z());
    pair.points().push_back(point);
  }
  const Signal zmp(find_type("ContactForces"), "zmp.x", {}, std::nan(""));
  // 30 N forward act at height 0: half a metre above it the line of action is 0.5 x 30 / 450 further on.
  EXPECT_NEAR(zmp.find(encode(forces_, &buffer_)), -15.0 / 450.0 + 0.5 * 30.0 / 450.0, 1e-15);
  EXPECT_TRUE(std::isnan(find("zmp.x"))) << "nothing touches the plane";
}

TEST_F(ContactSignals, PlaceTheZmpOfEachRobotWithItsOwnForces) {
  for (const auto& pair : {make_pair("partner/left", 100, 2.0), make_pair("partner/right", 100, 3.0)}) {
    forces_.pairs().push_back(pair);
    forces_.pairs().back().body_a(kFirstObject);
  }
  EXPECT_EQ(find("partner/zmp.x"), 2.5);
  EXPECT_NEAR(find("zmp.x"), -15.0 / 450.0, 1e-15);
  EXPECT_TRUE(std::isnan(find("walker/zmp.x")));
}

TEST_F(ContactSignals, SayWhatIsWrongWithAPath) {
  for (const char* path :
       {"", "pair", "pairs", "pairs[0]", "pairs[0", "pairs[0]x", "header.time.x", "pairs[0].name_a", "."}) {
    EXPECT_THROW(find(path), InputError) << path;
  }
  EXPECT_THROW(split_signal("no colon"), InputError);
}

TEST(JointSignals, AreFoundByTheNameOfTheJoint) {
  msg::RobotState state;
  state.positions({1.0, 2.0, 3.0});
  std::vector<char> buffer;
  const Bytes sample = encode(state, &buffer);
  EXPECT_EQ(Signal(find_type("RobotState"), "positions[knee]", {"hip", "knee"}, 0).find(sample), 2.0);
  EXPECT_EQ(Signal(find_type("RobotState"), "positions[2]", {}, 0).find(sample), 3.0);
  EXPECT_THROW(Signal(find_type("RobotState"), "positions[nee]", {"hip", "knee"}, 0), InputError);
}

TEST(Series, KeepTheirPeaksWhenThinnedOut) {
  Series series;
  for (int i = 0; i < 10000; ++i) {
    series.times.push_back(i);
    series.values.push_back(i == 6789 ? 1000.0 : i % 2);
  }
  const Series thin = thin_out(series, 100);
  EXPECT_LE(thin.times.size(), 100u);
  EXPECT_EQ(*std::max_element(thin.values.begin(), thin.values.end()), 1000.0);
  EXPECT_TRUE(std::is_sorted(thin.times.begin(), thin.times.end()));
}

TEST(Series, SubtractAtTheTimesOfTheFirstAlignedAtTheirBegins) {
  const Series first{{10, 11, 12, 13}, {1, 2, 3, 4}, "N"}, second{{0, 2}, {0, 2}, "N"};
  const Series difference = subtract(first, 10, second, 0);
  EXPECT_EQ(difference.times, (std::vector<double>{10, 11, 12}));  // the second one has no 13th second
  EXPECT_EQ(difference.values, (std::vector<double>{1, 1, 1}));
}

class Answers final : public Connection {
 public:
  bool send(Payload payload, bool, Urgency) override {
    last = *payload;
    return true;
  }
  std::string last;
};

// A number beyond every size_t became 0 on its way: the page got the first recording in the place of an answer.
TEST(Pages, HearThatARecordingIsNotThereHoweverLargeItsNumber) {
  auto recording = std::make_unique<Recording>("run");
  Scene scene;
  scene.json = "{}";
  recording->set_scene(scene);
  std::vector<std::unique_ptr<Recording>> recordings;
  recordings.push_back(std::move(recording));
  Viewer viewer{{}};
  viewer.show(std::move(recordings));
  Answers answers;
  const auto page = viewer.make_page_client(answers);
  for (const char* source : {"1", "-1", "1e300", "18446744073709551616"}) {
    page->on_message(std::string("{\"op\":\"open\",\"source\":") + source + "}", false);
    EXPECT_NE(answers.last.find("no such recording"), std::string::npos) << source << ": " << answers.last;
  }
  page->on_message("{\"op\":\"open\",\"source\":0}", false);
  EXPECT_NE(answers.last.find("\"op\":\"scene\""), std::string::npos) << answers.last;
}

AccessRequest make_request(const std::string& host, const std::string& origin = "", const std::string& target = "/") {
  AccessRequest request;
  request.host = host;
  request.origin = origin;
  request.target = target;
  return request;
}

TEST(Access, IsForThisMachineAndItsOwnPageOnly) {
  const AccessRules rules;
  EXPECT_EQ(find_refusal(rules, make_request("127.0.0.1:80")), "");
  EXPECT_EQ(find_refusal(rules, make_request("localhost:80", "http://localhost:80")), "");
  EXPECT_EQ(find_refusal(rules, make_request("[::1]:80")), "");
  EXPECT_NE(find_refusal(rules, make_request("evil.example")), "");
  EXPECT_NE(find_refusal(rules, make_request("127.0.0.1.evil.example")), "");
  EXPECT_NE(find_refusal(rules, make_request("127.0.0.1:80", "http://evil.example")), "");
  EXPECT_NE(find_refusal(rules, make_request("127.0.0.1:80", "http://127.0.0.1:81")), "");
  AccessRequest foxglove = make_request("127.0.0.1:80", "https://app.foxglove.dev");
  EXPECT_NE(find_refusal(rules, foxglove), "");
  foxglove.foxglove = true;
  EXPECT_EQ(find_refusal(rules, foxglove), "");
  for (const char* origin : {"https://evilfoxglove.dev", "https://user.foxglove.dev", "http://app.foxglove.dev",
                             "https://app.foxglove.dev:81"}) {
    foxglove.origin = origin;
    EXPECT_NE(find_refusal(rules, foxglove), "") << origin;
  }
}

TEST(Access, OriginsAreComparedWhole) {
  const AccessRules rules;
  for (const char* origin : {"file://", "null", "file://127.0.0.1:80", "chrome-extension://127.0.0.1:80",
                             "https://127.0.0.1:80", "127.0.0.1:80"}) {
    EXPECT_NE(find_refusal(rules, make_request("127.0.0.1:80", origin)), "") << origin;
  }
  EXPECT_NE(find_refusal({"", false, 80}, make_request("", "file://")), "") << "without a host nothing is one's own";
}

TEST(Access, NeedsTheTokenWhereThereIsOne) {
  const AccessRules rules{"sesame", false, 8080};
  EXPECT_NE(find_refusal(rules, make_request("robot.lan")), "");
  EXPECT_NE(find_refusal(rules, make_request("robot.lan", "", "/?token=sesam")), "");
  EXPECT_EQ(find_refusal(rules, make_request("robot.lan", "", "/ws?x=1&token=sesame")), "");
  AccessRequest cookie = make_request("robot.lan");
  cookie.cookie = "a=b; hrp_viewer_token_8080=sesame; c=d";
  EXPECT_EQ(find_refusal(rules, cookie), "");
  cookie.cookie = "hrp_viewer_token_8081=sesame; x=hrp_viewer_token_8080=sesame";
  EXPECT_NE(find_refusal(rules, cookie), "") << "of a viewer at another port; within another value";
  EXPECT_NE(make_token(), make_token());
}

TEST(Meshes, AreServedOnlyFromTheFoldersOfTheUrdfThatNamesThem) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) /
                          ("hrp_viewer_meshes_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()));
  fs::create_directories(folder / "robot" / "meshes");
  for (const char* name : {"secret.stl", "robot/meshes/foot.stl", "robot/meshes/unnamed.stl"})
    std::ofstream(folder / name) << "solid";
  fs::create_symlink(folder / "secret.stl", folder / "robot" / "meshes" / "link.stl");
  Scene scene;
  scene.urdf_path = (folder / "robot" / "robot.urdf").string();
  scene.urdf =
      "<mesh filename=\"meshes/foot.stl\"/><mesh filename=\"../secret.stl\"/><mesh filename=\"meshes/link.stl\"/>"
      "<mesh filename=\"package://robot/meshes/foot.stl\"/><mesh filename=\"package://robot/../secret.stl\"/>"
      "<mesh filename=\"/etc/passwd\"/>";
  EXPECT_TRUE(read_mesh(scene, "meshes/foot.stl"));
  EXPECT_TRUE(read_mesh(scene, "package://robot/meshes/foot.stl"));
  EXPECT_FALSE(read_mesh(scene, "meshes/unnamed.stl")) << "the URDF does not name it";
  EXPECT_FALSE(read_mesh(scene, "../secret.stl"));
  EXPECT_FALSE(read_mesh(scene, "package://robot/../secret.stl"));
  EXPECT_FALSE(read_mesh(scene, "meshes/link.stl")) << "a link that leads out";
  EXPECT_FALSE(read_mesh(scene, "/etc/passwd")) << "no mesh";
  fs::remove_all(folder);
}

// A field of 3 x 2 heights, as the model parser sends it.
msg::RobotDescription make_land() {
  msg::RobotDescription description;
  description.scenario(
      "robot: a.urdf\nobstacles: {land: {shape: height_field, file: a.csv, spacing: 0.5, position: [1, 2, 3]}}\n");
  msg::SurfaceDescription land;
  land.obstacle("land");
  land.columns(3);
  land.rows(2);
  land.spacing(0.5);
  land.heights({1, 2, 3, 4, 5, 6});
  description.surfaces().push_back(land);
  return description;
}

TEST(SceneOfAPage, HasTheTrianglesOfASurface) {
  const auto obstacle = nlohmann::json::parse(make_scene(make_land()).json)["obstacles"].at(0);
  EXPECT_EQ(obstacle["shape"], "height_field");
  EXPECT_EQ(obstacle["position"], nlohmann::json({1.0, 2.0, 3.0}));
  EXPECT_EQ(obstacle["vertices"].size(), 3u * 6u);
  EXPECT_EQ(obstacle["vertices"].at(2), 1.0) << "height of the first one";
  EXPECT_EQ(obstacle["triangles"].size(), 3u * 4u);
}

TEST(SceneOfAPage, LeavesOutASurfaceThatMakesNoSense) {
  msg::RobotDescription description = make_land();
  description.surfaces()[0].columns(1000000);
  const auto broken = nlohmann::json::parse(make_scene(description).json)["obstacles"].at(0);
  EXPECT_TRUE(broken["triangles"].empty());
  description.surfaces().clear();
  const auto missing = nlohmann::json::parse(make_scene(description).json)["obstacles"].at(0);
  EXPECT_TRUE(missing["triangles"].empty());
}

}  // namespace
}  // namespace hrp

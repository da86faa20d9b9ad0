// SPDX-License-Identifier: BSD-3-Clause
// Pictures of cameras on their way to a page: what is read of a sample, what is refused, and that nobody reads unless a
// page looks. tests/browser/cameras_test.mjs looks at the pixels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include <nlohmann/json.hpp>

#include "common/bus/memory/memory_bus.h"
#include "common/mcap/writer.h"
#include "common/messages/pubsub.h"
#include "common/messages/ros_topics.h"
#include "hrp_idl/ros_views.h"
#include "servers/viewer/picture_feed.h"
#include "servers/viewer/picture_message.h"
#include "servers/viewer/viewer.h"
#include "tests/catch_complaint.h"

namespace hrp {
namespace {

using Image = ::sensor_msgs::msg::dds_::Image_;
using PointCloud = ::sensor_msgs::msg::dds_::PointCloud2_;
using Ms = std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Image make_image(const std::string& encoding, uint32_t width, uint32_t height, uint32_t step,
                 const std::vector<uint8_t>& data) {
  Image image;
  image.header().stamp().sec(2);
  image.header().stamp().nanosec(500000000);
  image.encoding(encoding);
  image.width(width);
  image.height(height);
  image.step(step);
  image.data(data);
  return image;
}

Picture read(const Image& image) {
  std::vector<char> buffer;
  return read_picture(encode(image, &buffer), kMostPagePixels);
}

std::string find_error(const Image& image) {
  return catch_complaint<PictureError>([&] { read(image); });
}

std::vector<float> get_depths(const Picture& picture) {
  std::vector<float> depths(picture.pixels.size() / sizeof(float));
  std::memcpy(depths.data(), picture.pixels.data(), picture.pixels.size());
  return depths;
}

TEST(Pictures, OfColorAreRedGreenBlueWithoutTheGapsBetweenRows) {
  const Picture rgb = read(make_image("rgb8", 2, 2, 8, {1, 2, 3, 4, 5, 6, 99, 99, 7, 8, 9, 10, 11, 12, 99, 99}));
  EXPECT_EQ(rgb.pixels, std::string("\1\2\3\4\5\6\7\10\11\12\13\14", 12));
  EXPECT_EQ(rgb.time, 2.5);
  EXPECT_EQ(read(make_image("bgr8", 1, 1, 3, {3, 2, 1})).pixels, "\1\2\3");
  EXPECT_EQ(read(make_image("bgra8", 1, 1, 4, {3, 2, 1, 9})).pixels, "\1\2\3");
  EXPECT_EQ(read(make_image("mono8", 2, 1, 2, {7, 8})).pixels, "\7\7\7\10\10\10");
}

TEST(Pictures, OfDepthAreMetres) {
  std::vector<uint8_t> bytes(8);
  const float depths[] = {1.25f, std::numeric_limits<float>::infinity()};
  std::memcpy(bytes.data(), depths, 8);
  const Picture picture = read(make_image("32FC1", 2, 1, 8, bytes));
  EXPECT_EQ(picture.kind, Picture::Kind::kDepth);
  EXPECT_THAT(get_depths(picture), ElementsAre(1.25f, std::numeric_limits<float>::infinity()));
  // 2 x 256 + 88 = 600 mm, and nothing in sight.
  EXPECT_THAT(get_depths(read(make_image("16UC1", 2, 1, 4, {88, 2, 0, 0}))),
              ElementsAre(0.6f, std::numeric_limits<float>::infinity()));
}

TEST(Pictures, ThatMakeNoSenseSayWhichFieldIsWrong) {
  const std::vector<uint8_t> six(6);
  EXPECT_EQ(find_error(make_image("rgb8", 2, 1, 6, six)), "");
  EXPECT_EQ(find_error(make_image("rgb8", 2, 1, 5, six)),
            "the picture's step is 5 bytes, expected at least 6: 2 pixels of rgb8");
  EXPECT_EQ(find_error(make_image("rgb8", 2, 2, 6, six)),
            "the picture's data is 6 bytes, expected 12: height times step");
  EXPECT_THAT(find_error(make_image("yuv422", 2, 1, 6, six)),
              HasSubstr("encoding is 'yuv422', expected one of rgb8, "));
  EXPECT_THAT(find_error(make_image("rgb8", 0, 1, 6, six)), HasSubstr("width is 0"));
  EXPECT_THAT(find_error(make_image("rgb8", 2, 0, 6, {})), HasSubstr("height is 0"));
  // Sizes whose product is beyond 32 bits, and just within 64.
  EXPECT_THAT(find_error(make_image("32FC1", 0xffffffff, 0xffffffff, 0xffffffff, six)),
              HasSubstr("step is 4294967295 bytes, expected at least 17179869180"));
  EXPECT_THAT(find_error(make_image("mono8", 0xffffffff, 0xffffffff, 0xffffffff, six)),
              HasSubstr("expected 18446744065119617025"));
  Image big = make_image("32FC1", 1, 1, 4, {0, 0, 0, 0});
  big.is_bigendian(1);
  EXPECT_THAT(find_error(big), HasSubstr("is_bigendian is 1"));
}

TEST(Pictures, OfAnyBytesAreReadOrRefused) {
  std::vector<char> buffer;
  const Bytes whole = encode(make_image("rgb8", 8, 4, 24, std::vector<uint8_t>(96, 7)), &buffer);
  for (size_t size = 0; size < whole.size; ++size) EXPECT_THROW(read_picture({whole.data, size}), PictureError) << size;
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    std::vector<uint8_t> bytes(whole.data, whole.data + whole.size);
    for (int k = 0; k < 3; ++k) bytes[random() % 64] = static_cast<uint8_t>(random());
    try {
      const Picture picture = read_picture({bytes.data(), bytes.size()});
      EXPECT_LE(picture.pixels.size(), 4u * 96u);
    } catch (const PictureError&) {
    }
  }
}

TEST(Pictures, ThatAreLargeAreThinned) {
  std::vector<uint8_t> data(1300 * 900);
  for (size_t i = 0; i < data.size(); ++i) data[i] = static_cast<uint8_t>(i % 1300 % 256);
  const Picture picture = read(make_image("mono8", 1300, 900, 1300, data));
  EXPECT_EQ(picture.stride, 2u) << "650 x 450 is no more than 640 x 480";
  EXPECT_EQ(picture.width, 650u);
  EXPECT_EQ(picture.height, 450u);
  EXPECT_EQ(static_cast<uint8_t>(picture.pixels[3 * 100]), 200);
}

PointCloud make_scan(const std::vector<float>& numbers, uint32_t width) {
  PointCloud scan;
  for (const char* name : {"x", "y", "z"}) {
    auto& field = scan.fields().emplace_back();
    field.name(name);
    field.offset(static_cast<uint32_t>(4 * (scan.fields().size() - 1)));
    field.datatype(7);
    field.count(1);
  }
  scan.width(width);
  scan.height(1);
  scan.point_step(12);
  scan.row_step(12 * width);
  scan.data().resize(4 * numbers.size());
  std::memcpy(scan.data().data(), numbers.data(), scan.data().size());
  return scan;
}

std::string find_error(const PointCloud& scan) {
  std::vector<char> buffer;
  return catch_complaint<PictureError>([&] { read_scan(encode(scan, &buffer)); });
}

TEST(Scans, AreThePointsThatWereSeen) {
  const float nan = std::nanf("");
  std::vector<char> buffer;
  const Picture picture = read_scan(encode(make_scan({1, 2, 3, nan, nan, nan, 4, 5, 6}, 3), &buffer));
  EXPECT_EQ(picture.width, 2u);
  EXPECT_THAT(get_depths(picture), ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(Scans, ThatMakeNoSenseSayWhichFieldIsWrong) {
  const PointCloud good = make_scan({1, 2, 3}, 1);
  EXPECT_EQ(find_error(good), "");
  PointCloud bad = good;
  bad.point_step(8);
  EXPECT_THAT(find_error(bad), HasSubstr("point_step is 8 bytes, expected at least 12: the end of z"));
  bad = good;
  bad.fields()[1].offset(0xffffffff);
  EXPECT_THAT(find_error(bad), HasSubstr("the end of y"));
  bad = good;
  bad.fields()[0].datatype(8);
  EXPECT_THAT(find_error(bad), HasSubstr("datatype of x is 8"));
  bad = good;
  bad.fields().pop_back();
  EXPECT_THAT(find_error(bad), HasSubstr("without z"));
  bad = good;
  bad.width(2);
  EXPECT_THAT(find_error(bad), HasSubstr("row_step is 12 bytes, expected at least 24"));
  bad = good;
  bad.height(2);
  EXPECT_THAT(find_error(bad), HasSubstr("data is 12 bytes, expected 24"));
}

nlohmann::json read_head(const std::string& message, std::string* pixels = nullptr) {
  uint32_t length = 0;
  std::memcpy(&length, message.data(), 4);
  EXPECT_EQ(length % 4, 0u);
  if (pixels) *pixels = message.substr(4 + length);
  return nlohmann::json::parse(message.substr(4, length));
}

TEST(PictureMessages, AreATextAndPixels) {
  std::string pixels;
  const auto head =
      read_head(make_picture_message(1, "rt/eye/image_raw", read(make_image("mono8", 2, 1, 2, {7, 8}))), &pixels);
  EXPECT_EQ(
      head,
      nlohmann::json::parse(
          R"({"op":"picture","source":1,"topic":"rt/eye/image_raw","time":2.5,"kind":"color","width":2,"height":1,"stride":1})"));
  EXPECT_EQ(pixels, "\7\7\7\10\10\10");
  EXPECT_EQ(read_head(make_picture_message(0, "rt/eye/image_raw", std::string("\xff why")))["error"],
            "\xef\xbf\xbd why");
}

TEST(PictureFeeds, SendEachPictureOnceAndTenASecond) {
  const PictureKey eye{0, "eye"}, ear{0, "ear"};
  const PictureFeed::Clock::time_point start{std::chrono::hours(1)};
  PictureFeed feed;
  feed.show({eye});
  EXPECT_EQ(feed.find_due(start).size(), 1u);
  EXPECT_FALSE(feed.has(eye, 0)) << "that there is none has to be said, too";
  feed.note_sent(eye, 5, start);
  EXPECT_TRUE(feed.has(eye, 5));
  EXPECT_TRUE(feed.find_due(start + Ms(99)).empty());
  EXPECT_EQ(feed.find_due(start + Ms(100)).size(), 1u);
  feed.show({eye, ear});
  EXPECT_TRUE(feed.has(eye, 5)) << "it is still on the screen";
  feed.note_sent(ear, 1, start + Ms(20));
  const auto due = feed.find_due(start + Ms(200));
  ASSERT_EQ(due.size(), 2u);
  EXPECT_EQ(due[0].topic, "eye") << "it has waited longer";
  feed.forget();
  EXPECT_FALSE(feed.has(eye, 5));
}

class Answers final : public Connection {
 public:
  bool send(Payload payload, bool binary, Urgency urgency) override {
    if (full && urgency == Urgency::kPicture) return false;
    (binary ? pictures : texts).push_back(*payload);
    return true;
  }
  nlohmann::json last_picture() const { return pictures.empty() ? nlohmann::json() : read_head(pictures.back()); }
  std::vector<std::string> texts, pictures;
  bool full = false;
};

class LivePage : public ::testing::Test {
 protected:
  LivePage() {
    viewer_.show(std::make_unique<LiveRun>(bus_, true));
    page_ = viewer_.make_page_client(answers_);
    viewer_.tick();
  }
  void look(const char* topics) {
    page_->on_message(std::string("{\"op\":\"pictures\",\"topics\":") + topics + "}", false);
    viewer_.tick();
  }
  void publish(const Image& image) {
    eye_.publish(image);
    bus_.dispatch_all();
    viewer_.tick();
  }
  MemoryBus bus_;
  Publisher<Image> eye_{bus_, topics::make_color_image_topic("eye")};
  Viewer viewer_{{}};
  Answers answers_;
  std::unique_ptr<Client> page_;
};

TEST_F(LivePage, ReadsACameraOnlyWhileItShowsIt) {
  EXPECT_FALSE(eye_.has_readers());
  page_->on_message(R"({"op":"peek","topic":"rt/eye/image_raw"})", false);
  page_->on_message(R"({"op":"subscribe","signals":["rt/eye/image_raw:width"]})", false);
  viewer_.tick();
  EXPECT_FALSE(eye_.has_readers()) << "charts and lists of signals read no pictures";
  look(R"(["rt/eye/image_raw"])");
  EXPECT_TRUE(eye_.has_readers());
  look("[]");
  EXPECT_FALSE(eye_.has_readers());
  look(R"(["rt/eye/image_raw"])");
  page_.reset();
  viewer_.tick();
  EXPECT_FALSE(eye_.has_readers()) << "the page is gone";
}

TEST_F(LivePage, GetsAPictureOnceAndTheNewestWhenThereIsRoom) {
  look(R"(["rt/eye/image_raw"])");
  EXPECT_TRUE(answers_.pictures.empty());
  answers_.full = true;
  publish(make_image("mono8", 1, 1, 1, {1}));
  publish(make_image("mono8", 1, 1, 1, {2}));
  EXPECT_TRUE(answers_.pictures.empty());
  answers_.full = false;
  viewer_.tick();
  viewer_.tick();
  ASSERT_EQ(answers_.pictures.size(), 1u);
  EXPECT_EQ(answers_.pictures[0].back(), 2);
}

TEST_F(LivePage, HearsWhatIsWrongWithAPicture) {
  look(R"(["rt/eye/image_raw","rt/nobody/image_raw","hrp/robot_state"])");
  publish(make_image("mono8", 9, 1, 1, {1}));
  EXPECT_THAT(answers_.last_picture()["error"], HasSubstr("step is 1 bytes, expected at least 9"));
}

TEST_F(LivePage, IsCutOffWhenItAsksForNonsense) {
  const std::string many = nlohmann::json(std::vector<std::string>(17, "a")).dump();
  for (const char* topics : {"1", "[1]", many.c_str()}) EXPECT_THROW(look(topics), ProtocolError) << topics;
}

TEST_F(LivePage, FoxgloveReadsTheSameCameraByItsNameInRos2) {
  Answers foxglove;
  const auto client = viewer_.make_foxglove_client(foxglove);
  const auto channel = nlohmann::json::parse(foxglove.texts.at(1))["channels"].at(0);
  EXPECT_EQ(channel["topic"], "/eye/image_raw");
  EXPECT_EQ(channel["schemaName"], "sensor_msgs/msg/Image");
  EXPECT_EQ(channel["schemaEncoding"], "ros2msg");
  client->on_message(R"({"op":"subscribe","subscriptions":[{"id":3,"channelId":)" + channel["id"].dump() + "}]}",
                     false);
  viewer_.tick();
  const Image image = make_image("mono8", 1, 1, 1, {1});
  publish(image);
  ASSERT_EQ(foxglove.pictures.size(), 1u);
  std::vector<char> buffer;
  const Bytes sample = encode(image, &buffer);
  const std::string& data = foxglove.pictures[0];
  EXPECT_EQ(data.substr(13), std::string(reinterpret_cast<const char*>(sample.data), sample.size));
  uint64_t time = 0;
  std::memcpy(&time, data.data() + 5, 8);
  EXPECT_EQ(time, 2500000000u);
}

// Ten pictures, one each 0.1 s, in chunks of three, the n-th one with the value n.
std::string make_log(const std::string& name) {
  std::string path = (std::filesystem::path(testing::TempDir()) / name).string();
  mcap::Writer writer(mcap::ClaimedFile(path, mcap::Existing::kReplace), mcap::Compression::kZstd);
  const std::string type = topics::make_color_image_topic("").type_name;
  const uint16_t schema = writer.add_schema(type, "omgidl", find_schema_text(type));
  const uint16_t eye = writer.add_channel("rt/eye/image_raw", schema, "cdr"),
                 ear = writer.add_channel("rt/ear/image_raw", schema, "cdr");
  std::vector<char> buffer;
  for (uint8_t i = 1; i <= 10; ++i) {
    for (const uint16_t channel : {ear, eye}) {
      const Bytes sample =
          encode(make_image("mono8", 1, 1, 1, {static_cast<uint8_t>(channel == eye ? i : 100 + i)}), &buffer);
      mcap::Message message;
      message.channel_id = channel;
      message.log_time = message.publish_time = i * 100000000ull;
      message.data = sample.data;
      message.size = sample.size;
      writer.add_message(message);
    }
    if (i % 3 == 0) writer.write_chunk();
  }
  writer.close();
  return path;
}

TEST(RecordedPictures, AreThoseOfTheirTime) {
  const auto recording = read_log(make_log("hrp_viewer_pictures.mcap"));
  ASSERT_NE(recording->pictures(), nullptr);
  PictureLog& pictures = *recording->pictures();
  EXPECT_EQ(pictures.find("rt/eye/image_raw", 0.099), 0u);
  EXPECT_EQ(pictures.find("rt/eye/image_raw", 0.1), 1u);
  EXPECT_EQ(pictures.find("rt/eye/image_raw", 0.199), 1u);
  EXPECT_EQ(pictures.find("rt/eye/image_raw", 1e300), 10u);
  EXPECT_EQ(pictures.find("rt/eye/image_raw", std::nan("")), 0u);
  EXPECT_EQ(pictures.find("rt/nobody/image_raw", 1.0), 0u);
  for (uint64_t number = 10; number > 0; --number) {
    const PictureBytes sample = pictures.read("rt/eye/image_raw", number);
    ASSERT_TRUE(sample);
    EXPECT_EQ(read_picture({sample->data(), sample->size()}).pixels[0], static_cast<char>(number));
  }
  EXPECT_FALSE(pictures.read("rt/eye/image_raw", 11));
}

TEST(RecordedPictures, FollowThePageThroughTheLog) {
  std::vector<std::unique_ptr<Recording>> recordings;
  for (int i = 0; i < 2; ++i) recordings.push_back(read_log(make_log("hrp_viewer_pictures.mcap")));
  Viewer viewer{{}};
  viewer.show(std::move(recordings));
  Answers answers;
  const auto page = viewer.make_page_client(answers);
  page->on_message(R"({"op":"pictures","topics":["rt/eye/image_raw"]})", false);
  viewer.tick();
  EXPECT_EQ(answers.last_picture()["error"], "no picture at or before this time");
  const auto go = [&](const char* at) {
    page->on_message(at, false);
    page->on_message(R"({"op":"pictures","topics":["rt/eye/image_raw"]})", false);  // so that no time passes
    answers.pictures.clear();
    viewer.tick();
  };
  go(R"({"op":"at","time":0.45,"sources":[0]})");
  ASSERT_EQ(answers.pictures.size(), 1u);
  EXPECT_EQ(answers.pictures[0].back(), 4);
  go(R"({"op":"at","time":0.7,"sources":[0,1]})");
  ASSERT_EQ(answers.pictures.size(), 2u) << "two recordings side by side";
  EXPECT_EQ(read_head(answers.pictures[1])["source"], 1);
  EXPECT_EQ(answers.pictures[1].back(), 7);
}

}  // namespace
}  // namespace hrp

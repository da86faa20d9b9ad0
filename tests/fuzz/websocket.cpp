// SPDX-License-Identifier: BSD-3-Clause
// Messages of a client that was let in, each a WebSocket frame: a line of the input. The first byte says who asks what:
// bit 0 a page or Foxglove; bits 1 and 2 a viewer of a live run, of one read-only, of two recordings, or of nothing.
// Beside the sanitizers' findings a JSON answer that no page could read ends the target.
#include <cstdlib>
#include <sstream>

#include <nlohmann/json.hpp>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/ros_topics.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/ros_views.h"
#include "servers/viewer/viewer.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace hrp;

using Image = ::sensor_msgs::msg::dds_::Image_;
enum Shown { kLive, kReadOnly, kRecordings, kNothing };

class Strict final : public Connection {
 public:
  bool send(Payload payload, bool binary, Urgency) override {
    if (answers && !binary && !nlohmann::json::accept(*payload)) std::abort();
    return true;
  }
  bool answers = false;  // the greeting is always the same, and long
};

msg::RobotState make_state(uint64_t step) {
  msg::RobotState state;
  state.header().step(step);
  state.header().time(1e-3 * static_cast<double>(step));
  state.positions({0.1, 0.2 * static_cast<double>(step)});
  state.velocities({0.0, 200.0});
  return state;
}

msg::ContactForces make_forces(uint64_t step) {
  msg::PairForce pair;
  pair.body_b(-1);
  pair.name_a("left");
  pair.total().force().z(100.0);
  msg::ContactForces forces;
  forces.header(make_state(step).header());
  forces.pairs().push_back(pair);
  return forces;
}

// Every other one makes no sense.
Image make_image(uint8_t number) {
  Image image;
  image.encoding("mono8");
  image.width(number % 2);
  image.height(1);
  image.step(1);
  image.data({number});
  return image;
}

template <typename Message>
void add(Recording* recording, const TopicSpec& topic, const Message& message) {
  std::vector<char> buffer;
  recording->add(topic.name, message.header().time(), encode(message, &buffer));
}

// Begins at `first` steps, so that two of them overlap only in part.
std::unique_ptr<Recording> make_recording(uint64_t first) {
  auto recording = std::make_unique<Recording>("run " + std::to_string(first));
  for (const TopicSpec* topic : {&topics::kRobotState, &topics::kContactForces}) {
    recording->add_topic(topic->name, get_schema().find_struct(topic->type_name), "");
  }
  for (uint64_t step = first; step < first + 4; ++step) {
    add(recording.get(), topics::kRobotState, make_state(step));
    add(recording.get(), topics::kContactForces, make_forces(step));
  }
  recording->finish();
  return recording;
}

// A viewer, and for a live one its run: a server that writes and a scheduler that listens.
struct World {
  explicit World(Shown shown) {
    if (shown == kRecordings) {
      std::vector<std::unique_ptr<Recording>> recordings;
      for (const uint64_t first : {0, 2}) recordings.push_back(make_recording(first));
      viewer.show(std::move(recordings));
    } else if (shown != kNothing) {
      states = Publisher<msg::RobotState>(bus, topics::kRobotState);
      forces = Publisher<msg::ContactForces>(bus, topics::kContactForces);
      eye = Publisher<Image>(bus, topics::make_color_image_topic("eye"));
      scheduler =
          subscribe<msg::RunControl>(bus, topics::kRunControl, Delivery::kReliable, [](const msg::RunControl&) {});
      viewer.show(std::make_unique<LiveRun>(bus, shown == kReadOnly));
    }
  }
  void step() {
    if (!scheduler) return;
    states.publish(make_state(++steps));
    forces.publish(make_forces(steps));
    eye.publish(make_image(static_cast<uint8_t>(steps)));
    bus.dispatch_all();
    viewer.tick();
  }
  MemoryBus bus;
  Publisher<msg::RobotState> states;
  Publisher<msg::ContactForces> forces;
  Publisher<Image> eye;
  std::unique_ptr<Reader> scheduler;
  Viewer viewer{{}};
  uint64_t steps = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  World world(static_cast<Shown>(data[0] / 2 % 4));
  Strict connection;
  world.step();
  const auto client =
      data[0] % 2 == 0 ? world.viewer.make_page_client(connection) : world.viewer.make_foxglove_client(connection);
  connection.answers = true;
  std::istringstream lines(hrp::test::make_text(data + 1, size - 1));
  for (std::string line; std::getline(lines, line);) {
    try {
      // Ends with a space: a binary frame.
      client->on_message(line, !line.empty() && line.back() == ' ');
    } catch (const hrp::ProtocolError&) {
      return 0;  // such a client is cut off
    }
    world.step();
  }
  return 0;
}

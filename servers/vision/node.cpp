// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/node.h"

#include <algorithm>

#include "common/messages/convert_robot.h"
#include "common/messages/ros_topics.h"

namespace hrp {
namespace {

// Asking who reads costs a lock of the bus.
constexpr auto kReadersPeriod = std::chrono::milliseconds(10);
// Progress is reported at least this often while the run waits for pictures: a quarter of the scheduler's window.
constexpr uint64_t kReportSteps = 16;
// A run that stands still before its first step repeats it every 50 ms; pictures are large.
constexpr auto kRepeatPeriod = std::chrono::milliseconds(200);
// The scheduler lets a run that waits get this far ahead: eight windows, and what was granted on top of them.
constexpr uint64_t kMostAhead = 1024;

}  // namespace

VisionNode::VisionNode(const NodeContext& context) : NodeBase(context) {
  listen<msg::RobotDescription>(topics::kRobotDescription,
                                [this](const msg::RobotDescription& m) { take_description(m); });
}

void VisionNode::take_description(const msg::RobotDescription& message) {
  if (worker_) return;
  RobotDescription robot;
  from_message(message, &robot);
  scenario_ = parse_scenario(robot.scenario, robot.scenario_path);
  waited_for_ = scenario_.sensors.every_picture || scenario_.logging.pictures;
  auto maker = std::make_unique<PictureMaker>(robot, scenario_);
  std::string notes;
  for (const std::string& note : maker->notes()) notes += "\n  not drawn: " + note;
  if (!notes.empty()) say("some meshes cannot be read" + notes);
  worker_ =
      std::make_unique<LookWorker>(std::move(maker), waited_for_ ? LookWorker::Late::kQueue : LookWorker::Late::kDrop);
}

// Of each topic: what can be under way while a run waits, else as few as possible.
int VisionNode::find_depth() const {
  constexpr int kLeast = 4;
  if (!waited_for_) return kLeast;
  double rate = 0.0;
  for (const CameraSpec& camera : scenario_.sensors.cameras) rate = std::max(rate, camera.rate);
  for (const LidarSpec& lidar : scenario_.sensors.lidars) rate = std::max(rate, lidar.rate);
  return kLeast + static_cast<int>(static_cast<double>(kMostAhead) * scenario_.time_step * rate);
}

std::vector<VisionNode::SensorViews> VisionNode::make_views() {
  std::vector<SensorViews> views;
  const auto add = [&](auto* list, TopicSpec topic) {
    topic.depth = find_depth();
    list->resize(1);
    list->front().topic = topic.name;
    list->front().publisher = {bus(), topic};
  };
  for (const CameraSpec& camera : scenario_.sensors.cameras) {
    SensorViews& sensor = views.emplace_back();
    add(&sensor.info, topics::make_camera_info_topic(camera.name));
    if (camera.color) add(&sensor.color, topics::make_color_image_topic(camera.name));
    if (camera.depth) add(&sensor.depth, topics::make_depth_image_topic(camera.name));
  }
  for (const LidarSpec& lidar : scenario_.sensors.lidars)
    add(&views.emplace_back().points, topics::make_points_topic(lidar.name));
  return views;
}

// A reader of every state costs the run a datagram a step: there is none before somebody looks.
void VisionNode::start_watching() {
  if (watches_ || !views_made_ || !(waited_for_ || any_wanted_)) return;
  watches_ = true;
  listen<msg::RobotState>(topics::kRobotState, [this](const msg::RobotState& m) { take_state(m); });
}

void VisionNode::make_endpoints() {
  start_watching();
  NodeBase::make_endpoints();
  if (views_made_) return;
  {
    std::lock_guard<std::recursive_mutex> lock(bus().mutex());
    if (!worker_) return;
  }
  // The scenario does not change once there is a worker.
  std::vector<SensorViews> views = make_views();
  TopicSpec topic = topics::kPictures;
  topic.depth = find_depth();
  Publisher<msg::Pictures> pictures(bus(), topic);
  std::lock_guard<std::recursive_mutex> lock(bus().mutex());
  views_ = std::move(views);
  pictures_publisher_ = std::move(pictures);
  views_made_ = true;
}

void VisionNode::drop_endpoints() {
  NodeBase::drop_endpoints();
  worker_.reset();
}

template <typename Visit>
void VisionNode::for_each_view(Visit visit) {
  for (SensorViews& sensor : views_) {
    for (auto& view : sensor.info) visit(view);
    for (auto& view : sensor.color) visit(view);
    for (auto& view : sensor.depth) visit(view);
    for (auto& view : sensor.points) visit(view);
  }
}

void VisionNode::update_readers() {
  any_wanted_ = pictures_wanted_ = pictures_publisher_.has_readers();
  for_each_view([this](auto& view) {
    view.wanted = view.publisher.has_readers();
    any_wanted_ = any_wanted_ || view.wanted;
  });
}

std::vector<size_t> VisionNode::find_wanted(const std::vector<size_t>& due) const {
  std::vector<size_t> wanted;
  const auto any = [](const auto& list) {
    return std::any_of(list.begin(), list.end(), [](const auto& view) { return view.wanted; });
  };
  for (const size_t sensor : due) {
    if (!views_made_) break;
    const SensorViews& views = views_[sensor];
    if (pictures_wanted_ || any(views.info) || any(views.color) || any(views.depth) || any(views.points))
      wanted.push_back(sensor);
  }
  return wanted;
}

void VisionNode::take_state(const msg::RobotState& message) {
  if (!worker_) return;  // it comes again, as long as the run has not begun
  const uint64_t epoch = message.header().epoch(), step = message.header().step();
  const Question question = questions_.classify(epoch, step);
  if (question == Question::kOld) return;
  if (question == Question::kRepeated) return take_repeat(message);
  if (!any_state_ || epoch > epoch_) {
    worker_->forget_all();
    last_sensors_.clear();
    reported_step_ = 0;
  }
  any_state_ = true;
  epoch_ = epoch;
  newest_step_ = step;
  questions_.note_answered(epoch, step);
  look(message);
}

void VisionNode::look(const msg::RobotState& message) {
  const uint64_t step = message.header().step();
  const SensorsSpec& sensors = scenario_.sensors;
  LookJob job;
  job.look.sensors = find_wanted(
      find_looking_sensors(sensors.cameras, sensors.lidars, step, scenario_.time_step, scenario_.control_period));
  if (job.look.sensors.empty()) return;
  job.epoch = message.header().epoch();
  job.time = message.header().time();
  job.look.step = step;
  from_message(message, &job.look.state);
  from_message(message, &job.look.objects);
  taken_ += job.look.sensors.size();
  const size_t dropped = worker_->post(std::move(job));
  if (dropped > 0 && dropped_ == 0) {
    say("pictures are dropped: the run is faster than they can be taken; 'sensors: {every_picture: true}' makes it "
        "wait");
  }
  dropped_ += dropped;
}

// Somebody has no answer to this state, and may be a controller that waits for the pictures of it.
void VisionNode::take_repeat(const msg::RobotState& message) {
  const uint64_t step = message.header().step();
  if (worker_->find_oldest_step()) return;  // it is under way
  if (!last_sensors_.empty() && last_.header().step() == step) {
    const SensorsSpec& sensors = scenario_.sensors;
    const auto wanted = find_wanted(
        find_looking_sensors(sensors.cameras, sensors.lidars, step, scenario_.time_step, scenario_.control_period));
    if (std::includes(last_sensors_.begin(), last_sensors_.end(), wanted.begin(), wanted.end())) return repeat_last();
  }
  look(message);
}

// On topics of ROS 2 only what came before their readers did: a picture is large.
void VisionNode::repeat_last() {
  const auto now = Clock::now();
  if (now - last_sent_ < kRepeatPeriod) return;
  last_sent_ = now;
  if (pictures_wanted_) pictures_publisher_.publish(last_);
  if (last_.header().step() != 0) return;
  for (const msg::ViewSample& sample : last_.samples()) {
    for_each_view([&](auto& view) {
      if (view.wanted && view.topic == sample.topic())
        view.publisher.publish_bytes({sample.bytes().data(), sample.bytes().size()});
    });
  }
}

template <typename Message>
void VisionNode::send(View<Message>* view) {
  std::vector<char> buffer;
  const Bytes bytes = encode(view->message, &buffer);
  if (view->wanted) view->publisher.publish_bytes(bytes);
  msg::ViewSample& sample = last_.samples().emplace_back();
  sample.topic(view->topic);
  sample.bytes().assign(bytes.data, bytes.data + bytes.size);
}

void VisionNode::publish_camera(const CameraSpec& camera, const CameraPicture& picture, double time,
                                SensorViews* views) {
  for (auto& view : views->info) {
    set_camera_info(camera, time, &view.message);
    send(&view);
  }
  for (auto& view : views->color) {
    set_color_image(camera, picture, time, &view.message);
    send(&view);
  }
  for (auto& view : views->depth) {
    set_depth_image(camera, picture, time, &view.message);
    send(&view);
  }
}

void VisionNode::publish(const LookDone& done) {
  if (!done.fault.empty()) return fail("step " + std::to_string(done.job.look.step) + ": " + done.fault);
  if (done.job.epoch != epoch_) return;
  const SensorsSpec& sensors = scenario_.sensors;
  last_.header().epoch(done.job.epoch);
  last_.header().step(done.job.look.step);
  last_.header().time(done.job.time);
  last_.samples().clear();
  last_sensors_ = done.job.look.sensors;
  for (const size_t sensor : last_sensors_) {
    if (sensor < sensors.cameras.size()) {
      publish_camera(sensors.cameras[sensor], done.result.pictures[sensor], done.job.time, &views_[sensor]);
      continue;
    }
    const size_t lidar = sensor - sensors.cameras.size();
    for (auto& view : views_[sensor].points) {
      set_points(sensors.lidars[lidar], done.result.scans[lidar], done.job.time, &view.message);
      send(&view);
    }
  }
  if (pictures_wanted_) pictures_publisher_.publish(last_);
  last_sent_ = Clock::now();
}

void VisionNode::handle_idle(Clock::time_point now) {
  if (!worker_ || !views_made_) return;
  if (now - readers_asked_ >= kReadersPeriod) {
    readers_asked_ = now;
    update_readers();
  }
  while (const auto done = worker_->take_done()) publish(*done);
  report_progress();
}

// A run that waits for its pictures waits for this.
void VisionNode::report_progress() {
  const auto oldest = worker_->find_oldest_step();
  if (!waited_for_ || (any_state_ && !oldest)) set_phase(msg::SERVER_READY);
  if (!waited_for_ || !any_state_) return;
  const uint64_t step = !oldest ? newest_step_ : *oldest > 0 ? *oldest - 1 : 0;
  const bool stands_still = newest_step_ == seen_step_;
  seen_step_ = newest_step_;
  if (step < reported_step_ + kReportSteps && !stands_still) return;
  reported_step_ = step;
  report(epoch_, step);
}

std::string VisionNode::find_missing() const {
  if (!worker_) return "robot_description from model_parser";
  return any_state_ || !watches_ ? "" : "robot_state from dynamics";
}

bool VisionNode::is_drained() { return !waited_for_ || !worker_ || !worker_->find_oldest_step(); }

void VisionNode::handle_run_end() { say_dropped(); }

void VisionNode::say_dropped() {
  if (dropped_ > 0)
    say("dropped " + std::to_string(dropped_) + " of " + std::to_string(taken_) + " pictures and scans");
}

}  // namespace hrp

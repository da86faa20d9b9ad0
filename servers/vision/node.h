// SPDX-License-Identifier: BSD-3-Clause
// The vision server on a bus. It publishes what cameras and lidars see of the robot's states, while somebody reads
// that. Nobody waits for it, unless the scenario says so (sensors.every_picture, logging.pictures).
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "common/messages/convert.h"
#include "common/node/lockstep.h"
#include "common/node/node_base.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"
#include "hrp_idl/vision.h"
#include "servers/vision/look_worker.h"
#include "servers/vision/translate.h"

namespace hrp {

class VisionNode : public NodeBase {
 public:
  explicit VisionNode(const NodeContext& context);
  void make_endpoints() override;
  void drop_endpoints() override;
  std::string find_missing() const override;
  // Pictures that are ready are sent at idle times.
  std::chrono::milliseconds idle_period() const override { return std::chrono::milliseconds(1); }

 protected:
  void handle_idle(Clock::time_point now) override;
  bool is_drained() override;
  void handle_run_end() override;

 private:
  template <typename Message>
  struct View {
    std::string topic;
    Publisher<Message> publisher;
    Message message;
    bool wanted = false;
  };
  // One sensor's topics; a camera without color or depth has no such view, and a lidar has points alone.
  struct SensorViews {
    std::vector<View<RosCameraInfo>> info;
    std::vector<View<RosImage>> color, depth;
    std::vector<View<RosPointCloud>> points;
  };

  void start_watching();
  void take_description(const msg::RobotDescription& message);
  void take_state(const msg::RobotState& message);
  void take_repeat(const msg::RobotState& message);
  void look(const msg::RobotState& message);
  std::vector<size_t> find_wanted(const std::vector<size_t>& due) const;
  std::vector<SensorViews> make_views();
  int find_depth() const;
  void update_readers();
  void publish(const LookDone& done);
  void publish_camera(const CameraSpec& camera, const CameraPicture& picture, double time, SensorViews* views);
  template <typename Message>
  void send(View<Message>* view);
  template <typename Visit>
  void for_each_view(Visit visit);
  void repeat_last();
  void report_progress();
  void say_dropped();

  Scenario scenario_;
  bool waited_for_ = false;  // the run waits for every picture
  std::unique_ptr<LookWorker> worker_;
  std::vector<SensorViews> views_;  // of each sensor
  bool views_made_ = false;
  Publisher<msg::Pictures> pictures_publisher_;
  bool pictures_wanted_ = false, any_wanted_ = false;
  bool watches_ = false;  // reads the states
  Clock::time_point readers_asked_;
  QuestionFilter questions_;
  uint64_t epoch_ = 0, newest_step_ = 0, reported_step_ = 0;
  uint64_t seen_step_ = 0;  // the newest one at the last look at progress
  bool any_state_ = false;
  msg::Pictures last_;  // that were sent
  Clock::time_point last_sent_;
  std::vector<size_t> last_sensors_;  // whose they are; empty: none was sent in this epoch
  uint64_t taken_ = 0, dropped_ = 0;  // pictures
};

}  // namespace hrp

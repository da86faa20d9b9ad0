// SPDX-License-Identifier: BSD-3-Clause
// The WebSocket protocol of Foxglove, server side: its specification stands in github.com/foxglove/ws-protocol. Reading
// only.
#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "servers/viewer/connection.h"
#include "servers/viewer/picture_feed.h"
#include "servers/viewer/viewer.h"

namespace hrp {

class FoxgloveClient final : public Client {
 public:
  FoxgloveClient(Connection& connection, Viewer& viewer);
  ~FoxgloveClient() override;
  void on_message(const std::string& message, bool binary) override;

  // Tells of topics that are new.
  void advertise();
  // Sends a sample to the subscriptions of its topic, or only to those that got none yet. `time` [s] is simulated time.
  void send(const std::string& topic, Bytes sample, double time, bool again = true);
  // The same for a picture; false when no subscription got it: the connection had no room.
  bool send_picture(const std::string& topic, Bytes sample);
  bool reads(const std::string& topic) const;
  // Those that it reads.
  PictureFeed& pictures() { return pictures_; }

 private:
  struct Channel {
    uint32_t id = 0;
    bool picture = false;
    std::map<uint32_t, bool> subscriptions;  // by the client's id; true once something was sent
  };
  void subscribe(const nlohmann::json& request);
  void unsubscribe(const nlohmann::json& request);
  void update_pictures();
  void send_status(int level, const std::string& text);

  Connection& connection_;
  Viewer& viewer_;
  std::map<std::string, Channel> channels_;  // by topic of the run
  PictureFeed pictures_;
  uint32_t next_id_ = 1;
};

}  // namespace hrp

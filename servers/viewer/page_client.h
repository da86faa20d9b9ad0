// SPDX-License-Identifier: BSD-3-Clause
// One open page. The messages, both ways, are in docs/viewer.md.
#pragma once

#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "servers/viewer/connection.h"
#include "servers/viewer/viewer.h"

namespace hrp {

class PageClient final : public Client {
 public:
  PageClient(Connection& connection, Viewer& viewer);
  ~PageClient() override;
  void on_message(const std::string& message, bool binary) override;
  Connection& connection() { return connection_; }
  // Charted signals of a live run: "topic:path".
  const std::set<std::string>& signals() const { return signals_; }
  // Pictures that the page shows, and the time of recordings that it has gone to.
  PictureFeed& pictures() { return pictures_; }
  const std::set<std::string>& picture_topics() const { return picture_topics_; }
  double time_in(const Recording& recording) const { return recording.begin() + time_; }

 private:
  void answer(const std::string& text);
  void answer_error(const std::string& text, int64_t id);
  void open(const nlohmann::json& request);
  void subscribe(const nlohmann::json& request);
  void show_pictures(const nlohmann::json& request);
  void update_pictures();
  void control(const nlohmann::json& request);
  void push(const nlohmann::json& request);
  void send(const msg::RunControl& control);
  void go_to(const nlohmann::json& request);
  void send_series(const nlohmann::json& request);

  Connection& connection_;
  Viewer& viewer_;
  std::set<std::string> signals_;
  std::set<std::string> picture_topics_;
  PictureFeed pictures_;
  std::vector<size_t> sources_{0};  // recordings that it shows; a live run is source 0
  double time_ = 0.0;               // [s] from their begins
};

}  // namespace hrp

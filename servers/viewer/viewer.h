// SPDX-License-Identifier: BSD-3-Clause
// The application behind the web server: brings a live run or recordings to pages and to Foxglove.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "servers/viewer/connection.h"
#include "servers/viewer/foxglove_scene.h"
#include "servers/viewer/live_run.h"
#include "servers/viewer/picture_feed.h"
#include "servers/viewer/recording.h"

namespace hrp {

class PageClient;
class FoxgloveClient;

struct ViewerOptions {
  std::string page_folder;  // with index.html
  std::string log_after;    // log of the live run, shown when the run is over; empty: none
};

class Viewer final : public WebApplication {
 public:
  explicit Viewer(ViewerOptions options) : options_(std::move(options)) {}
  ~Viewer() override;
  void show(std::unique_ptr<LiveRun> run) { live_ = std::move(run); }
  void show(std::vector<std::unique_ptr<Recording>> recordings);
  // Once per period: what came from the bus goes to the clients.
  void tick();

  std::unique_ptr<Client> make_page_client(Connection& connection) override;
  std::unique_ptr<Client> make_foxglove_client(Connection& connection) override;
  std::optional<WebFile> find_file(const std::string& target) override;

  // For clients.
  void join(PageClient* client) { pages_.insert(client); }
  void join(FoxgloveClient* client) { foxgloves_.insert(client); }
  void leave(PageClient* client) { pages_.erase(client); }
  void leave(FoxgloveClient* client) { foxgloves_.erase(client); }
  LiveRun* live() const { return live_.get(); }
  const std::vector<std::unique_ptr<Recording>>& recordings() const { return recordings_; }
  const Scene* find_scene(size_t source) const;
  std::string make_hello() const;
  // Everything that a page that has just come needs to show the present state of a live run.
  void send_present(Connection& connection) const;
  // Topic -> type of everything that can be seen, pictures included.
  std::map<std::string, std::string> find_topics() const;
  std::string find_schema(const std::string& topic) const;
  // Where a recording (a live run: 0) has its pictures; nullptr: it has none.
  PictureSource* find_pictures(size_t source) const;
  // Foxglove clients get what recorded runs hold at the time that a page has gone to.
  void show_time(double time);
  double shown_time() const { return shown_time_; }
  // A live topic that a page wants to know the values of, for some seconds.
  void peek(const std::string& topic);

 private:
  using Clock = std::chrono::steady_clock;
  void refresh_topics();
  void update_readers();
  void take_description(const Arrivals& arrivals);
  void take_status(const std::map<std::string, Arrivals>& arrivals);
  void take_run_status(const Arrivals& arrivals);
  void send_samples(const std::map<std::string, Arrivals>& arrivals);
  void send_frame(const std::map<std::string, Arrivals>& arrivals);
  void read_pictures();
  void send_pictures();
  void send_pictures(PageClient* page);
  void send_pictures(FoxgloveClient* client);
  Payload find_payload(const PictureKey& key, uint64_t number);
  void send_foxglove(const std::map<std::string, Arrivals>& arrivals);
  void send_foxglove_scene(const std::map<std::string, Arrivals>& arrivals);
  void show_foxglove_scene(double time);
  bool reads_foxglove(const std::string& topic) const;
  void send_pages(const std::string& text, Urgency urgency);
  void watch_end();

  ViewerOptions options_;
  std::unique_ptr<LiveRun> live_;
  std::vector<std::unique_ptr<Recording>> recordings_;
  std::set<PageClient*> pages_;
  std::set<FoxgloveClient*> foxgloves_;
  std::map<std::string, std::string> live_topics_;
  std::map<std::string, Clock::time_point> peeks_;  // until when
  Clock::time_point next_refresh_{};
  Scene scene_;                   // of the live run
  FoxgloveScene foxglove_scene_;  // of the live run, else of the first recording
  // Messages for pages, by what is in them: two pages get the same one.
  std::map<PictureKey, std::pair<uint64_t, Payload>> payloads_;
  SampleBytes description_;
  std::string frame_, status_;                  // last that was sent
  std::string run_text_ = "null";               // last status of the run
  std::map<std::string, std::string> servers_;  // last status of each role
  msg::RunStatus run_status_;
  bool reads_servers_ = true;
  std::string log_file_;  // that the logger writes, as it says; empty before
  std::map<std::string, std::unique_ptr<Signal>> signals_;
  Clock::time_point over_since_{};
  double shown_time_ = 0.0;
};

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// A run that goes on, seen from outside: best-effort readers that keep what fits and forget the rest, so that nothing
// here can hold the run up.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/messages/pubsub.h"
#include "common/messages/reflection/schema.h"
#include "common/node/join.h"
#include "hrp_idl/scheduling.h"
#include "hrp_idl/view.h"
#include "servers/viewer/live_pictures.h"

namespace hrp {

using SampleBytes = std::vector<uint8_t>;

// What came on a topic since it was asked last.
struct Arrivals {
  const StructType* type = nullptr;
  bool fresh = false;
  SampleBytes latest;                // the newest sample ever, empty when none came yet
  std::vector<SampleBytes> thinned;  // at most some hundred a second of wall clock, for charts
  std::vector<SampleBytes> all;      // every sample, as far as memory for them goes; only of topics so asked for
};

class LiveRun {
 public:
  LiveRun(Bus& bus, bool read_only, JoinedRun run = {});
  ~LiveRun();

  // Which topics to read from now on; those in `whole` with every sample, the others from the servers' views where
  // these have them (common/node/view_writer.h): that costs the run nearly nothing. Not under the bus's mutex.
  void read_topics(const std::set<std::string>& topics, const std::set<std::string>& whole);
  // Topics that somebody offers and whose type is ours: name -> type.
  std::map<std::string, std::string> find_topics();
  std::map<std::string, Arrivals> take();
  // Signs the request and keeps it until it was sent several times: a scheduler that is being discovered may miss the
  // first one, and takes each only once. Ignored when run control is switched off.
  void request(const msg::RunControl& control);
  // Sends what is due. True when a request was given up because nobody listens.
  bool send_requests();
  bool has_control() const { return !read_only_; }
  LivePictures& pictures() { return pictures_; }
  // Of what comes on run_status: an end is believed when it is signed.
  bool believes(const msg::RunStatus& heard, const msg::RunStatus& news) const;

 private:
  struct Topic;
  using Clock = std::chrono::steady_clock;
  struct Request {
    msg::RunControl message;
    Clock::time_point asked, next;
    bool sent = false;
  };
  Topic* find_or_add(const std::string& name);
  void keep(Topic* topic, Bytes sample, bool thinned);
  void take_view(const msg::View& view);
  void read_view(bool wanted);
  // Its server is one that shows it, or may turn out to be.
  bool is_shown(const Topic& topic, Clock::time_point now) const;
  std::unique_ptr<Reader> make_reader(const std::string& name, Topic* topic);
  Bus& bus_;
  bool read_only_;
  JoinedRun run_;
  std::deque<Request> requests_;
  Publisher<msg::RunControl> control_;
  LivePictures pictures_;
  std::map<std::string, std::unique_ptr<Topic>> topics_;
  bool has_view_ = false;
  std::unique_ptr<Reader> view_;
};

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// What a server shows to eyes. A run as fast as it goes makes 20 000 steps a second, and every reader of a stream costs
// its writer a packet per step; nobody sees more than some hundred. So a server that is watched packs samples of one
// step every 2 ms of wall clock into one packet every 16 ms. Nothing else may read this: which steps it shows is
// chance.
#pragma once

#include <chrono>
#include <string>

#include "common/messages/pubsub.h"
#include "hrp_idl/view.h"

namespace hrp {

class ViewWriter {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ViewWriter(Bus& bus);
  // Asked after every step, costs nothing while nobody looks: shall the samples of this step be shown? The caller then
  // adds them, oldest first.
  bool is_due() { return watched_ && is_due_at(Clock::now()); }
  void add(const std::string& topic, Bytes sample);
  // To be called at idle times. True when onlookers lack the newest step, or have heard nothing for a while: they may
  // have come just now, to a run that is paused.
  bool update(Clock::time_point now);
  // Sends what waits.
  void flush();
  bool is_watched() const { return watched_; }

 private:
  bool is_due_at(Clock::time_point now);

  Publisher<msg::View> publisher_;
  msg::View batch_;
  size_t batch_bytes_ = 0;
  bool watched_ = false;
  bool newer_ = false;  // a step has passed that was not shown
  Clock::time_point last_shown_{}, last_sent_{};
};

}  // namespace hrp

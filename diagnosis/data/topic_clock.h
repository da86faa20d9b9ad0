// SPDX-License-Identifier: BSD-3-Clause
// Compares the clocks of topics, through the receive times of the recorder.
//
// The sender stamps a message, which is received later: receive - stamp = latency + offset + drift x stamp. Latency is
// never negative and sometimes small. So the lower envelope of receive - stamp is the clock, and the rest is latency
// (Moon, Skelly and Towsley, "Estimation and removal of clock skew", INFOCOM 1999).
#pragma once

#include <string>
#include <vector>

namespace hrp::diagnosis {

struct TopicClock {
  bool stamped = false;  // by the sender; if false, only receive times are known
  double begin = 0.0;    // [s] first stamp
  double level = 0.0, slope = 0.0,
         scatter = 0.0;  // envelope of receive - stamp: level + slope (stamp - begin) +- scatter
  double span = 0.0;     // [s] of stamps
  double to_receive(double stamp) const { return stamped ? stamp + level + slope * (stamp - begin) : stamp; }
  double from_receive(double receive) const {
    return stamped ? begin + (receive - begin - level) / (1.0 + slope) : receive;
  }
};
TopicClock find_topic_clock(const std::vector<double>& stamp, const std::vector<double>& receive);

struct PlacedClock {
  bool stamped = false;
  bool moved = false;   // converted to the reference's clock
  double offset = 0.0;  // [s] ahead of the reference at the start
  double drift = 0.0;   // [s/s] gain against the reference
  double period = 0.0;  // [s] median between samples
};

// Times of samples on the clock of `reference`. Stamps stay unchanged if the clocks differ by no more than latency can
// explain. Otherwise they are converted. Without stamps, receive times are used.
std::vector<double> place_stamps(const std::vector<double>& stamp, const std::vector<double>& receive,
                                 const TopicClock& reference, PlacedClock* placed);

// "200 Hz; its clock is 3.21 s ahead of that of /joint_states and gains 41 us in a second: moved there".
std::string describe_clock(const PlacedClock& clock, const std::string& reference);

}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>

#include <fastdds/dds/publisher/DataWriter.hpp>

namespace hrp {

// A writer of Fast DDS 2.9 drops a sample when all its readers have acknowledged it. It forgets one for ever if a
// further reader is matched just then (StatefulWriter::check_acked_status() counts a reader that has acknowledged
// nothing yet as one that has everything). From then on each heartbeat lists all samples since as gaps, and readers
// mark them one by one: the time of a run grows with the square of its steps.
//
// Once every reader has acknowledged a sample that was written after the last match, nobody needs what is still kept:
// this empties the history then. Its cost after that is one comparison a sample. For streams only: a latched topic
// keeps its last sample for those who come late.
class ForgottenSamples {
 public:
  // A reader was matched. From any thread.
  void on_match() { ++matches_; }

  // Before each write, by one thread at a time. Returns how many forgotten samples it dropped.
  size_t drop(eprosima::fastdds::dds::DataWriter* writer) {
    size_t dropped = 0;
    if (watching_ && have_all(writer)) {
      writer->clear_history(&dropped);
      watching_ = false;
    }
    // The sample that comes now is the first one that is surely meant for the new reader, too.
    const int matches = matches_;
    if (matches != seen_) watching_ = true;
    seen_ = matches;
    return dropped;
  }

 private:
  // Asks, and does not wait. With a time of zero glibc gives the processor away, and a busy machine gives it back at
  // its next tick (4 ms); with one before the start of the machine it does not.
  static bool have_all(eprosima::fastdds::dds::DataWriter* writer) {
    const eprosima::fastrtps::Duration_t long_ago{-1'000'000'000, 0};
    return writer->wait_for_acknowledgments(long_ago) == ReturnCode_t::RETCODE_OK;
  }

  std::atomic<int> matches_{0};
  int seen_ = 0;           // of them
  bool watching_ = false;  // a sample was written since the last match, and may not have reached all
};

}  // namespace hrp

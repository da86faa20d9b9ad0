// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/view_writer.h"

#include "common/messages/topics.h"

namespace hrp {
namespace {

constexpr auto kShowPeriod = std::chrono::milliseconds(2);   // more points than a chart has columns
constexpr auto kSendPeriod = std::chrono::milliseconds(16);  // pictures 60 times a second
constexpr auto kRepeatPeriod = std::chrono::milliseconds(250);
// Beyond 64 kB a sample is more than one datagram, and best-effort readers lose it when one of them is lost.
constexpr size_t kMostBytes = 48 * 1024;

}  // namespace

ViewWriter::ViewWriter(Bus& bus) : publisher_(bus, topics::kView) {}

bool ViewWriter::is_due_at(Clock::time_point now) {
  newer_ = now - last_shown_ < kShowPeriod;
  if (newer_) return false;
  if (now - last_sent_ >= kSendPeriod) flush();
  last_shown_ = now;
  return true;
}

void ViewWriter::add(const std::string& topic, Bytes sample) {
  if (sample.size == 0) return;
  if (batch_bytes_ + sample.size > kMostBytes) flush();
  batch_.samples().emplace_back();
  msg::ViewSample& shown = batch_.samples().back();
  shown.topic(topic);
  shown.bytes().assign(sample.data, sample.data + sample.size);
  batch_bytes_ += sample.size;
}

bool ViewWriter::update(Clock::time_point now) {
  watched_ = publisher_.has_readers();
  if (!watched_) {
    batch_.samples().clear();
    batch_bytes_ = 0;
    return false;
  }
  if (now - last_sent_ >= kSendPeriod) flush();
  const bool late = newer_ && now - last_shown_ >= kShowPeriod;
  if (!late && now - last_sent_ < kRepeatPeriod) return false;
  newer_ = false;
  last_shown_ = now;
  return true;
}

void ViewWriter::flush() {
  if (batch_.samples().empty()) return;
  last_sent_ = Clock::now();
  publisher_.publish(batch_);
  batch_.samples().clear();
  batch_bytes_ = 0;
}

}  // namespace hrp

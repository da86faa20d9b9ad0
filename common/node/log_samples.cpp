// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/log_samples.h"

#include "common/messages/topics.h"

namespace hrp {
namespace {

// Some 4 steps of a robot of 30 joints on 8 points. Packets of 60 kB, the most that a datagram holds, cost more than
// they save: both vendors allocate them anew while older ones wait for their acknowledgement (30 MB more memory on
// Cyclone DDS).
constexpr size_t kMostBytes = 15 * 1024;
// Two lengths, the end of the name and gaps of one sample, at most.
constexpr size_t kExtra = 16;

}  // namespace

LogSamples::LogSamples(Bus& bus) : publisher_(bus, topics::kLogSamples) {}

void LogSamples::add(const std::string& topic, Bytes sample) {
  if (!read_ || sample.size == 0) return;
  const size_t size = sample.size + topic.size() + kExtra;
  if (bytes_ + size > kMostBytes) flush();
  if (count_ == batch_.samples().size()) batch_.samples().emplace_back();
  msg::ViewSample& next = batch_.samples()[count_++];
  next.topic() = topic;
  next.bytes().assign(sample.data, sample.data + sample.size);
  bytes_ += size;
}

void LogSamples::flush() {
  if (count_ == 0) return;
  batch_.samples().resize(count_);
  count_ = bytes_ = 0;
  publisher_.publish(batch_);
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

#include "common/base/bit_hash.h"
#include "common/base/printable.h"
#include "common/mcap/writer.h"
#include "servers/console/log_tool/commands.h"
#include "servers/console/log_tool/log_file.h"

namespace hrp {
namespace {

constexpr uint64_t kFnvStart = 0xcbf29ce484222325ull;

// FNV-1a, 64 bits. Not against forgers: it tells runs apart.
uint64_t update_hash(uint64_t hash, const uint8_t* data, size_t size) {
  for (size_t i = 0; i < size; ++i) hash = (hash ^ data[i]) * 0x100000001b3ull;
  return hash;
}

struct Stamp {
  uint32_t step;
  uint64_t hash;
  bool operator==(const Stamp& other) const { return step == other.step && hash == other.hash; }
};

std::map<std::string, std::vector<Stamp>> read_stamps(LogFile* log) {
  std::map<std::string, std::vector<Stamp>> stamps;
  for (const auto& [id, topic] : log->topics()) stamps[topic.topic];
  log->reader().read_messages([&](const mcap::Message& message) {
    stamps[log->topics().at(message.channel_id).topic].push_back(
        {message.sequence, update_hash(kFnvStart, message.data, message.size)});
    return true;
  });
  return stamps;
}

// Every value of a message as (path, text).
class Flattener : public SampleVisitor {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;
  void begin_struct(const StructType&) override { path_.push_back({}); }
  void end_struct() override { leave(); }
  void begin_field(const Field& field) override { path_.back().name = "." + field.name; }
  void begin_list(const FieldType&, size_t size) override {
    add("size " + std::to_string(size));
    path_.push_back({"", 0, true});
  }
  void end_list() override { leave(); }
  void on_bool(bool value) override { add_value(value ? "true" : "false"); }
  void on_signed(int64_t value) override { add_value(std::to_string(value)); }
  void on_unsigned(uint64_t value) override { add_value(std::to_string(value)); }
  void on_hash(uint64_t value) override { add_value(format_hash(value)); }
  void on_float(double value) override {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.17g", value);
    add_value(text.data());
  }
  void on_string(const std::string& value) override { add_value("'" + make_printable_line(value.substr(0, 60)) + "'"); }
  void on_enum(const EnumType&, uint32_t value) override { add_value(std::to_string(value)); }
  const Values& values() const { return values_; }

 private:
  struct Place {
    std::string name;
    size_t index = 0;
    bool list = false;
  };
  void add(const std::string& value) {
    std::string path;
    for (const Place& place : path_) path += place.list ? "[" + std::to_string(place.index) + "]" : place.name;
    values_.emplace_back(path.empty() ? path : path.substr(1), value);
  }
  void add_value(const std::string& value) {
    add(value);
    count_element();
  }
  void leave() {
    path_.pop_back();
    count_element();
  }
  void count_element() {
    if (!path_.empty() && path_.back().list) ++path_.back().index;
  }
  std::vector<Place> path_;
  Values values_;
};

// "hash" of a message; logs of before have it as a number.
std::string find_hash(const LogTopicType& topic, Bytes sample) {
  Flattener flattener;
  const FieldPath path(*topic.type, "hash");
  if (!visit_field(*topic.type, sample, path, &flattener) || flattener.values().empty()) return "";
  const std::string& text = flattener.values().front().second;
  return path.unit() == "hex" ? text : format_hash(std::stoull(text));
}

// The values of the n-th message of a topic.
Flattener::Values read_values(LogFile* log, const std::string& topic, size_t n) {
  Flattener flattener;
  size_t at = 0;
  log->reader().read_messages(
      [&](const mcap::Message& message) {
        if (at++ < n) return true;
        const StructType* type = log->topics().at(message.channel_id).type;
        if (type != nullptr) visit_sample(*type, get_bytes(message), &flattener);
        return false;
      },
      {topic});
  return flattener.values();
}

void print_first_difference(LogFile* one, LogFile* other, const std::string& topic, size_t n) {
  const Flattener::Values a = read_values(one, topic, n), b = read_values(other, topic, n);
  const size_t count = std::min(a.size(), b.size());
  for (size_t i = 0; i < count; ++i) {
    if (a[i] == b[i]) continue;
    std::printf("  %s: %s against %s\n", a[i].first.c_str(), a[i].second.c_str(), b[i].second.c_str());
    return;
  }
  std::printf("  the values print alike; their bits differ\n");
}

}  // namespace

int show_hashes(const std::string& file) {
  LogFile log(file);
  std::map<uint16_t, std::pair<uint64_t, uint64_t>> hashes;  // count, hash
  std::string state_hash, state_step;
  for (const auto& [id, topic] : log.topics()) hashes[id] = {0, kFnvStart};
  log.reader().read_messages([&](const mcap::Message& message) {
    auto& [count, hash] = hashes[message.channel_id];
    ++count;
    const uint64_t size = message.size;
    hash = update_hash(hash, reinterpret_cast<const uint8_t*>(&size), sizeof size);
    hash = update_hash(hash, message.data, message.size);
    const LogTopicType& topic = log.topics().at(message.channel_id);
    if (topic.topic == "hrp/robot_state" && topic.type != nullptr) {
      state_hash = find_hash(topic, get_bytes(message));
      state_step = std::to_string(message.sequence);
    }
    return true;
  });
  for (const auto& [id, topic] : log.topics()) {
    std::printf("%-24s %10llu messages  %s\n", make_printable_line(topic.topic).c_str(),
                static_cast<unsigned long long>(hashes[id].first), format_hash(hashes[id].second).c_str());
  }
  if (!state_hash.empty()) std::printf("state hash %s at step %s\n", state_hash.c_str(), state_step.c_str());
  return say_damage(log.reader());
}

int compare_logs(const std::string& one_path, const std::string& other_path) {
  LogFile one(one_path), other(other_path);
  const auto a = read_stamps(&one), b = read_stamps(&other);
  struct Difference {
    std::string topic;
    size_t index;
    uint32_t step;
  };
  std::vector<Difference> differences;
  size_t compared = 0;
  for (const auto& [topic, stamps] : a) {
    const auto found = b.find(topic);
    if (found == b.end()) {
      std::printf("%s: only in %s\n", make_printable_line(topic).c_str(), one_path.c_str());
      differences.push_back({topic, stamps.size(), 0});
      continue;
    }
    const size_t count = std::min(stamps.size(), found->second.size());
    size_t i = 0;
    while (i < count && stamps[i] == found->second[i]) ++i;
    compared += i;
    if (i < count) {
      differences.push_back({topic, i, stamps[i].step});
    } else if (stamps.size() != found->second.size()) {
      std::printf("%s: %zu messages against %zu, equal as far as both go\n", make_printable_line(topic).c_str(),
                  stamps.size(), found->second.size());
      const auto& longer = stamps.size() > count ? stamps : found->second;
      differences.push_back({topic, count, longer[count].step});
    }
  }
  for (const auto& [topic, stamps] : b) {
    if (a.count(topic) == 0) std::printf("%s: only in %s\n", make_printable_line(topic).c_str(), other_path.c_str());
    if (a.count(topic) == 0) differences.push_back({topic, stamps.size(), 0});
  }
  std::stable_sort(differences.begin(), differences.end(),
                   [](const Difference& l, const Difference& r) { return l.step < r.step; });
  for (const Difference& difference : differences) {
    const auto in_a = a.find(difference.topic), in_b = b.find(difference.topic);
    if (in_a == a.end() || in_b == b.end()) continue;
    if (difference.index >= in_a->second.size() || difference.index >= in_b->second.size()) continue;
    std::printf("%s: first difference at step %u\n", make_printable_line(difference.topic).c_str(), difference.step);
    print_first_difference(&one, &other, difference.topic, difference.index);
  }
  for (LogFile* log : {&one, &other}) say_damage(log->reader());
  if (differences.empty()) std::printf("equal: %zu messages, every payload the same\n", compared);
  return differences.empty() ? 0 : 1;
}

int recover_log(const std::string& in, const std::string& out, bool force) {
  constexpr size_t kChunkSize = size_t{1} << 20;
  mcap::Reader reader(in);
  check_output(in, out, force);
  bool any = false;
  reader.read_messages([&](const mcap::Message&) { return !(any = true); });
  if (!any) {
    throw mcap::McapError(in + ": nothing can be recovered" +
                          (reader.damage().empty() ? ", it holds no message" : ": " + reader.damage()));
  }
  mcap::Writer writer(mcap::ClaimedFile(out, force ? mcap::Existing::kReplace : mcap::Existing::kRefuse),
                      mcap::Compression::kZstd);
  std::map<uint16_t, uint16_t> schemas, channels;
  const auto add_channel = [&](uint16_t id) {
    const mcap::Channel& channel = reader.channels().at(id);
    const auto found = reader.schemas().find(channel.schema_id);
    const mcap::Schema schema = found == reader.schemas().end() ? mcap::Schema{} : found->second;
    if (schemas.count(schema.id) == 0)
      schemas[schema.id] = writer.add_schema(schema.name, schema.encoding, schema.text);
    channels[id] = writer.add_channel(channel.topic, schemas[schema.id], channel.message_encoding);
  };
  for (const auto& [id, channel] : reader.channels()) add_channel(id);
  const uint64_t count = reader.read_messages([&](const mcap::Message& message) {
    if (channels.count(message.channel_id) == 0) add_channel(message.channel_id);
    mcap::Message copy = message;
    copy.channel_id = channels[message.channel_id];
    writer.add_message(copy);
    if (writer.open_chunk_size() > kChunkSize) writer.write_chunk();
    return true;
  });
  writer.close();
  std::printf("%s: %llu messages recovered\n", out.c_str(), static_cast<unsigned long long>(count));
  if (!reader.damage().empty()) std::printf("left behind: %s\n", make_printable_line(reader.damage()).c_str());
  return 0;
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 1, format 2.0 (wiki.ros.org/Bags/Format/2.0): records, each a header of named fields and data.
// Connections name topics and hold the definitions of their types; chunks hold messages, plain or compressed.
#include <bzlib.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <new>
#include <stdexcept>

#include "common/log/ros_bag.h"
#include "common/log/ros_types.h"
#include "common/mcap/compression.h"

namespace hrp {
namespace {

constexpr char kVersion[] = "#ROSBAG V2.0\n";
constexpr size_t kVersionLength = sizeof kVersion - 1;
constexpr size_t kGrowth = size_t{1} << 20;
enum Op : uint8_t { kMessage = 2, kBagHeader = 3, kChunk = 5, kConnection = 7 };

// A length and as many bytes behind it, taken from the front of `rest`.
Bytes take_block(Bytes* rest) {
  uint32_t length = 0;
  if (rest->size < sizeof length) throw std::runtime_error("a record ends too early");
  std::memcpy(&length, rest->data, sizeof length);
  if (length > rest->size - sizeof length) throw std::runtime_error("a record ends too early");
  const Bytes block{rest->data + sizeof length, length};
  *rest = {block.data + length, rest->size - sizeof length - length};
  return block;
}

// "name=value" blocks; values stay where they are.
class Fields {
 public:
  explicit Fields(Bytes header) {
    while (header.size > 0) {
      const Bytes field = take_block(&header);
      const void* equals = field.size > 0 ? std::memchr(field.data, '=', field.size) : nullptr;
      if (equals == nullptr) throw std::runtime_error("a field of a record has no name");
      const size_t name = static_cast<size_t>(static_cast<const uint8_t*>(equals) - field.data);
      values_[std::string(field.data, field.data + name)] = {field.data + name + 1, field.size - name - 1};
    }
  }
  // Throws for a field that is missing or has another size.
  template <typename Number>
  Number get(const char* name) const {
    const auto at = values_.find(name);
    Number value;
    if (at == values_.end() || at->second.size != sizeof value)
      throw std::runtime_error(std::string("a record has no field ") + name);
    std::memcpy(&value, at->second.data, sizeof value);
    return value;
  }
  std::string get_text(const char* name) const {
    const auto at = values_.find(name);
    return at == values_.end() ? "" : std::string(at->second.data, at->second.data + at->second.size);
  }

 private:
  std::map<std::string, Bytes> values_;
};

// `size` is what the record promises; memory grows with what is really there. Throws for anything else.
void unpack_bz2(Bytes packed, size_t size, std::vector<uint8_t>* out) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data));
  stream.avail_in = static_cast<unsigned>(packed.size);
  size_t done = 0;
  int status = BZ_OK;
  while (status == BZ_OK && done <= size) {
    out->resize(std::min(size + 1, done + kGrowth));
    stream.next_out = reinterpret_cast<char*>(out->data() + done);
    stream.avail_out = static_cast<unsigned>(out->size() - done);
    const unsigned room = stream.avail_out, left = stream.avail_in;
    status = BZ2_bzDecompress(&stream);
    done += room - stream.avail_out;
    if (room == stream.avail_out && left == stream.avail_in) break;
  }
  BZ2_bzDecompressEnd(&stream);
  out->resize(std::min(done, size));
  if (status == BZ_MEM_ERROR) throw std::bad_alloc();
  if (status != BZ_STREAM_END || done != size) throw std::runtime_error("a chunk compressed with bz2 is damaged");
}

void unpack(const std::string& compression, Bytes packed, size_t size, std::vector<uint8_t>* out) {
  if (compression == "bz2") return unpack_bz2(packed, size, out);
  if (compression != "lz4" && compression != "none")
    throw std::runtime_error("a chunk is compressed with '" + compression + "', expected none, bz2 or lz4");
  const auto result = mcap::decompress(compression == "none" ? "" : compression, packed.data, packed.size, size, out);
  if (result != mcap::Unpacked::kWhole) throw std::runtime_error("a chunk (" + compression + ") is damaged");
}

class Ros1Bag : public BagFile {
 public:
  explicit Ros1Bag(const std::string& path) : file_(path, std::ios::binary | std::ios::ate) {
    if (!file_) throw std::runtime_error("cannot be read");
    size_ = static_cast<uint64_t>(file_.tellg());
    file_.seekg(0);
    char version[kVersionLength] = {};
    file_.read(version, static_cast<std::streamsize>(kVersionLength));
    if (std::memcmp(version, kVersion, kVersionLength) != 0)
      throw std::runtime_error("its first line is not '#ROSBAG V2.0', that of bags of ROS 1");
    find_topics();
  }
  const std::vector<BagTopic>& topics() const override { return topics_; }

  void read(const std::set<std::string>& topics, const std::function<void(const BagMessage&)>& visit) override {
    seek(kVersionLength);
    scan([&](const Fields& fields, Bytes data) {
      const auto connection = index_.find(fields.get<uint32_t>("conn"));
      if (connection == index_.end()) throw std::runtime_error("a message is of no topic");
      if (!topics.empty() && topics.count(topics_[connection->second].name) == 0) return;
      const auto time = fields.get<uint64_t>("time");  // seconds, then nanoseconds, 32 bits each
      visit({connection->second,
             static_cast<int64_t>(time & 0xffffffff) * 1000000000 + static_cast<int64_t>(time >> 32), data});
    });
  }
  std::string damage() const override { return damage_; }

 private:
  // Connections stand at the end, where the header says; in a bag that was not closed, in its chunks.
  void find_topics() {
    if (!read_record() || Fields(header()).get<uint8_t>("op") != kBagHeader)
      throw std::runtime_error("its first record is not that of a bag");
    if (!Fields(header()).get_text("encryptor").empty()) throw std::runtime_error("it is encrypted");
    const auto index = Fields(header()).get<uint64_t>("index_pos");
    if (index > kVersionLength && index < size_) {
      seek(index);
      while (read_record() && Fields(header()).get<uint8_t>("op") == kConnection)
        add_connection(Fields(header()), data());
    } else {
      scan([](const Fields&, Bytes) {});
      if (damage_.empty()) damage_ = "it was not closed";
    }
  }

  void add_connection(const Fields& fields, Bytes data) {
    const auto id = fields.get<uint32_t>("conn");
    if (index_.count(id) > 0) return;
    const Fields of(data);
    const std::string name = fields.get_text("topic");
    size_t at = 0;
    while (at < topics_.size() && topics_[at].name != name) ++at;  // several publishers of one topic
    if (at == topics_.size())
      topics_.push_back({name, find_ros_name(of.get_text("type")), "ros1msg", of.get_text("message_definition"), 0});
    index_[id] = at;
  }

  // All messages from here on, in the order of the file. What is damaged ends it.
  void scan(const std::function<void(const Fields&, Bytes)>& visit) {
    while (read_record()) {
      const Fields fields(header());
      if (fields.get<uint8_t>("op") != kChunk) {
        take(fields, data(), visit);
        continue;
      }
      unpack(fields.get_text("compression"), data(), fields.get<uint32_t>("size"), &plain_);
      for (Bytes rest{plain_.data(), plain_.size()}; rest.size > 0;) {
        const Fields inner(take_block(&rest));
        take(inner, take_block(&rest), visit);
      }
    }
  }
  // A connection or a message; what else there is speaks of these.
  void take(const Fields& fields, Bytes data, const std::function<void(const Fields&, Bytes)>& visit) {
    const auto op = fields.get<uint8_t>("op");
    if (op == kConnection) add_connection(fields, data);
    if (op == kMessage) visit(fields, data);
  }

  void seek(uint64_t position) {
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(position));
    position_ = position;
  }
  // False at the end of the file; what is missing there is damage.
  bool read_record() {
    if (position_ >= size_) return false;
    if (read_block(&header_) && read_block(&data_)) return true;
    damage_ = "its last record ends too early";
    return false;
  }
  bool read_block(std::vector<uint8_t>* block) {
    uint32_t length = 0;
    if (size_ - position_ < sizeof length || !file_.read(reinterpret_cast<char*>(&length), sizeof length)) return false;
    position_ += sizeof length;
    if (length > size_ - position_) return false;
    block->resize(length);
    position_ += length;
    return static_cast<bool>(file_.read(reinterpret_cast<char*>(block->data()), length));
  }
  Bytes header() const { return {header_.data(), header_.size()}; }
  Bytes data() const { return {data_.data(), data_.size()}; }

  std::ifstream file_;
  uint64_t size_ = 0, position_ = kVersionLength;  // [bytes]
  std::vector<uint8_t> header_, data_;             // of the record that was read
  std::vector<uint8_t> plain_;                     // its chunk
  std::vector<BagTopic> topics_;
  std::map<uint32_t, size_t> index_;  // of connections in topics_
  std::string damage_;
};

}  // namespace

std::unique_ptr<BagFile> open_ros1_bag(const std::string& path) { return std::make_unique<Ros1Bag>(path); }

}  // namespace hrp

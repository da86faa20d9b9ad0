// SPDX-License-Identifier: BSD-3-Clause
#include "common/log/ros_bag.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/log/ros_types.h"
#include "common/mcap/compression.h"
#include "common/mcap/reader.h"
#include "common/robot/bag_metadata.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

// Largest size of a message or file after it was unpacked: enough for any, and a lie in a file costs nothing.
constexpr uint64_t kLargest = uint64_t{1} << 40;

std::vector<uint8_t> unpack(const uint8_t* data, size_t size) {
  std::vector<uint8_t> out;
  // The size is not known: "cut short" of kLargest is what a whole one gives.
  if (mcap::decompress("zstd", data, size, kLargest, &out) == mcap::Unpacked::kCorrupt)
    throw std::runtime_error("zstd data are corrupt");
  return out;
}

// A packed file, unpacked beside others of this kind; gone with the object.
class UnpackedFile {
 public:
  explicit UnpackedFile(const std::string& packed) {
    std::ifstream in(packed, std::ios::binary);
    if (!in) throw std::runtime_error("cannot be read");
    const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const std::vector<uint8_t> plain = unpack(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
    std::string name = (fs::temp_directory_path() / "hrp_bag_XXXXXX").string();
    const int file = mkstemp(&name[0]);
    if (file < 0) throw std::runtime_error("cannot be unpacked to " + name);
    close(file);
    path_ = name;
    std::ofstream out(path_, std::ios::binary);
    out.write(reinterpret_cast<const char*>(plain.data()), static_cast<std::streamsize>(plain.size()));
    out.close();
    if (out) return;
    std::error_code ignored;
    fs::remove(path_, ignored);
    throw std::runtime_error("cannot be unpacked to " + name + ": " + std::to_string(plain.size()) +
                             " bytes do not fit there (TMPDIR names another folder)");
  }
  ~UnpackedFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  UnpackedFile(const UnpackedFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

class McapBag : public BagFile {
 public:
  explicit McapBag(const std::string& path) : reader_(path) {
    for (const auto& [id, channel] : reader_.channels()) {
      const auto schema = reader_.schemas().find(channel.schema_id);
      if (schema == reader_.schemas().end()) continue;
      index_[id] = topics_.size();
      topics_.push_back(
          {channel.topic, find_ros_name(schema->second.name), schema->second.encoding, schema->second.text, 0});
    }
  }
  const std::vector<BagTopic>& topics() const override { return topics_; }
  void read(const std::set<std::string>& topics, const std::function<void(const BagMessage&)>& visit) override {
    reader_.read_messages(
        [&](const mcap::Message& message) {
          const auto at = index_.find(message.channel_id);
          if (at != index_.end())
            visit({at->second, static_cast<int64_t>(message.log_time), {message.data, message.size}});
          return true;
        },
        topics);
  }
  std::string damage() const override { return reader_.damage(); }

 private:
  mcap::Reader reader_;
  std::vector<BagTopic> topics_;
  std::map<uint16_t, size_t> index_;
};

// A file that was unpacked, and its reader.
class PackedBag : public BagFile {
 public:
  PackedBag(const std::string& path, const std::function<std::unique_ptr<BagFile>(const std::string&)>& open)
      : unpacked_(path), file_(open(unpacked_.path())) {}
  const std::vector<BagTopic>& topics() const override { return file_->topics(); }
  void read(const std::set<std::string>& topics, const std::function<void(const BagMessage&)>& visit) override {
    file_->read(topics, visit);
  }
  std::string damage() const override { return file_->damage(); }

 private:
  UnpackedFile unpacked_;
  std::unique_ptr<BagFile> file_;
};

std::unique_ptr<BagFile> open_plain(const std::string& name, const std::string& path) {
  if (ends_with(name, ".db3")) return open_sqlite_bag(path);
  if (ends_with(name, ".mcap")) return std::make_unique<McapBag>(path);
  if (ends_with(name, ".bag")) return open_ros1_bag(path);
  throw std::runtime_error("is no bag file: expected .bag, .mcap, .db3, .mcap.zstd or .db3.zstd");
}

std::unique_ptr<BagFile> open_file(const std::string& path) {
  try {
    if (!ends_with(path, ".zstd")) return open_plain(path, path);
    const std::string name = path.substr(0, path.size() - 5);
    return std::make_unique<PackedBag>(path, [&](const std::string& plain) { return open_plain(name, plain); });
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    refuse_input(path, std::string("cannot be read as a ROS bag: ") + error.what());
  }
}

// Files of a folder without metadata.yaml (a recorder that was killed), by name.
std::vector<std::string> list_files(const fs::path& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    for (const char* end : {".mcap", ".db3", ".mcap.zstd", ".db3.zstd"}) {
      if (ends_with(name, end)) files.push_back(entry.path().string());
    }
  }
  if (error) refuse_input(folder.string(), "cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

RosBag::RosBag(const std::string& path) : path_(path) {
  fs::path folder(path);
  if (folder.filename() == "metadata.yaml") folder = folder.parent_path();
  std::error_code error;  // a name that is too long for a file, links in a circle
  if (!fs::is_directory(folder, error)) {
    files_ = {path};
  } else if (fs::is_regular_file(folder / "metadata.yaml", error)) {
    const BagMetadata metadata = read_bag_metadata((folder / "metadata.yaml").string());
    if (metadata.compression_mode == "message") message_compression_ = metadata.compression_format;
    for (const std::string& file : metadata.files) files_.push_back((folder / file).string());
  } else {
    files_ = list_files(folder);
    if (files_.empty()) refuse_input(folder.string(), "is no ROS bag: no metadata.yaml, no .mcap and no .db3 in it");
  }
  if (!message_compression_.empty() && message_compression_ != "zstd")
    refuse_input(path, "messages are compressed with '" + message_compression_ + "', expected zstd");
  for (const std::string& file : files_) {
    if (!fs::is_regular_file(file, error)) refuse_input(file, "is named in metadata.yaml and is not there");
    const std::unique_ptr<BagFile> open = open_file(file);
    for (const BagTopic& topic : open->topics()) {
      const auto same =
          std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& t) { return t.name == topic.name; });
      if (same == topics_.end())
        topics_.push_back(topic);
      else
        same->count += topic.count;
    }
  }
}

std::string RosBag::read(const std::set<std::string>& topics,
                         const std::function<void(const BagMessage&)>& visit) const {
  std::string damage;
  for (const std::string& file : files_) {
    const std::unique_ptr<BagFile> open = open_file(file);
    std::vector<size_t> index;  // of the file's topics in ours
    for (const BagTopic& topic : open->topics()) {
      const auto same =
          std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& t) { return t.name == topic.name; });
      index.push_back(static_cast<size_t>(same - topics_.begin()));
    }
    std::vector<uint8_t> plain;
    try {
      open->read(topics, [&](const BagMessage& message) {
        BagMessage out = message;
        out.topic = index[message.topic];
        if (!message_compression_.empty()) {
          plain = unpack(message.data.data, message.data.size);
          out.data = {plain.data(), plain.size()};
        }
        visit(out);
      });
    } catch (const std::runtime_error& error) {
      if (dynamic_cast<const InputError*>(&error) != nullptr) throw;
      refuse_input(file, error.what());
    }
    if (!open->damage().empty()) damage += file + ": the bag is cut short: " + open->damage();
  }
  return damage;
}

bool is_ros_bag(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return true;
  for (const char* end : {".bag", ".db3", ".db3.zstd", ".mcap.zstd", "metadata.yaml"}) {
    if (ends_with(path, end)) return true;
  }
  if (!ends_with(path, ".mcap")) return false;
  try {
    const mcap::Reader reader(path);
    return std::none_of(reader.schemas().begin(), reader.schemas().end(),
                        [](const auto& schema) { return schema.second.name.rfind("hrp::", 0) == 0; });
  } catch (const std::exception&) {
    return false;  // the reader of logs says what is wrong
  }
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// Storage sqlite3 of rosbag2: tables `topics` and `messages`; from ROS 2 Iron on `message_definitions`.
#include <sqlite3.h>

#include <map>
#include <stdexcept>

#include "common/log/ros_bag.h"
#include "common/log/ros_types.h"

namespace hrp {
namespace {

class Statement {
 public:
  Statement(sqlite3* database, const std::string& text) : database_(database) {
    if (sqlite3_prepare_v2(database, text.c_str(), -1, &statement_, nullptr) != SQLITE_OK)
      throw std::runtime_error(sqlite3_errmsg(database));
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  bool step() {
    const int status = sqlite3_step(statement_);
    if (status != SQLITE_ROW && status != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(database_));
    return status == SQLITE_ROW;
  }
  std::string text(int column) const {
    const unsigned char* text = sqlite3_column_text(statement_, column);
    return text ? reinterpret_cast<const char*>(text) : "";
  }
  int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  Bytes bytes(int column) const {
    return {static_cast<const uint8_t*>(sqlite3_column_blob(statement_, column)),
            static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
  }

 private:
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

class SqliteBag : public BagFile {
 public:
  explicit SqliteBag(const std::string& path) {
    // Read only and never locked: a bag on a read-only disk, with or without a journal beside it.
    if (sqlite3_open_v2(path.c_str(), &database_, SQLITE_OPEN_READONLY, nullptr) != SQLITE_OK) {
      const std::string why = sqlite3_errmsg(database_);
      sqlite3_close(database_);
      throw std::runtime_error(why);
    }
    try {
      list_topics();
    } catch (...) {
      sqlite3_close(database_);
      throw;
    }
  }
  ~SqliteBag() override { sqlite3_close(database_); }

  const std::vector<BagTopic>& topics() const override { return topics_; }

  void read(const std::set<std::string>& topics, const std::function<void(const BagMessage&)>& visit) override {
    std::string ids;
    for (const auto& [id, at] : index_) {
      if (topics.empty() || topics.count(topics_[at].name) > 0) ids += (ids.empty() ? "" : ",") + std::to_string(id);
    }
    Statement rows(database_, "SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + ids +
                                  ") ORDER BY timestamp, id");
    while (rows.step()) visit({index_.at(rows.integer(0)), rows.integer(1), rows.bytes(2)});
  }

 private:
  void list_topics() {
    Statement rows(database_, "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
    while (rows.step()) {
      if (rows.text(3) != "cdr") continue;
      index_[rows.integer(0)] = topics_.size();
      topics_.push_back({rows.text(1), find_ros_name(rows.text(2)), "", "", 0});
    }
    Statement has(database_, "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = 'message_definitions'");
    if (!has.step()) return;
    Statement definitions(database_,
                          "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
    while (definitions.step()) {
      for (BagTopic& topic : topics_) {
        if (topic.type == find_ros_name(definitions.text(0))) {
          topic.encoding = definitions.text(1);
          topic.definition = definitions.text(2);
        }
      }
    }
  }

  sqlite3* database_ = nullptr;
  std::vector<BagTopic> topics_;
  std::map<int64_t, size_t> index_;
};

}  // namespace

std::unique_ptr<BagFile> open_sqlite_bag(const std::string& path) { return std::make_unique<SqliteBag>(path); }

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// A file that this process alone writes, and that held nothing worth keeping before.
#pragma once

#include <string>

namespace hrp::mcap {

// What to do with a file that holds something already.
enum class Existing { kRefuse, kReplace };

// Locked (flock) until it goes, so that two runs never write one log. What it replaces stays as it is until clear(): a
// run that fails before its first step costs nobody an older log. A new file holds the beginning of a log from the
// start, so that what a kill leaves behind can be opened at any time; one that holds no more than that at the end is
// removed.
class ClaimedFile {
 public:
  // Throws McapError: not writable, written by another program right now, or not empty and to be kept.
  ClaimedFile(const std::string& path, Existing existing);
  ~ClaimedFile();
  ClaimedFile(ClaimedFile&& other) noexcept;
  ClaimedFile& operator=(ClaimedFile&&) = delete;

  const std::string& path() const { return path_; }
  int descriptor() const { return file_; }
  // Removes what was in it, but for the beginning of a log. Throws McapError.
  void clear();
  // Unlocks. Throws McapError when the system reports an error only now (network file systems, quotas).
  void close();

 private:
  // False when the file was removed by its last owner while we waited: the name is free again.
  bool lock(Existing existing);
  void give_back();
  [[noreturn]] void refuse(const std::string& reason);

  std::string path_;
  int file_ = -1;
};

// There is a file of this name that holds more than the beginning of a log.
bool holds_something(const std::string& path);

// Makes a file with the beginning of a log, so that nobody else takes the name; false when there is one. Throws
// McapError.
bool reserve_file(const std::string& path);

// True when both names lead to one file.
bool is_same_file(const std::string& one, const std::string& other);

}  // namespace hrp::mcap

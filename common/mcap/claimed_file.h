// SPDX-License-Identifier: BSD-3-Clause
// A file that this process alone writes, and that held nothing worth keeping before.
#pragma once

#include <string>

namespace hrp::mcap {

// What to do with a file that holds something already.
enum class Existing { kRefuse, kReplace };

// Locked (flock) until it goes, so that two runs never write one log. What it replaces stays as it is until clear(): a run
// that fails before its first step costs nobody an older log. A file that is still empty at the end is removed.
class ClaimedFile {
 public:
  // Throws McapError: not writable, written by another program right now, or not empty and to be kept.
  ClaimedFile(const std::string& path, Existing existing);
  ~ClaimedFile();
  ClaimedFile(ClaimedFile&& other) noexcept;
  ClaimedFile& operator=(ClaimedFile&&) = delete;

  const std::string& path() const { return path_; }
  int descriptor() const { return file_; }
  // Removes what was in it. Throws McapError.
  void clear();
  // Unlocks. Throws McapError when the system reports an error only now (network file systems, quotas).
  void close();

 private:
  // False when the file was removed by its last owner while we waited: the name is free again.
  bool lock(Existing existing);
  [[noreturn]] void refuse(const std::string& reason);

  std::string path_;
  int file_ = -1;
};

// True when both names lead to one file.
bool is_same_file(const std::string& one, const std::string& other);

}  // namespace hrp::mcap

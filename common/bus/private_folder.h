// SPDX-License-Identifier: BSD-3-Clause
// A folder that only this user can read and write: what lies there tells who may join and steer a run.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace hrp {

// An open folder whose owner is this user and which nobody else may enter. Files are opened relative to it, so that a
// folder which is moved or replaced later changes nothing.
class PrivateFolder {
 public:
  // Makes the folder (mode 0700) when it is missing. Throws BusError, with the reason, when `path` is a symlink, no
  // folder, or somebody else's. Group and others lose what rights they have to a folder of our own.
  static PrivateFolder make(const std::string& path);
  // The same without making it; empty when it is missing or may not be trusted.
  static std::optional<PrivateFolder> find(const std::string& path);

  PrivateFolder(PrivateFolder&& other) noexcept;
  PrivateFolder& operator=(PrivateFolder&& other) noexcept;
  ~PrivateFolder();

  const std::string& path() const { return path_; }
  // A file of the folder for reading and writing, -1 (errno) when it cannot be opened. Never follows a symlink.
  int open_file(const std::string& name, bool make_it) const;
  // `file` is still the one of this name, so its lock counts.
  bool is_same(const std::string& name, int file) const;
  std::string read(const std::string& name) const;  // empty when it cannot be read
  // Readers see the old text or the new one, never a part. Throws BusError.
  void replace(const std::string& name, const std::string& text) const;
  void remove(const std::string& name) const;
  std::vector<std::string> find_files() const;

 private:
  PrivateFolder(std::string path, int folder) : path_(std::move(path)), folder_(folder) {}
  std::string path_;
  int folder_ = -1;
};

}  // namespace hrp

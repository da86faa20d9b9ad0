// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/claimed_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "common/mcap/format.h"

namespace hrp::mcap {

ClaimedFile::ClaimedFile(const std::string& path, Existing existing) : path_(path) {
  while (!lock(existing)) {
  }
}

ClaimedFile::ClaimedFile(ClaimedFile&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}

ClaimedFile::~ClaimedFile() {
  try {
    close();
  } catch (const McapError&) {
    // Said to whoever called close(); a destructor has nobody to tell.
  }
}

void ClaimedFile::refuse(const std::string& reason) {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
  throw McapError(path_ + " " + reason);
}

bool ClaimedFile::lock(Existing existing) {
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) refuse(std::string("cannot be opened for writing: ") + std::strerror(errno));
  struct stat info {};
  if (::fstat(file_, &info) != 0) refuse(std::string("cannot be read: ") + std::strerror(errno));
  if (!S_ISREG(info.st_mode)) return true;  // /dev/null, a pipe: nothing to lose
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    // A file system without locks is no reason to log nothing.
    if (errno == EWOULDBLOCK) refuse("is being written by another program; choose another name");
  }
  if (::fstat(file_, &info) != 0) refuse(std::string("cannot be read: ") + std::strerror(errno));
  if (info.st_nlink == 0) {
    ::close(std::exchange(file_, -1));
    return false;
  }
  if (info.st_size > 0 && existing == Existing::kRefuse) {
    refuse("is there already (" + std::to_string(info.st_size) + " bytes); choose another name, or --force to overwrite it");
  }
  return true;
}

void ClaimedFile::clear() {
  struct stat info {};
  if (::fstat(file_, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size == 0) return;
  if (::ftruncate(file_, 0) != 0) throw McapError(path_ + ": cannot be emptied: " + std::strerror(errno));
}

void ClaimedFile::close() {
  if (file_ < 0) return;
  struct stat info {};
  if (::fstat(file_, &info) == 0 && S_ISREG(info.st_mode) && info.st_size == 0) ::unlink(path_.c_str());
  if (::close(std::exchange(file_, -1)) != 0) throw McapError(path_ + ": cannot be closed: " + std::strerror(errno));
}

bool is_same_file(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return std::filesystem::equivalent(one, other, ignored);
}

}  // namespace hrp::mcap

// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/claimed_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <utility>

#include "common/mcap/format.h"

namespace hrp::mcap {

namespace {

std::string make_beginning() {
  Buffer bytes;
  put_beginning(&bytes);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool is_beginning(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string expected = make_beginning();
  std::string bytes(expected.size() + 1, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return bytes.substr(0, static_cast<size_t>(file.gcount())) == expected;
}

// An error number, 0 for none. The place of the next write() stays where it was.
int write_beginning(int file) {
  const std::string bytes = make_beginning();
  const ssize_t written = ::pwrite(file, bytes.data(), bytes.size(), 0);
  if (written < 0) return errno;
  return static_cast<size_t>(written) == bytes.size() ? 0 : ENOSPC;
}

// Makes a file that gets its name when the beginning of a log is in it: a kill leaves no empty file behind. False where
// the name is taken, or where the system does not make such files: then another way is tried, and tells why it fails.
bool make_with_beginning(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int file = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0644);
  if (file < 0) return false;
  const std::string own = "/proc/self/fd/" + std::to_string(file);
  const bool made =
      write_beginning(file) == 0 && ::linkat(AT_FDCWD, own.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) == 0;
  ::close(file);
  return made;
}

}  // namespace

ClaimedFile::ClaimedFile(const std::string& path, Existing existing) : path_(path) {
  try {
    while (!lock(existing)) {
    }
  } catch (const std::bad_alloc&) {
    give_back();
    throw;
  }
}

// Of a file that holds nothing yet: its name is free again.
void ClaimedFile::give_back() {
  if (file_ < 0) return;
  struct stat info {};
  if (::fstat(file_, &info) == 0 && S_ISREG(info.st_mode) && info.st_size == 0) ::unlink(path_.c_str());
  ::close(std::exchange(file_, -1));
}

ClaimedFile::ClaimedFile(ClaimedFile&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}

ClaimedFile::~ClaimedFile() {
  try {
    close();
  } catch (const std::bad_alloc&) {
    give_back();  // not read again for want of memory: what is in it stays
  } catch (const McapError&) {
    // Said to whoever called close(); a destructor has nobody to tell.
  }
}

void ClaimedFile::refuse(const std::string& reason) {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
  throw McapError(path_ + " " + reason);
}

bool ClaimedFile::lock(Existing existing) {
  make_with_beginning(path_);
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
  const bool holds = info.st_size > 0 && !is_beginning(path_);
  if (holds && existing == Existing::kRefuse) {
    refuse("is there already (" + std::to_string(info.st_size) +
           " bytes); choose another name, or --force to overwrite it");
  }
  if (holds) return true;
  if (const int error = write_beginning(file_)) {
    ::unlink(path_.c_str());
    refuse(std::string("cannot be written: ") + std::strerror(error));
  }
  return true;
}

void ClaimedFile::clear() {
  struct stat info {};
  if (::fstat(file_, &info) != 0 || !S_ISREG(info.st_mode)) return;
  if (const int error = write_beginning(file_)) throw McapError(path_ + ": cannot be written: " + std::strerror(error));
  const auto size = static_cast<off_t>(make_beginning().size());
  if (::ftruncate(file_, size) != 0) throw McapError(path_ + ": cannot be emptied: " + std::strerror(errno));
}

void ClaimedFile::close() {
  if (file_ < 0) return;
  struct stat info {};
  const bool regular = ::fstat(file_, &info) == 0 && S_ISREG(info.st_mode);
  if (regular && (info.st_size == 0 || is_beginning(path_))) ::unlink(path_.c_str());
  if (::close(std::exchange(file_, -1)) != 0) throw McapError(path_ + ": cannot be closed: " + std::strerror(errno));
}

bool holds_something(const std::string& path) {
  std::error_code error;
  return std::filesystem::file_size(path, error) > 0 && !error && !is_beginning(path);
}

bool reserve_file(const std::string& path) {
  if (make_with_beginning(path)) return true;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file < 0 && errno == EEXIST) return false;
  int error = file < 0 ? errno : write_beginning(file);
  if (file >= 0) ::close(file);
  if (file >= 0 && error != 0) ::unlink(path.c_str());
  if (error != 0) throw McapError(path + ": " + std::strerror(error));
  return true;
}

bool is_same_file(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return std::filesystem::equivalent(one, other, ignored);
}

}  // namespace hrp::mcap

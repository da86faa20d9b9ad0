// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/private_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "common/bus/bus.h"

namespace hrp {
namespace {

constexpr int kFolderFlags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;

// Why an open folder may not be trusted; empty when it may.
std::string find_objection(int folder) {
  struct stat info {};
  if (fstat(folder, &info) != 0) return std::strerror(errno);
  if (info.st_uid != geteuid()) {
    return "it belongs to user " + std::to_string(info.st_uid) + ", not to this one (" + std::to_string(geteuid()) +
           ")";
  }
  if ((info.st_mode & 077) != 0 && fchmod(folder, 0700) != 0)
    return std::string("its mode cannot be set to 0700: ") + std::strerror(errno);
  return "";
}

}  // namespace

PrivateFolder PrivateFolder::make(const std::string& path) {
  if (mkdir(path.c_str(), 0700) != 0 && errno != EEXIST) {
    throw BusError("cannot make the folder " + path + ": " + std::strerror(errno));
  }
  const int folder = open(path.c_str(), kFolderFlags);
  if (folder < 0) {
    const bool link = errno == ELOOP || errno == ENOTDIR;
    throw BusError("the folder of runs " + path +
                   " is not used: " + (link ? "it is a symlink or a file" : std::strerror(errno)));
  }
  PrivateFolder made(path, folder);
  const std::string objection = find_objection(folder);
  if (!objection.empty()) throw BusError("the folder of runs " + path + " is not used: " + objection);
  return made;
}

std::optional<PrivateFolder> PrivateFolder::find(const std::string& path) {
  const int folder = open(path.c_str(), kFolderFlags);
  if (folder < 0) return std::nullopt;
  PrivateFolder found(path, folder);
  if (!find_objection(folder).empty()) return std::nullopt;
  return found;
}

PrivateFolder::PrivateFolder(PrivateFolder&& other) noexcept
    : path_(std::move(other.path_)), folder_(std::exchange(other.folder_, -1)) {}

PrivateFolder& PrivateFolder::operator=(PrivateFolder&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(folder_, other.folder_);
  return *this;
}

PrivateFolder::~PrivateFolder() {
  if (folder_ >= 0) close(folder_);
}

int PrivateFolder::open_file(const std::string& name, bool make_it) const {
  return openat(folder_, name.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | (make_it ? O_CREAT : 0), 0600);
}

bool PrivateFolder::is_same(const std::string& name, int file) const {
  struct stat by_name {
  }, by_file{};
  return fstatat(folder_, name.c_str(), &by_name, AT_SYMLINK_NOFOLLOW) == 0 && fstat(file, &by_file) == 0 &&
         by_name.st_ino == by_file.st_ino && by_name.st_dev == by_file.st_dev;
}

std::string PrivateFolder::read(const std::string& name) const {
  const int file = openat(folder_, name.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return "";
  std::string text;
  char part[4096];
  for (ssize_t size; (size = ::read(file, part, sizeof part)) > 0 && text.size() < (1u << 20);) {
    text.append(part, static_cast<size_t>(size));
  }
  close(file);
  return text;
}

void PrivateFolder::replace(const std::string& name, const std::string& text) const {
  const std::string fresh = name + "." + std::to_string(getpid());
  const int file = openat(folder_, fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  bool good = file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (file >= 0) close(file);
  good = good && renameat(folder_, fresh.c_str(), folder_, name.c_str()) == 0;
  if (good) return;
  const std::string reason = std::strerror(errno);
  remove(fresh);
  throw BusError("cannot write " + path_ + "/" + name + ": " + reason);
}

void PrivateFolder::remove(const std::string& name) const { unlinkat(folder_, name.c_str(), 0); }

std::vector<std::string> PrivateFolder::find_files() const {
  std::vector<std::string> names;
  DIR* list = fdopendir(openat(folder_, ".", kFolderFlags));
  if (!list) return names;
  while (const dirent* entry = readdir(list)) names.emplace_back(entry->d_name);
  closedir(list);
  return names;
}

}  // namespace hrp

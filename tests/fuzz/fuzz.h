// SPDX-License-Identifier: BSD-3-Clause
// What all fuzz targets need. A reader may refuse its input with an exception that its header names; anything else that
// goes wrong (a sanitizer's finding, another exception, more than 2 GB, or than 25 s of a processor) ends the target
// with the input in a file.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace hrp::test {

inline std::string make_text(const uint8_t* data, size_t size) {
  return std::string(reinterpret_cast<const char*>(data), size);
}

// The input as a file, for readers that want a path: it is in memory only. `ending` (".obj"): of a link to it, for
// readers that look at the name.
class MemoryFile {
 public:
  MemoryFile(const uint8_t* data, size_t size, const std::string& ending = "")
      : file_(memfd_create("fuzz", MFD_CLOEXEC)) {
    if (file_ < 0 || write(file_, data, size) != static_cast<ssize_t>(size)) std::abort();
    path_ = "/proc/self/fd/" + std::to_string(file_);
    if (ending.empty()) return;
    link_ = "/tmp/hrp_fuzz_" + std::to_string(getpid()) + ending;
    if (symlink(path_.c_str(), link_.c_str()) != 0) std::abort();
  }
  ~MemoryFile() {
    if (!link_.empty()) unlink(link_.c_str());
    close(file_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  const std::string& path() const { return link_.empty() ? path_ : link_; }

 private:
  int file_;
  std::string path_, link_;
};

}  // namespace hrp::test

// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/mjcf/compiled_model.h"

#include <climits>
#include <cstring>
#include <mutex>
#include <stdexcept>

namespace hrp {
namespace {

// MuJoCo's handlers are global. Its own one for errors ends the process; this one leaves the compiler by an exception.
[[noreturn]] void throw_error(const char* message) { throw std::runtime_error(message); }
void ignore_warning(const char*) {}

class Handlers {
 public:
  Handlers() : lock_(get_mutex()), error_(mju_user_error), warning_(mju_user_warning) {
    mju_user_error = throw_error;
    mju_user_warning = ignore_warning;
  }
  ~Handlers() {
    mju_user_error = error_;
    mju_user_warning = warning_;
  }
  Handlers(const Handlers&) = delete;
  Handlers& operator=(const Handlers&) = delete;

 private:
  static std::mutex& get_mutex() {
    static std::mutex mutex;
    return mutex;
  }
  std::lock_guard<std::mutex> lock_;
  void (*error_)(const char*);
  void (*warning_)(const char*);
};

// The text as the only file of a file system in memory; files that are not in it are read from the disk.
class TextFile {
 public:
  TextFile(const std::string& text, const std::string& path) : vfs_(std::make_unique<mjVFS>()) {
    mj_defaultVFS(vfs_.get());
    if (text.size() > INT_MAX || mj_makeEmptyFileVFS(vfs_.get(), path.c_str(), static_cast<int>(text.size())) != 0) {
      throw std::runtime_error("cannot be given to MuJoCo: its name or its text is too long");
    }
    std::memcpy(vfs_->filedata[0], text.data(), text.size());
  }
  ~TextFile() { mj_deleteVFS(vfs_.get()); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  const mjVFS* get() const { return vfs_.get(); }

 private:
  std::unique_ptr<mjVFS> vfs_;
};

}  // namespace

CompiledModel compile_mjcf(const std::string& text, const std::string& path) {
  const Handlers handlers;
  const TextFile file(text, path);
  char error[1000] = "";
  CompiledModel model(mj_loadXML(path.c_str(), file.get(), error, sizeof error));
  if (!model) throw std::runtime_error(error);
  return model;
}

}  // namespace hrp

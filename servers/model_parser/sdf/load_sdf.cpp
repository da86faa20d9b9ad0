// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/sdf/load_sdf.h"

#include <filesystem>
#include <mutex>

namespace hrp {
namespace {

namespace fs = std::filesystem;

// Folder or file of an included model; empty when there is none.
std::string find_model(const std::string& uri, const fs::path& file) {
  const size_t scheme = uri.find("://");
  const fs::path name = scheme == std::string::npos ? uri : uri.substr(scheme + 3);
  std::error_code error;
  fs::path folder = fs::absolute(file, error).parent_path();
  for (int depth = 0; depth < 64; ++depth) {
    if (fs::exists(folder / name, error)) return (folder / name).string();
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return "";
}

// libsdformat's console is global; what matters comes back as errors.
sdf::Errors load(const std::string& text, const std::string& path, sdf::Root* root) {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  sdf::Console::Instance()->SetQuiet(true);
  sdf::ParserConfig config;
  config.SetWarningsPolicy(sdf::EnforcementPolicy::LOG);
  config.SetUnrecognizedElementsPolicy(sdf::EnforcementPolicy::LOG);
  config.SetFindCallback([&](const std::string& uri) { return find_model(uri, path); });
  return root->LoadSdfString(text, config);
}

}  // namespace

bool load_sdf(const std::string& text, const std::string& path, sdf::Root* root, Diagnostics* diagnostics) {
  Diagnostic d;
  d.file = path;
  try {
    for (const sdf::Error& e : load(text, path, root)) {
      d.line = e.LineNumber().value_or(0);
      d.message = "libsdformat refuses it: " + e.Message();
      diagnostics->add_error(d);
    }
  } catch (const std::exception& error) {
    d.message = std::string("libsdformat refuses it: ") + error.what();
    diagnostics->add_error(d);
  }
  return !diagnostics->has_errors();
}

}  // namespace hrp

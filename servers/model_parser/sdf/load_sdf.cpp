// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/sdf/load_sdf.h"

#include <filesystem>
#include <memory>
#include <mutex>

#include <tinyxml2.h>

#include "servers/model_parser/xml_values.h"

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

// Everything that SDF knows. LoadSdfString() reads libsdformat's own forty files of it for every text: half of its
// time.
const sdf::Element& get_schema() {
  static const sdf::ElementPtr schema = [] {
    const sdf::SDFPtr all = std::make_shared<sdf::SDF>();
    sdf::init(all);
    return all->Root();
  }();
  return *schema;
}

// An empty <sdf>. Reading a text copies the descriptions of its elements, so several may share them.
sdf::SDFPtr make_empty_sdf() {
  const sdf::Element& schema = get_schema();
  const sdf::ElementPtr root = std::make_shared<sdf::Element>();
  root->SetName(schema.GetName());
  root->SetRequired(schema.GetRequired());
  for (const sdf::ParamPtr& a : schema.GetAttributes())
    root->AddAttribute(a->GetKey(), a->GetTypeName(), a->GetDefaultAsString(), a->GetRequired(), a->GetDescription());
  for (size_t i = 0; i < schema.GetElementDescriptionCount(); ++i)
    root->AddElementDescription(schema.GetElementDescription(static_cast<unsigned int>(i)));
  sdf::SDFPtr out = std::make_shared<sdf::SDF>();
  out->Root(root);
  return out;
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
  const sdf::SDFPtr parsed = make_empty_sdf();
  sdf::Errors errors;
  if (!sdf::readString(text, config, parsed, errors)) {
    if (errors.empty()) errors.push_back({sdf::ErrorCode::STRING_READ, "expected <sdf version=\"...\">"});
    return errors;
  }
  const sdf::Errors more = root->Load(parsed, config);
  errors.insert(errors.end(), more.begin(), more.end());
  return errors;
}

}  // namespace

bool load_sdf(const std::string& text, const std::string& path, sdf::Root* root, Diagnostics* diagnostics) {
  tinyxml2::XMLDocument document;  // what is no XML it refuses without a reason
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS) {
    add_xml_error(document, text, path, diagnostics);
    return false;
  }
  try {
    for (const sdf::Error& e : load(text, path, root)) {
      diagnostics->add_error({path, "", e.LineNumber().value_or(0)}, "libsdformat refuses it: " + e.Message());
    }
  } catch (const std::exception& error) {
    diagnostics->add_error(path, std::string("libsdformat refuses it: ") + error.what());
  }
  return !diagnostics->has_errors();
}

}  // namespace hrp

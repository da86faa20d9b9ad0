// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/cyclone/cyclone_security.h"

#include <dds/dds.h>
#include <dlfcn.h>

#include <memory>

#include "common/base/escape_xml.h"
#include "common/bus/bus.h"

namespace hrp {
namespace {

// Debian puts the plugins in a folder beside the library, where the loader does not look by itself.
std::string find_plugin(const std::string& name) {
  Dl_info info{};
  const std::string library =
      dladdr(reinterpret_cast<const void*>(&dds_create_domain), &info) && info.dli_fname ? info.dli_fname : "";
  const std::string folder = library.substr(0, library.rfind('/') + 1);
  const std::string file = "libdds_security_" + name + ".so";
  for (const std::string& path : {folder + "libddsc0debian/" + file, folder + file, file}) {
    if (void* opened = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      dlclose(opened);
      return path;
    }
  }
  throw BusError("this Cyclone DDS has no security plugin " + file +
                 "; Debian's package libddsc0debian has it, or use --dds fast");
}

std::string make_library(const std::string& name, const std::string& function) {
  return R"(<Library path=")" + find_plugin(name) + R"(" initFunction="init_)" + function +
         R"(" finalizeFunction="finalize_)" + function + R"("/>)";
}

std::string make_element(const std::string& name, const std::string& text) {
  return "<" + name + ">" + text + "</" + name + ">";
}

// In XML.
std::string make_uri(const std::string& path) { return "file:" + escape_xml(path); }

}  // namespace

std::string find_cyclone_security(const SecureFiles& files) {
  const std::string revoked = files.revoked.empty() ? "" : make_element("CRL", make_uri(files.revoked));
  return make_element(
      "Security", make_element("Authentication", make_library("auth", "authentication") +
                                                     make_element("IdentityCA", make_uri(files.authority)) +
                                                     make_element("IdentityCertificate", make_uri(files.certificate)) +
                                                     make_element("PrivateKey", make_uri(files.key)) + revoked) +
                      make_element("Cryptographic", make_library("crypto", "crypto")) +
                      make_element("AccessControl", make_library("ac", "access_control") +
                                                        make_element("PermissionsCA", make_uri(files.authority)) +
                                                        make_element("Governance", make_uri(files.governance)) +
                                                        make_element("Permissions", make_uri(files.permissions))));
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// The identity with which a program joins a secured run: a folder that scripts/secure.sh made.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace hrp {

struct SecureFiles {
  std::string folder;
  std::string authority;  // certificate that signed everything else
  std::string certificate;
  std::string key;
  std::string governance;   // S/MIME
  std::string permissions;  // S/MIME
  std::string revoked;      // list of certificates that count no more; empty: none
};

// `folder` is one identity's, or holds those of scripts/secure.sh: then it is folder/look for those who only look, and
// folder/command for everybody else, as far as it is there. Throws InputError, with the reason, for files that are
// missing, certificates that are over, not yet valid, revoked or of another authority, and keys that others may read.
SecureFiles find_secure_files(const std::string& folder, bool only_looks);

}  // namespace hrp

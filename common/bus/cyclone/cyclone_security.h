// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/bus/secure_folder.h"

namespace hrp {

// The element <Security> of Cyclone's configuration. Throws BusError when the plugins are not installed.
std::string find_cyclone_security(const SecureFiles& files);

}  // namespace hrp

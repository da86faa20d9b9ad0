// SPDX-License-Identifier: BSD-3-Clause
// Changes single attributes in the text of a URDF and keeps the rest unchanged.
#pragma once

#include <string>

namespace hrp::diagnosis {

// True if the tag at `at` stands between <!-- and -->.
bool is_in_comment(const std::string& xml, size_t at);

// Sets an attribute of an element in a joint ("dynamics"), or of the joint's own tag (element ""). No change if joint,
// element or attribute is missing. A <joint> in a <transmission> or a comment does not
// count.
std::string set_joint_attribute(const std::string& urdf, const std::string& joint, const std::string& element,
                                const std::string& attribute, const std::string& value);

}  // namespace hrp::diagnosis

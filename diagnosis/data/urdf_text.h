// SPDX-License-Identifier: BSD-3-Clause
// Small changes in the text of a URDF that leave the rest of it as its author wrote it.
#pragma once

#include <string>

namespace hrp::diagnosis {

// Sets an attribute of an element within a joint ("dynamics"), or of the joint's own tag (element ""). Unchanged where the
// joint, the element or the attribute is not there. A <joint> within a <transmission> is none.
std::string set_joint_attribute(const std::string& urdf, const std::string& joint, const std::string& element,
                                const std::string& attribute, const std::string& value);

}  // namespace hrp::diagnosis

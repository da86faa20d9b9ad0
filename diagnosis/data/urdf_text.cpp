// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/urdf_text.h"

#include <cctype>

namespace hrp::diagnosis {
namespace {

// Position of `what` in text[begin, end); npos if it is not there.
size_t find_within(const std::string& text, const std::string& what, size_t begin, size_t end) {
  const size_t at = text.find(what, begin);
  return at < end ? at : std::string::npos;
}

// Start of an attribute's value, after its quote, in the tag at `tag`; npos if there is none.
size_t find_value(const std::string& text, size_t tag, const std::string& attribute) {
  const size_t end = text.find('>', tag);
  for (size_t at = find_within(text, attribute, tag, end); at != std::string::npos;
       at = find_within(text, attribute, at + 1, end)) {
    size_t next = at + attribute.size();
    while (next < end && std::isspace(static_cast<unsigned char>(text[next]))) ++next;
    if (next >= end || text[next] != '=' || !std::isspace(static_cast<unsigned char>(text[at - 1]))) continue;
    const size_t quote = text.find_first_of("\"'", next);
    return quote < end ? quote + 1 : std::string::npos;
  }
  return std::string::npos;
}

// True if the tag at `tag` is the joint of that name itself: it ends with </joint> and names its parent.
bool is_joint(const std::string& urdf, size_t tag, const std::string& joint, size_t end) {
  const size_t name = find_value(urdf, tag, "name"), close = urdf.find('>', tag);
  if (name == std::string::npos || urdf[close - 1] == '/' || urdf.compare(name, joint.size(), joint) != 0) return false;
  const char after = urdf[name + joint.size()];
  return (after == '"' || after == '\'') && find_within(urdf, "<parent", tag, end) != std::string::npos;
}

}  // namespace

bool is_in_comment(const std::string& xml, size_t at) {
  const size_t open = xml.rfind("<!--", at);
  return open != std::string::npos && xml.find("-->", open) > at;
}

std::string set_joint_attribute(const std::string& urdf, const std::string& joint, const std::string& element,
                                const std::string& attribute, const std::string& value) {
  for (size_t tag = urdf.find("<joint"); tag != std::string::npos; tag = urdf.find("<joint", tag + 1)) {
    const size_t end = urdf.find("</joint>", tag);
    if (end == std::string::npos || is_in_comment(urdf, tag) || !is_joint(urdf, tag, joint, end)) continue;
    const size_t at = element.empty() ? tag : find_within(urdf, "<" + element, tag, end);
    const size_t old = at == std::string::npos ? at : find_value(urdf, at, attribute);
    if (old == std::string::npos) continue;
    return urdf.substr(0, old) + value + urdf.substr(urdf.find(urdf[old - 1], old));
  }
  return urdf;
}

}  // namespace hrp::diagnosis

// SPDX-License-Identifier: BSD-3-Clause
// Text of others on a terminal of ours: names in files and words of messages may hold sequences that steer terminals.
#pragma once

#include <string>

namespace hrp {

// `text` with every control character as its code ("\x1b", "\xc2\x9b"); line feeds and tabs stay. What is no control
// character stays as it is, so names in any language do.
std::string make_printable(const std::string& text);

// The same for a text that is one line: line feeds are codes, too.
std::string make_printable_line(const std::string& text);

// The place of the first byte that is not UTF-8, as of Latin-1 or of no text at all; npos: there is none.
size_t find_strange_byte(const std::string& text);
// What is wrong with that byte, for a message.
std::string describe_strange_byte(const std::string& text, size_t at);

}  // namespace hrp

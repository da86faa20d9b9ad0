// SPDX-License-Identifier: BSD-3-Clause
// How many DDS participants find each other in one domain on one machine. Without multicast each looks at the ports of
// this many; both vendors number them from 0 in the same port range, whoever comes first.
#pragma once

namespace hrp {

constexpr int kMostParticipants = 40;

}  // namespace hrp

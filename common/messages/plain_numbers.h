// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <type_traits>

namespace hrp {

// Whether a generated struct is `count` numbers of 8 bytes side by side, which can be copied as one piece of memory.
template <typename T, size_t count>
constexpr bool kIsPlainNumbers = std::is_standard_layout_v<T> && sizeof(T) == 8 * count;

}  // namespace hrp

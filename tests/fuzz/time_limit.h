// SPDX-License-Identifier: BSD-3-Clause
// How long a fuzz target may work on one input, in processor time. A busy machine gives a target a few percent of a
// core, so a limit of a clock would blame inputs that take little work.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace hrp::test {

// From now on, an input that takes more ends the program by abort(), with a message. libFuzzer then keeps the input.
void limit_processor_time(std::chrono::microseconds limit);

}  // namespace hrp::test

// The linker puts it before the target's function (--wrap), so targets need not know of the limit. Without another
// limit: 25 s.
extern "C" int __wrap_LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

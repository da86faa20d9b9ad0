// SPDX-License-Identifier: BSD-3-Clause
// IDL: what was understood can be written as a text of its own, and that is understood again.
#include "common/base/diagnostics.h"
#include "common/messages/reflection/schema.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const hrp::Schema schema = hrp::parse_idl({{"f.idl", hrp::test::make_text(data, size)}});
    for (const std::string& name : schema.find_struct_names()) {
      try {
        const hrp::Schema alone = hrp::parse_idl({{"alone.idl", schema.find_text(name)}});
        if (alone.find_struct(name) == nullptr) std::abort();
      } catch (const hrp::InputError&) {
        std::abort();
      }
    }
  } catch (const hrp::InputError&) {
  }
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/add_error.h"

namespace hrp {

void add_error(const std::string& file, int line, const std::string& field, const std::string& message,
               Diagnostics* diagnostics) {
  Diagnostic d;
  d.file = file;
  d.line = line;
  d.field = field;
  d.message = message;
  diagnostics->add_error(d);
}

}  // namespace hrp

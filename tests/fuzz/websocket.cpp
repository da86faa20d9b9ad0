// SPDX-License-Identifier: BSD-3-Clause
// Messages of a client that was let in: lines of a page (first byte even) or of Foxglove (odd).
#include <sstream>

#include "servers/viewer/viewer.h"
#include "tests/fuzz/fuzz.h"

namespace {

class Nowhere final : public hrp::Connection {
 public:
  void send(hrp::Payload, bool, hrp::Urgency) override {}
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  hrp::Viewer viewer({});
  Nowhere connection;
  const auto client = data[0] % 2 == 0 ? viewer.make_page_client(connection) : viewer.make_foxglove_client(connection);
  std::istringstream lines(hrp::test::make_text(data + 1, size - 1));
  for (std::string line; std::getline(lines, line);) {
    try {
      client->on_message(line, line.size() % 2 == 1);
    } catch (const hrp::ProtocolError&) {
      return 0;  // such a client is cut off
    }
  }
  viewer.tick();
  return 0;
}

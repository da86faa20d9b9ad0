// SPDX-License-Identifier: BSD-3-Clause
// What the web server and the application know of each other: connections that carry messages, and clients that talk
// on them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace hrp {

// A message that makes no sense: ends the connection that it came on, and nothing else.
class ProtocolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Shared by all connections that get the same message.
using Payload = std::shared_ptr<const std::string>;

inline Payload make_payload(std::string text) { return std::make_shared<const std::string>(std::move(text)); }

enum class Urgency {
  kDroppable,  // pictures and samples: a page that is slow misses some
  kPicture,    // of a camera, large: sent when little else waits
  kStream,     // single samples for Foxglove: many small ones may wait, then some are missed
  kNeeded      // answers: a client that asks and does not read is cut off
};

// One WebSocket. Its queue is bounded: whoever does not read can cost no more than that.
class Connection {
 public:
  virtual ~Connection() = default;
  // False: it was dropped.
  virtual bool send(Payload payload, bool binary, Urgency urgency) = 0;
};

// Lives as long as its connection.
class Client {
 public:
  virtual ~Client() = default;
  // Throws ProtocolError.
  virtual void on_message(const std::string& message, bool binary) = 0;
};

struct WebFile {
  std::string content;
  std::string type;  // "text/html"
};

// What the server asks the application for.
class WebApplication {
 public:
  virtual ~WebApplication() = default;
  virtual std::unique_ptr<Client> make_page_client(Connection& connection) = 0;
  virtual std::unique_ptr<Client> make_foxglove_client(Connection& connection) = 0;
  // A file of the page ("/index.html") or a mesh ("/mesh?source=0&file=..."); nothing when there is none.
  virtual std::optional<WebFile> find_file(const std::string& target) = 0;
};

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// Typed ends of a topic: messages in and out instead of bytes.
#pragma once

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/bus/bus.h"
#include "common/messages/cdr.h"

namespace hrp {

template <typename Message>
class Publisher {
 public:
  Publisher() = default;  // publishes nowhere until one that was made is moved into it
  Publisher(Bus& bus, const TopicSpec& topic) : writer_(bus.make_writer(topic)) {}

  // Returns the bytes that were sent; they live until the next call.
  Bytes publish(const Message& message) {
    const Bytes sample = encode(message, &buffer_);
    if (writer_) writer_->write(sample);
    return sample;
  }

  // Sends bytes that were encoded before.
  void publish_bytes(Bytes sample) {
    if (writer_) writer_->write(sample);
  }

  // Of a topic whose samples are gathered.
  void flush() {
    if (writer_) writer_->flush();
  }

  bool has_readers() const { return writer_ && writer_->has_readers(); }

 private:
  std::unique_ptr<Writer> writer_;
  std::vector<char> buffer_;
};

using DecodeErrorCallback = std::function<void(const DecodeError&)>;

// `on_message` gets every sample, decoded into one message whose memory is reused: copy what is to be kept. It may take
// the bytes as a second argument. Samples that are no Message go to `on_error` (nullptr: they are dropped).
template <typename Message, typename OnMessage>
std::unique_ptr<Reader> subscribe(Bus& bus, const TopicSpec& topic, Delivery delivery, OnMessage on_message,
                                  DecodeErrorCallback on_error = nullptr) {
  auto message = std::make_shared<Message>();
  return bus.make_reader(topic, delivery,
                         [message, on_message = std::move(on_message), on_error = std::move(on_error)](Bytes sample) {
                           try {
                             decode(sample, message.get());
                           } catch (const DecodeError& error) {
                             if (on_error) on_error(error);
                             return;
                           }
                           const Message& decoded = *message;
                           if constexpr (std::is_invocable_v<OnMessage, const Message&, Bytes>) {
                             on_message(decoded, sample);
                           } else {
                             on_message(decoded);
                           }
                         });
}

}  // namespace hrp

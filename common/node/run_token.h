// SPDX-License-Identifier: BSD-3-Clause
// Who may steer a run: those who know its token, which lies in a private folder of the user who started it. The token
// is never sent, as everybody on the machine can read a topic: messages carry a signature that is made with it.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "common/messages/cdr.h"
#include "hrp_idl/scheduling.h"

namespace hrp {

// 32 hexadecimal digits from the system's source of random numbers.
std::string make_run_token();
// For a request: no other one has the same.
uint64_t make_nonce();
// HMAC-SHA256 of `size` bytes, its first 16 bytes in hexadecimal digits.
std::string calc_signature(const std::string& token, const void* data, size_t size);
bool is_same_text(const std::string& a, const std::string& b);  // takes equally long wherever they differ

// Signature of a message with the fields `signature`: of all its other fields, and of its type.
template <typename Message>
std::string find_signature(const std::string& token, const std::string& type, Message message) {
  message.signature("");
  std::vector<char> buffer;
  const Bytes bytes = encode(message, &buffer);
  std::string signed_bytes = type + '\0';
  signed_bytes.append(reinterpret_cast<const char*>(bytes.data), bytes.size);
  return calc_signature(token, signed_bytes.data(), signed_bytes.size());
}

// Runs without a token (in one process, or on other machines) sign nothing.
template <typename Message>
void sign(const std::string& token, const std::string& type, Message* message) {
  message->signature(token.empty() ? "" : find_signature(token, type, *message));
}

// Without a token nothing is checked.
template <typename Message>
bool is_signed(const std::string& token, const std::string& type, const Message& message) {
  return token.empty() || is_same_text(find_signature(token, type, message), message.signature());
}

const char* get_phase_text(msg::RunPhase phase);  // "running"
bool is_over(const msg::RunStatus& status);
// Of those who hold the token nobody believes an end or a refusal without its signature.
bool must_be_signed(const msg::RunStatus& status);
// Reports of a run that goes on are not signed, so none of them may undo its end. A run that went well may still fail:
// its logger finds out while it closes the file.
bool may_follow(const msg::RunStatus& heard, const msg::RunStatus& news);
// Both rules, for whoever looks at a run.
bool may_believe(const std::string& token, const msg::RunStatus& heard, const msg::RunStatus& news);

// Requests that were taken already: one that was recorded and is sent again counts for nothing.
class UsedNonces {
 public:
  bool take(uint64_t nonce) { return used_.insert(nonce).second; }

 private:
  std::set<uint64_t> used_;
};

}  // namespace hrp

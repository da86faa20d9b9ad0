// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/run_token.h"

#include <openssl/crypto.h>
#include <openssl/hmac.h>
#include <sys/random.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/messages/topics.h"

namespace hrp {
namespace {

constexpr size_t kTokenBytes = 16;

void fill_random(void* bytes, size_t size) {
  if (getrandom(bytes, size, 0) != static_cast<ssize_t>(size)) {
    throw std::runtime_error(std::string("no random numbers for a token: ") + std::strerror(errno));
  }
}

std::string format_hex(const unsigned char* bytes, size_t size) {
  static const char kDigits[] = "0123456789abcdef";
  std::string text;
  for (size_t i = 0; i < size; ++i) text += {kDigits[bytes[i] >> 4], kDigits[bytes[i] & 15]};
  return text;
}

}  // namespace

std::string make_run_token() {
  unsigned char bytes[kTokenBytes];
  fill_random(bytes, sizeof bytes);
  return format_hex(bytes, sizeof bytes);
}

uint64_t make_nonce() {
  uint64_t nonce = 0;
  fill_random(&nonce, sizeof nonce);
  return nonce;
}

std::string calc_signature(const std::string& token, const void* data, size_t size) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int digest_size = 0;
  if (!HMAC(EVP_sha256(), token.data(), static_cast<int>(token.size()), static_cast<const unsigned char*>(data), size,
            digest, &digest_size) ||
      digest_size < kTokenBytes) {
    throw std::runtime_error("the system's library cannot calculate HMAC-SHA256");
  }
  return format_hex(digest, kTokenBytes);
}

bool is_same_text(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

const char* get_phase_text(msg::RunPhase phase) {
  switch (phase) {
    case msg::RUN_RUNNING: return "running";
    case msg::RUN_PAUSED: return "paused";
    case msg::RUN_FINISHED: return "finished";
    case msg::RUN_FAILED: return "failed";
    default: return "waiting";
  }
}

bool is_over(const msg::RunStatus& status) {
  return status.phase() == msg::RUN_FINISHED || status.phase() == msg::RUN_FAILED;
}

bool must_be_signed(const msg::RunStatus& status) { return is_over(status) || !status.refused().empty(); }

bool may_follow(const msg::RunStatus& heard, const msg::RunStatus& news) {
  return !is_over(heard) || (heard.phase() == msg::RUN_FINISHED && news.phase() == msg::RUN_FAILED);
}

bool may_believe(const std::string& token, const msg::RunStatus& heard, const msg::RunStatus& news) {
  return may_follow(heard, news) && (!must_be_signed(news) || is_signed(token, topics::kRunStatus.type_name, news));
}

}  // namespace hrp

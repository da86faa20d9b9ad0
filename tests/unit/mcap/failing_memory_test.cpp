// SPDX-License-Identifier: BSD-3-Clause
// Logs while memory runs out: at each allocation in turn, that one alone and with all that follow.
#include <gtest/gtest.h>

#include <new>

#include "common/mcap/background_writer.h"
#include "tests/unit/failing_memory.h"
#include "tests/unit/mcap/small_log.h"

namespace hrp::mcap {
namespace {

using test::FailingMemory;

struct Case {
  Compression compression;
  FailingMemory::Kind kind;
};

class McapMemoryTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    if (!test::can_memory_fail()) GTEST_SKIP() << "the sanitizer's own malloc is in use";
  }
};

// As write_small_log() does, on a thread of its own. Returns the chunks that were said to be written.
uint64_t write_in_background(const std::string& path, Compression compression, bool* refused) {
  uint64_t chunks = 0;
  try {
    auto plain = std::make_unique<Writer>(path, compression);
    const uint16_t schema = plain->add_schema("pkg::Thing", "omgidl", "module pkg { struct Thing { long x; }; };");
    plain->add_channel("a", schema, "cdr");
    plain->add_channel("b", schema, "cdr");
    BackgroundWriter writer(std::move(plain));
    for (int step = 0; step < kSmallLogSteps; ++step) {
      for (uint16_t channel = 0; channel < 2; ++channel) {
        const std::string payload = make_payload(step, channel);
        const uint64_t time = 1000000ull * static_cast<uint64_t>(step);
        writer.add_message({channel, static_cast<uint32_t>(step), time, time,
                            reinterpret_cast<const uint8_t*>(payload.data()), payload.size()});
      }
      if (step % kSmallLogStepsPerChunk == kSmallLogStepsPerChunk - 1) {
        writer.write_chunk();
        writer.wait();
        chunks = writer.chunks_written();
      }
    }
    writer.close();
  } catch (const McapError&) {
    *refused = true;
  } catch (const std::bad_alloc&) {
    *refused = true;
  }
  return chunks;
}

TEST_P(McapMemoryTest, WhatWasSaidToBeWrittenIsReadWhereverMemoryRunsOut) {
  const std::vector<std::string> all = make_all_payloads();
  long n = 0;
  for (bool failed = true; failed; ++n) {
    TemporaryFile file("memory.mcap");
    const std::string path = file.path();
    bool refused = false;
    FailingMemory memory(n, GetParam().kind);
    const uint64_t chunks = write_in_background(path, GetParam().compression, &refused);
    failed = memory.stop();
    if (!std::filesystem::exists(path)) {  // nothing was written: the name is given back
      ASSERT_TRUE(refused) << "allocation " << n;
      continue;
    }
    Reader reader(path);
    const std::vector<std::string> payloads = read_payloads(&reader);
    ASSERT_GE(payloads.size(), 2 * kSmallLogStepsPerChunk * chunks) << "allocation " << n;
    ASSERT_LE(payloads.size(), all.size()) << "allocation " << n << ": a message stands there twice";
    ASSERT_TRUE(std::equal(payloads.begin(), payloads.end(), all.begin())) << "allocation " << n;
    if (refused) continue;
    ASSERT_EQ(payloads.size(), all.size()) << "allocation " << n << " failed and nobody was told";
    ASSERT_EQ(reader.damage(), "") << "allocation " << n;
  }
  RecordProperty("allocations", static_cast<int>(n));
  EXPECT_GT(n, 50) << "hardly an allocation was made to fail";
}

TEST_P(McapMemoryTest, AReaderWithoutMemorySaysSoAndNeverReadsSomethingElse) {
  TemporaryFile file("memory_read.mcap");
  const std::string path = file.path();
  write_small_log(path, GetParam().compression);
  const std::vector<std::string> all = make_all_payloads();
  long n = 0;
  for (bool failed = true; failed; ++n) {
    std::vector<std::string> payloads;
    bool refused = false;
    FailingMemory memory(n, GetParam().kind);
    try {
      Reader reader(path);
      payloads = read_payloads(&reader);
    } catch (const std::bad_alloc&) {
      refused = true;
    }
    failed = memory.stop();
    // A whole file is not called a damaged one for want of memory.
    if (!refused) {
      ASSERT_EQ(payloads, all) << "allocation " << n;
    }
  }
  RecordProperty("allocations", static_cast<int>(n));
  EXPECT_GT(n, 20);
}

INSTANTIATE_TEST_SUITE_P(Kinds, McapMemoryTest,
                         testing::Values(Case{Compression::kNone, FailingMemory::Kind::kOnce},
                                         Case{Compression::kZstd, FailingMemory::Kind::kOnce},
                                         Case{Compression::kLz4, FailingMemory::Kind::kOnce},
                                         Case{Compression::kNone, FailingMemory::Kind::kFromThenOn},
                                         Case{Compression::kZstd, FailingMemory::Kind::kFromThenOn},
                                         Case{Compression::kLz4, FailingMemory::Kind::kFromThenOn}));

}  // namespace
}  // namespace hrp::mcap

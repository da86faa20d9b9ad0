// SPDX-License-Identifier: BSD-3-Clause
// Logs after a kill at any byte, on a full disk, and with any byte changed.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <random>

#include "tests/unit/mcap/small_log.h"

namespace hrp::mcap {
namespace {

// Where each chunk of a file ends, found by walking over its records.
std::vector<size_t> find_chunk_ends(const std::string& bytes) {
  std::vector<size_t> ends;
  size_t offset = kMagic.size();
  while (offset + kRecordHead <= bytes.size()) {
    uint64_t length = 0;
    std::memcpy(&length, bytes.data() + offset + 1, sizeof length);
    const auto opcode = static_cast<Opcode>(bytes[offset]);
    offset += kRecordHead + length;
    if (opcode == Opcode::kChunk) ends.push_back(offset);
    if (opcode == Opcode::kFooter) break;
  }
  return ends;
}

class McapDamageTest : public testing::TestWithParam<Compression> {};

TEST_P(McapDamageTest, EveryWholeChunkIsReadWhateverByteTheFileEndsAt) {
  TemporaryFile file("whole.mcap"), cut("cut.mcap");
  write_small_log(file.path(), GetParam());
  const std::string bytes = read_file(file.path());
  const std::vector<size_t> ends = find_chunk_ends(bytes);
  ASSERT_EQ(ends.size(), static_cast<size_t>(kSmallLogSteps / kSmallLogStepsPerChunk));
  const std::vector<std::string> all = make_all_payloads();
  for (size_t size = kMagic.size(); size < bytes.size(); ++size) {
    write_file(cut.path(), bytes.substr(0, size));
    Reader reader(cut.path());
    const std::vector<std::string> payloads = read_payloads(&reader);
    size_t whole = 0;
    for (const size_t end : ends) whole += end <= size ? 2 * kSmallLogStepsPerChunk : 0;
    ASSERT_GE(payloads.size(), whole) << "cut at byte " << size;
    ASSERT_LE(payloads.size(), all.size());
    ASSERT_TRUE(std::equal(payloads.begin(), payloads.end(), all.begin())) << "cut at byte " << size;
    ASSERT_NE(reader.damage(), "") << "cut at byte " << size;
  }
}

TEST_P(McapDamageTest, AnyChangedBytesAreNoticedOrHarmless) {
  TemporaryFile file("original.mcap"), changed("changed.mcap");
  write_small_log(file.path(), GetParam());
  const std::string original = read_file(file.path());
  const std::vector<std::string> all = make_all_payloads();
  std::mt19937 random(20260);
  for (int trial = 0; trial < 3000; ++trial) {
    std::string bytes = original;
    const int changes = 1 + static_cast<int>(random() % 3);
    for (int i = 0; i < changes; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    write_file(changed.path(), bytes);
    try {
      Reader reader(changed.path());
      const std::vector<std::string> payloads = read_payloads(&reader);
      // Every payload lies under a checksum: fewer may come back, wrong ones may not.
      ASSERT_LE(payloads.size(), all.size()) << "trial " << trial;
      ASSERT_TRUE(std::equal(payloads.begin(), payloads.end(), all.begin()))
          << "trial " << trial << ": " << payloads.size() << " messages, " << reader.damage();
    } catch (const McapError&) {
      // The magic at the beginning was hit.
    }
  }
}

TEST_P(McapDamageTest, ARefusingDiskIsSaidAndTheFileStaysReadable) {
  TemporaryFile file("full.mcap");
  // A limit on the size of files stands in for a full disk: write() fails in the middle of a chunk.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{4096, old.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  uint64_t written = 0, on_disk = 0;
  std::string error;
  {
    Writer writer(file.path(), GetParam());
    const uint16_t schema = writer.add_schema("pkg::Thing", "omgidl", "module pkg { struct Thing { long x; }; };");
    writer.add_channel("a", schema, "cdr");
    std::mt19937 random(7);
    try {
      for (; written < 1000; ++written) {
        std::array<uint8_t, 100> noise;
        for (uint8_t& byte : noise) byte = static_cast<uint8_t>(random());
        writer.add_message({0, static_cast<uint32_t>(written), written, written, noise.data(), noise.size()});
        if (written % 4 == 3) {
          writer.write_chunk();
          on_disk = written + 1;
        }
      }
    } catch (const McapError& full) {
      error = full.what();
    }
    EXPECT_TRUE(writer.failed());
  }
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  EXPECT_NE(error.find("File too large"), std::string::npos) << error;
  Reader reader(file.path());
  EXPECT_EQ(read_payloads(&reader).size(), on_disk);
  EXPECT_GT(on_disk, 0u);
}

INSTANTIATE_TEST_SUITE_P(Compressions, McapDamageTest,
                         testing::Values(Compression::kNone, Compression::kLz4, Compression::kZstd),
                         [](const auto& info) {
                           const std::string word = get_compression_word(info.param);
                           return word.empty() ? std::string("none") : word;
                         });

TEST(McapDamage, AFullDeviceIsSaid) {
  if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "this system has no /dev/full";
  Writer writer("/dev/full", Compression::kNone);
  try {
    writer.write_chunk();
    FAIL() << "a full device took the header";
  } catch (const McapError& error) {
    EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace hrp::mcap

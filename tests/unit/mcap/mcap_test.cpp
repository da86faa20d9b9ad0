// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/mcap/small_log.h"

namespace hrp::mcap {
namespace {

class McapTest : public testing::TestWithParam<Compression> {};

TEST_P(McapTest, ReadsBackWhatWasWritten) {
  TemporaryFile file("roundtrip.mcap");
  write_small_log(file.path(), GetParam());
  Reader reader(file.path());
  EXPECT_TRUE(reader.indexed());
  EXPECT_EQ(reader.schemas().at(1).text, "module pkg { struct Thing { long x; }; };");
  EXPECT_EQ(reader.channels().at(1).topic, "b");
  EXPECT_EQ(read_payloads(&reader), make_all_payloads());
  EXPECT_EQ(reader.damage(), "");
}

TEST_P(McapTest, EqualCallsGiveEqualBytes) {
  TemporaryFile one("one.mcap"), two("two.mcap");
  write_small_log(one.path(), GetParam());
  write_small_log(two.path(), GetParam());
  EXPECT_EQ(read_file(one.path()), read_file(two.path()));
}

TEST_P(McapTest, ReadsOneTopic) {
  TemporaryFile file("topic.mcap");
  write_small_log(file.path(), GetParam());
  Reader reader(file.path());
  const std::vector<std::string> payloads = read_payloads(&reader, {"b"});
  ASSERT_EQ(payloads.size(), static_cast<size_t>(kSmallLogSteps));
  EXPECT_EQ(payloads[3], make_payload(3, 1));
  EXPECT_TRUE(read_payloads(&reader, {"no such topic"}).empty());
}

TEST_P(McapTest, ScanFindsWhatTheIndexFinds) {
  TemporaryFile file("scan.mcap");
  write_small_log(file.path(), GetParam());
  std::string bytes = read_file(file.path());
  bytes.back() ^= 1;  // breaks the closing magic, and nothing else
  write_file(file.path(), bytes);
  Reader reader(file.path());
  EXPECT_FALSE(reader.indexed());
  EXPECT_EQ(read_payloads(&reader), make_all_payloads());
  EXPECT_NE(reader.damage(), "");
}

INSTANTIATE_TEST_SUITE_P(Compressions, McapTest,
                         testing::Values(Compression::kNone, Compression::kLz4, Compression::kZstd),
                         [](const auto& info) {
                           const std::string word = get_compression_word(info.param);
                           return word.empty() ? std::string("none") : word;
                         });

// As recorders of ROS 2 leave a bag when they are killed.
TEST(McapScan, FindsTopicsThatOnlyChunksDefine) {
  Buffer records;
  put_schema({1, "pkg::Thing", "omgidl", "module pkg { struct Thing { long x; }; };"}, &records);
  put_channel({1, 1, "a", "cdr", {}}, &records);
  const size_t message = records.begin_record(Opcode::kMessage);
  for (size_t i = 0; i < 2 + 4 + 8 + 8; ++i) records.put(static_cast<uint8_t>(i == 0));  // channel 1, at time zero
  records.put_bytes(reinterpret_cast<const uint8_t*>("payload"), 7);
  records.end_record(message);
  Buffer bytes;
  put_beginning(&bytes);
  const size_t chunk = bytes.begin_record(Opcode::kChunk);
  for (const uint64_t number : {uint64_t{0}, uint64_t{0}, uint64_t{records.size()}}) bytes.put(number);  // times, size
  bytes.put(uint32_t{0});                                                                                // no checksum
  bytes.put_string("");  // not compressed
  bytes.put(uint64_t{records.size()});
  bytes.put_bytes(records.data(), records.size());
  bytes.end_record(chunk);
  TemporaryFile file("killed.mcap");
  write_file(file.path(), std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  Reader reader(file.path());
  ASSERT_NE(reader.find_channel("a"), nullptr);
  EXPECT_EQ(reader.schemas().at(1).name, "pkg::Thing");
  EXPECT_EQ(read_payloads(&reader), std::vector<std::string>{"payload"});
}

TEST(Crc, AgreesWithThePublishedCheckValue) {
  // "123456789" is the check string of the CRC catalogue; CRC-32/ISO-HDLC gives CBF43926.
  const auto* digits = reinterpret_cast<const uint8_t*>("123456789");
  EXPECT_EQ(update_crc(0, digits, 9), 0xCBF43926u);
  EXPECT_EQ(update_crc(update_crc(0, digits, 4), digits + 4, 5), 0xCBF43926u);
}

TEST(McapErrors, NameTheFile) {
  EXPECT_THROW(Reader("no/such/file.mcap"), McapError);
  EXPECT_THROW(Writer("no/such/folder/file.mcap", Compression::kNone), McapError);
  TemporaryFile file("text.mcap");
  write_file(file.path(), "this is a text file, and no log");
  try {
    Reader reader(file.path());
    FAIL() << "a text file was accepted";
  } catch (const McapError& error) {
    EXPECT_NE(std::string(error.what()).find(file.path() + ": offset 0"), std::string::npos) << error.what();
  }
}

TEST(McapErrors, UnknownCompressionIsRefused) { EXPECT_THROW(parse_compression("gzip"), McapError); }

}  // namespace
}  // namespace hrp::mcap

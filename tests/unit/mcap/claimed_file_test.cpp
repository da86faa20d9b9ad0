// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/mcap/claimed_file.h"
#include "tests/catch_complaint.h"
#include "tests/unit/mcap/small_log.h"

namespace hrp::mcap {
namespace {

using ::testing::HasSubstr;

std::string find_refusal(const std::string& path, Existing existing) {
  return catch_complaint<McapError>([&] { ClaimedFile file(path, existing); });
}

TEST(ClaimedFile, WhatHoldsSomethingIsRefusedUnlessToBeReplaced) {
  const TemporaryFile file("kept");
  write_file(file.path(), "a log of yesterday");
  EXPECT_THAT(find_refusal(file.path(), Existing::kRefuse), HasSubstr("is there already (18 bytes)"));
  EXPECT_EQ(find_refusal(file.path(), Existing::kReplace), "");
  EXPECT_EQ(read_file(file.path()), "a log of yesterday") << "replaced by the first byte written, not before";
}

TEST(ClaimedFile, IsTakenByNobodyElseWhileItIsWritten) {
  const TemporaryFile file("locked");
  {
    const ClaimedFile mine(file.path(), Existing::kRefuse);
    for (Existing existing : {Existing::kRefuse, Existing::kReplace}) {
      EXPECT_THAT(find_refusal(file.path(), existing), HasSubstr("is being written by another program"));
    }
  }
  EXPECT_EQ(find_refusal(file.path(), Existing::kRefuse), "") << "free again";
}

TEST(ClaimedFile, LeavesNoEmptyFileBehind) {
  const TemporaryFile file("empty");
  { const ClaimedFile mine(file.path(), Existing::kRefuse); }
  EXPECT_FALSE(std::filesystem::exists(file.path()));
}

TEST(ClaimedFile, CanBeOpenedAsALogFromTheStart) {
  const TemporaryFile file("begun");
  const ClaimedFile mine(file.path(), Existing::kReplace);
  EXPECT_GT(read_file(file.path()).size(), 0u);
  EXPECT_FALSE(holds_something(file.path()));
  EXPECT_TRUE(Reader(file.path()).channels().empty());
}

TEST(ClaimedFile, ANameThatIsReservedIsFreeForOneWriterAlone) {
  const TemporaryFile file("reserved");
  EXPECT_TRUE(reserve_file(file.path()));
  EXPECT_FALSE(reserve_file(file.path()));
  EXPECT_FALSE(holds_something(file.path()));
  write_small_log(file.path(), Compression::kNone);  // refuses a file that holds something
  EXPECT_TRUE(holds_something(file.path()));
  EXPECT_TRUE(Reader(file.path()).indexed());
}

TEST(ClaimedFile, AFileOfTheSameLengthIsNoReservation) {
  const TemporaryFile file("same_length");
  ASSERT_TRUE(reserve_file(file.path()));
  write_file(file.path(), std::string(read_file(file.path()).size(), 'x'));
  EXPECT_THAT(find_refusal(file.path(), Existing::kRefuse), HasSubstr("is there already"));
}

TEST(ClaimedFile, DevicesAreNotRemoved) {
  { const ClaimedFile null("/dev/null", Existing::kRefuse); }
  EXPECT_TRUE(std::filesystem::exists("/dev/null"));
}

TEST(Writer, KeepsTheLogThatItReplacesUntilItWrites) {
  const TemporaryFile file("replaced");
  write_small_log(file.path(), Compression::kNone);
  const std::string before = read_file(file.path());
  EXPECT_THROW(Writer(file.path(), Compression::kNone), McapError);
  EXPECT_EQ(read_file(file.path()), before);
}

}  // namespace
}  // namespace hrp::mcap

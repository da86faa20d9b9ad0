// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ios>
#include <sstream>

#include "common/base/diagnostics.h"
#include "common/base/read_file.h"
#include "tests/catch_complaint.h"

namespace hrp::test {
namespace {

// A file on a disk that reports an error after its text, as the standard library's files do.
class BadDisk : public std::stringbuf {
 public:
  explicit BadDisk(const std::string& text) : std::stringbuf(text) {}

 protected:
  int_type underflow() override {
    const int_type next = std::stringbuf::underflow();
    if (next == traits_type::eof()) throw std::ios_base::failure("error reading the file");
    return next;
  }
};

const char kComplaint[] = "walk.csv: error: cannot be read to its end: the disk reports an error";

TEST(ReadFile, IsReadWholeWhateverItsSize) {
  for (const size_t size : {0u, 1u, 65535u, 65536u, 65537u, 200000u}) {
    std::istringstream file(std::string(size, 'x') + std::string(1, '\0'));
    EXPECT_EQ(read_rest(file, "walk.csv").size(), size + 1);
  }
}

TEST(ReadFile, AnErrorOfTheDiskIsNoEndOfTheFile) {
  BadDisk disk("time,knee\n0,1\n");
  std::istream file(&disk);
  EXPECT_EQ(catch_complaint([&] { (void)read_rest(file, "walk.csv"); }), kComplaint);
}

TEST(ReadFile, AnErrorOfTheDiskIsNoLastLine) {
  for (const char* text : {"time,knee\n0,1\n", "time,knee\n0,1"}) {
    BadDisk disk(text);
    std::istream file(&disk);
    for (std::string line; std::getline(file, line);) continue;
    EXPECT_EQ(catch_complaint([&] { check_end(file, "walk.csv"); }), kComplaint);
  }
  std::istringstream good("time,knee\n0,1");
  for (std::string line; std::getline(good, line);) continue;
  EXPECT_EQ(catch_complaint([&] { check_end(good, "walk.csv"); }), "");
}

}  // namespace
}  // namespace hrp::test

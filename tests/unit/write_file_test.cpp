// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/base/diagnostics.h"
#include "common/base/write_file.h"
#include "tests/catch_complaint.h"

namespace hrp::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class WriteFile : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  size_t count_files() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

 private:
  fs::path folder_ = fs::temp_directory_path() / ("hrp_write_file_" + std::to_string(getpid()));
};

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// A disk on which no file may be larger than 1000 bytes: writes fail there as on a full one.
class SmallDisk {
 public:
  SmallDisk() {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit small = before_;
    small.rlim_cur = 1000;
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(WriteFile, ReplacesWhatWasThere) {
  write_file(path("report.json"), std::string(100, 'a'));
  write_file(path("report.json"), "b");
  EXPECT_EQ(read(path("report.json")), "b");
  EXPECT_EQ(count_files(), 1u);
}

TEST_F(WriteFile, OnAFullDiskKeepsTheFileThatWasThereAndSaysTheReason) {
  write_file(path("report.json"), "before");
  std::string complaint;
  {
    const SmallDisk disk;
    complaint = catch_complaint<std::exception>([&] { write_file(path("report.json"), std::string(100000, 'x')); });
  }
  EXPECT_EQ(complaint, path("report.json") + ": cannot be written: File too large");
  EXPECT_EQ(read(path("report.json")), "before");
  EXPECT_EQ(count_files(), 1u);
}

TEST_F(WriteFile, NamesAFolderThatIsNotThere) {
  EXPECT_THAT(catch_complaint<std::exception>([&] { write_file(path("none/report.json"), "x"); }),
              HasSubstr("No such file or directory"));
}

TEST_F(WriteFile, AFolderForResultsIsMadeAndLeftEmpty) {
  prepare_folder(path("a/b"));
  EXPECT_TRUE(fs::is_empty(path("a/b")));
}

TEST_F(WriteFile, AFolderOnAFullDiskIsBadInput) {
  std::string complaint;
  {
    const SmallDisk disk;
    prepare_folder(path("results"), 900);
    complaint = catch_complaint<std::exception>([&] { prepare_folder(path("results"), 2000); });
  }
  EXPECT_THAT(complaint, HasSubstr("results: error: nothing can be written in it: "));
  EXPECT_THAT(complaint, HasSubstr("File too large"));
  EXPECT_TRUE(fs::is_empty(path("results")));
}

TEST_F(WriteFile, AFolderThatIsAFileOrCannotBeMadeIsBadInput) {
  write_file(path("file"), "x");
  EXPECT_THAT(catch_complaint<std::exception>([&] { prepare_folder(path("file")); }),
              HasSubstr("file: error: cannot be made: Not a directory"));
  EXPECT_THROW(prepare_folder("/proc/none"), InputError);
  EXPECT_THROW(prepare_folder(path(std::string(300, 'y'))), InputError);
  // A folder in which even root can make no file.
  EXPECT_THAT(catch_complaint<std::exception>([] { prepare_folder("/proc/self"); }),
              HasSubstr("/proc/self: error: nothing can be written in it"));
}

}  // namespace
}  // namespace hrp::test

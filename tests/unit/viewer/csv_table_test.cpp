// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/csv_table.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/catch_complaint.h"

namespace hrp {
namespace {

std::string write(const std::string& name, const std::string& text) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / ("hrp_csv_table_" + name);
  std::ofstream(path) << text;
  return path.string();
}

// As spreadsheets write it.
TEST(CsvTable, AByteOrderMarkBelongsToNoColumnsName) {
  const CsvTable table = read_csv_table(write("marked.csv", "\xEF\xBB\xBFtime,force\n0,1\n0.1,2\n"));
  ASSERT_NE(table.find("time"), nullptr);
  EXPECT_EQ(*table.find("force"), (std::vector<double>{1.0, 2.0}));
}

TEST(CsvTable, ARowWithAnotherNumberOfCellsIsLeftOutAndSaid) {
  const CsvTable table = read_csv_table(write("short.csv", "time,force\n0,1\n0.1\n0.2,3\n"));
  EXPECT_EQ(*table.find("time"), (std::vector<double>{0.0, 0.2}));
  ASSERT_EQ(table.notes.size(), 1u);
  EXPECT_NE(table.notes[0].find("line 3 has 1 cells, not 2"), std::string::npos) << table.notes[0];
}

TEST(CsvTable, ACellThatIsNoNumberIsRefusedByLineAndColumn) {
  const std::string complaint = catch_complaint([] { read_csv_table(write("word.csv", "time,force\n0,big\n")); });
  EXPECT_NE(complaint.find("'big' is no number"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("word.csv"), std::string::npos) << complaint;
}

}  // namespace
}  // namespace hrp

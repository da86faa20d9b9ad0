// SPDX-License-Identifier: BSD-3-Clause
// Text recordings as other people write them: docs/text_recordings.md.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/recording.h"
#include "tests/catch_complaint.h"

namespace hrp::diagnosis {
namespace {

using testing::HasSubstr;

std::string write_file(const std::string& name, const std::string& text) {
  std::string path = (std::filesystem::temp_directory_path() / ("hrp_text_" + name)).string();
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

// Of the one recording of an experiment.
ColumnMap parse(const std::string& columns) {
  return parse_column_maps("recordings: [{file: a.csv}]\ncolumns: " + columns, "experiment.yaml").at(0);
}

// A table of two columns, "time" and the angle of a hip.
Table read(const std::string& name, const std::string& text, const std::string& columns) {
  std::vector<std::string> warnings;
  return read_csv_averaged(write_file(name, text), 1, &warnings, parse(columns));
}

void expect_hip(const Table& table, const std::vector<double>& time, const std::vector<double>& angle) {
  ASSERT_EQ(table.names, (std::vector<std::string>{"time", "/joint_states/hip/position"}));
  ASSERT_EQ(table.rows(), time.size());
  for (size_t k = 0; k < time.size(); ++k) {
    EXPECT_NEAR(table.columns[0][k], time[k], 1e-12) << k;  // one product of two doubles
    EXPECT_NEAR(table.columns[1][k], angle[k], 1e-12) << k;
  }
}

constexpr const char* kNumbered =
    "{time: {column: 1, scale: 0.001}, /joint_states/hip/position: {column: 3, scale: 0.5, offset: 1}}";

TEST(TextRecording, ColumnsByNumberNeedNoHeader) {
  expect_hip(read("numbers.csv", "10,7,2\n20,7,4\n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("counted.csv", "ms,n,q\n10,7,2\n20,7,4\n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
}

TEST(TextRecording, SemicolonsTabsAndSpacesSeparateCellsAndCommasDecimals) {
  expect_hip(read("semicolons.csv", "10,0;7,5;2,0\n20;;4\n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("tabs.txt", "% a note\n1,0e1\t7\t2\t\r\n20\t7\t4\t\r\n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("pasted.txt", "10 7\t2\n20 7\t4\n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("spaces.txt", "# a note\n  1.0e1   7 2\n  20 7   4 \n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
}

TEST(TextRecording, NumbersMayStandInQuotesAndMissingOnesHaveManyNames) {
  const Table table = read("quoted.csv", "\"t\",\"q\"\n\"0.01\",\"2\"\n\"0.02\",\"NA\"\n0.03,null\n",
                           "{time: t, /joint_states/hip/position: q}");
  ASSERT_EQ(table.rows(), 3u);
  EXPECT_DOUBLE_EQ(table.columns[0][1], 0.02);
  EXPECT_DOUBLE_EQ(table.columns[1][0], 2.0);
  EXPECT_TRUE(std::isnan(table.columns[1][1]));
  EXPECT_TRUE(std::isnan(table.columns[1][2]));
}

TEST(TextRecording, PlotJugglersNameOfTheTimeIsKnown) {
  std::vector<std::string> warnings;
  const Table table = read_csv_averaged(
      write_file("plotjuggler.csv", "__time,/joint_states/hip/position\n0.5,1\n0.6,2\n"), 1, &warnings);
  EXPECT_EQ(table.find("time"), 0);
}

TEST(TextRecording, MeansOfALongLogStopWhereAnAngleIsWrapped) {
  std::string text = "time,/joint_states/hip/position\n";
  for (int k = 0; k < 40; ++k)
    text += std::to_string(0.01 * k) + "," + std::to_string(std::remainder(3.0 + 0.05 * k, 2.0 * M_PI)) + "\n";
  std::vector<std::string> warnings;
  const Table table = read_csv_averaged(write_file("wrapped.csv", text), 4, &warnings);
  for (double q : table.columns[1]) EXPECT_GT(std::abs(q), 1.0) << "no mean of pi and -pi";
}

TEST(TextRecording, CommentsBeforeNumbersNameTheColumnsAsNumPyAndMatlabWriteThem) {
  constexpr const char* kNamed =
      "{time: {column: ms, scale: 0.001}, /joint_states/hip/position: {column: q, scale: 0.5, offset: 1}}";
  expect_hip(read("numpy.txt", "# a note, of today\n# ms n q\n10 7 2\n20 7 4\n", kNamed), {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("commas.txt", "#ms, n, q\n10 7 2\n20 7 4\n", kNamed), {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("matlab.txt", "%ms\tn\tq\n10\t7\t2\t0\n20\t7\t4\t0\n", kNamed), {0.01, 0.02}, {2.0, 3.0});
  // A sentence of as many words is no worse than none: columns go by their numbers, too.
  expect_hip(read("sentence.txt", "# three words here\n10 7 2\n20 7 4\n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
}

TEST(TextRecording, AByteOrderMarkBelongsToNoCellNameOrComment) {
  constexpr const char* kNamed =
      "{time: {column: ms, scale: 0.001}, /joint_states/hip/position: {column: q, scale: 0.5, offset: 1}}";
  expect_hip(read("marked_numbers.csv",
                  "\xEF\xBB\xBF"
                  "10,7,2\n20,7,4\n",
                  kNumbered),
             {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("marked_header.csv", "\xEF\xBB\xBFms,n,q\n10,7,2\n20,7,4\n", kNamed), {0.01, 0.02}, {2.0, 3.0});
  expect_hip(read("marked_comment.csv", "\xEF\xBB\xBF# a note\nms,n,q\n10,7,2\n20,7,4\n", kNamed), {0.01, 0.02},
             {2.0, 3.0});
}

TEST(TextRecording, OneLineWithSpacesInPlaceOfTabsIsRead) {
  expect_hip(read("mended.txt", "10\t7\t2\n20 7  4\n", kNumbered), {0.01, 0.02}, {2.0, 3.0});
}

TEST(TextRecording, OtherKindsOfFilesAreCalledByTheirNames) {
  for (const auto& [content, name] : std::vector<std::pair<std::string, std::string>>{{"\x93NUMPY", "NumPy"},
                                                                                      {"PK\x03\x04 and more", "npz"},
                                                                                      {"\x89HDF\r\n\x1a\n", "HDF5"},
                                                                                      {"MATLAB 5.0 MAT-file", "MATLAB"},
                                                                                      {"#ROSBAG V2.0\n", "ROS 1"},
                                                                                      {"SQLite format 3", "db3"},
                                                                                      {"\x89MCAP0", "mcap"},
                                                                                      {"\x1f\x8b\x08", "gunzip"},
                                                                                      {"BZh9", "bunzip2"},
                                                                                      {"\xfd"
                                                                                       "7zXZ",
                                                                                       "unxz"},
                                                                                      {"PAR1", "Parquet"}}) {
    EXPECT_THAT(catch_complaint([&, text = content] { read("other.txt", text, kNumbered); }), HasSubstr(name));
  }
}

TEST(TextRecording, ColumnsByNameLeaveOthersAlone) {
  const std::string text = "t;mode;q;q\n0;walk;1;9\n0.5;run;2;9\n";
  expect_hip(read("names.csv", text, "{time: t, /joint_states/hip/position: 3}"), {0.0, 0.5}, {1.0, 2.0});
  EXPECT_THAT(catch_complaint([&] { read("twice.csv", text, "{time: t, /joint_states/hip/position: q}"); }),
              HasSubstr("stands twice"));
}

TEST(TextRecording, StampsMayBeDates) {
  const std::string columns = "{time: at, /joint_states/hip/position: q}";
  const Table table = read("dates.csv", "at,q\n2026-02-28T23:59:59.5Z,1\n2026-03-01 00:00:00.25,2\n", columns);
  EXPECT_NEAR(table.columns[0][1] - table.columns[0][0], 0.75, 1e-6);  // seconds since 1970 have 2e-7 of resolution
  const Table clock = read("clock.csv", "at,q\n09:59:59.5,1\n10:00:00.25,2\n", columns);
  EXPECT_NEAR(clock.columns[0][1] - clock.columns[0][0], 0.75, 1e-9);
}

TEST(TextRecording, AStarStandsForEachJoint) {
  const std::vector<SignalColumn> map = parse(
                                            "{joints: [hip, knee], /joint_states/*/position: q_*, "
                                            "/joint_states/*/effort: {column: [4, 5], scale: [1, -1]}}")
                                            .columns;
  ASSERT_EQ(map.size(), 4u);
  EXPECT_EQ(map[1].signal, "/joint_states/knee/position");
  EXPECT_EQ(map[1].name, "q_knee");
  EXPECT_EQ(map[3].signal, "/joint_states/knee/effort");
  EXPECT_EQ(map[3].number, 5);
  EXPECT_EQ(map[3].scale, -1.0);
}

TEST(TextRecording, ARecordingMayHaveColumnsOfItsOwn) {
  const std::vector<ColumnMap> maps = parse_column_maps(
      "recordings: [{file: a.csv}, {file: b.csv, columns: {/joint_commands/hip/position: {column: 1, scale: 0, offset: "
      "2}}}]\n"
      "columns: {time: t, /joint_commands/hip/position: {column: 1, scale: 0, offset: 1}}",
      "e.yaml");
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].columns[1].offset, 1.0);
  ASSERT_EQ(maps[1].columns.size(), 2u);
  EXPECT_EQ(maps[1].columns[1].offset, 2.0);
}

TEST(TextRecording, ComplaintsSayWhereAColumnWasExpected) {
  const auto complain = [](const std::string& text, const std::string& columns) {
    return catch_complaint([&] { read("bad.csv", text, columns); });
  };
  EXPECT_THAT(complain("1,2\n3,4\n", "{time: 3}"), HasSubstr("at most 2"));
  EXPECT_THAT(complain("1,2\n3,4\n", "{time: t}"), HasSubstr("no header"));
  EXPECT_THAT(complain("times,q\n3,4\n", "{time: time}"), HasSubstr("did you mean 'times'"));
  EXPECT_THAT(complain("t,q\n3,x4\n", "{time: t, /joint_states/hip/position: q}"), HasSubstr("bad.csv:2:2:"));
  const Table mapped = read("mapped.csv", "q,x,t\n3,4,0\n3,4,1\n", "{time: t, /joint_states/hip/position: q}");
  EXPECT_EQ(mapped.number_of(mapped.find("time")), 3) << "of the file, not of the map";
  EXPECT_THAT(complain("", "{/joint_states/*/position: q}"), HasSubstr("'joints'"));
  EXPECT_THAT(complain("", "{joints: [a, b], /joint_states/*/position: [1]}"), HasSubstr("expected 2"));
  EXPECT_THAT(complain("", "{tme: 1}"), HasSubstr("did you mean 'time'"));
  EXPECT_THAT(complain("", "{time: 0}"), HasSubstr("from 1"));
  EXPECT_THAT(complain("", "{time: {colum: 1}}"), HasSubstr("unknown key"));
  EXPECT_THAT(complain("1,2\n3,4\n", "{}"), HasSubstr("'columns'"));  // a file without a header, and no word about it
}

TEST(TextRecording, WordsInAColumnThatIsNoSignalAreLeftOut) {
  std::vector<std::string> warnings;
  const Table table = read_csv(write_file("words.csv", "time,mode,q\n0,walk,1\n0.1,walk,2\n"), &warnings);
  EXPECT_TRUE(std::isnan(table.columns[1][0]));
  EXPECT_EQ(table.columns[2][1], 2.0);
  EXPECT_THAT(warnings, testing::ElementsAre(HasSubstr("mode")));
}

// A folder with an arm of one joint.
std::string make_arm_folder(const std::string& name) {
  const std::string folder = (std::filesystem::temp_directory_path() / name).string() + "/";
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "robot.urdf") << R"(<robot name="arm"><link name="base"/><link name="fore"><inertial>
    <origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    </link><joint name="elbow" type="revolute"><parent link="base"/><child link="fore"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";
  return folder;
}

// Two logs of one clock that were put together one after the other and sorted.
TEST(TextRecording, RowsOfOneStampFillEachOthersEmptyCells) {
  const std::string folder = make_arm_folder("hrp_text_joined");
  std::ofstream file(folder + "log.csv");
  file << "time,/joint_states/elbow/position,/joint_states/elbow/effort\n";
  for (int k = 0; k < 100; ++k)
    file << 0.01 * k << "," << std::sin(0.1 * k) << ",\n" << 0.01 * k << ",," << std::cos(0.1 * k) << "\n";
  file.close();
  std::ofstream(folder + "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings: [{file: log.csv}]\n";
  const Experiment e = load_experiment(folder + "experiment.yaml");
  ASSERT_EQ(e.recordings.size(), 1u);
  ASSERT_EQ(e.recordings[0].size(), 100u);
  EXPECT_NEAR(e.recordings[0].joints[0].signal[0][10], std::sin(1.0), 1e-5);  // six digits in the file
  EXPECT_NEAR(e.recordings[0].joints[0].signal[2][10], std::cos(1.0), 1e-5);
}

// The experiment says which columns are which, and the rate: the file is as it was.
TEST(TextRecording, AnExperimentReadsAFileWithoutHeaderAndStamps) {
  const std::string folder = make_arm_folder("hrp_text_arm");
  std::ofstream file(folder + "log.txt");
  for (int k = 0; k < 100; ++k) file << "  " << 57.29577951308232 * std::sin(0.1 * k) << "  " << 0.5 * k << "\n";
  file.close();
  std::ofstream(folder + "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\ndrive: effort\nsample_rate: 50\nrecordings: [{file: log.txt}]\n"
         "columns:\n  /joint_states/elbow/position: {column: 1, scale: 0.017453292519943295}\n"
         "  /joint_states/elbow/effort: 2\n";
  const Experiment e = load_experiment(folder + "experiment.yaml");
  ASSERT_EQ(e.recordings.size(), 1u);
  EXPECT_NEAR(e.recordings[0].time[10], 0.2, 1e-12);
  EXPECT_NEAR(e.recordings[0].joints[0].signal[0][10], std::sin(1.0), 1e-5);  // six digits in the file
  EXPECT_THAT(e.warnings, testing::Contains(HasSubstr("sample_rate")));
}

}  // namespace
}  // namespace hrp::diagnosis

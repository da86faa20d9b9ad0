// SPDX-License-Identifier: BSD-3-Clause
// Files of surfaces: what is read of them, and what is refused.
#include <unistd.h>

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/messages/convert_robot.h"
#include "common/messages/logged_description.h"
#include "common/robot/surface_file.h"
#include "tests/catch_complaint.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kTerrain = source_dir() + "/models/terrain/";

std::string write_file(const std::string& name, const std::string& text) {
  std::string path = ::testing::TempDir() + "/surface_" + std::to_string(getpid()) + "_" + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

ObstacleSpec make_field(const std::string& file, double low = 0.0, double high = 0.0) {
  ObstacleSpec obstacle;
  obstacle.name = "land";
  obstacle.shape = "height_field";
  obstacle.file = file;
  obstacle.spacing = 0.05;
  obstacle.low = low;
  obstacle.high = high;
  return obstacle;
}

ObstacleSpec make_mesh(const std::string& file, double scale = 1.0) {
  ObstacleSpec obstacle;
  obstacle.name = "land";
  obstacle.shape = "mesh";
  obstacle.file = file;
  obstacle.scale.setConstant(scale);
  return obstacle;
}

std::string find_complaint(const ObstacleSpec& obstacle) {
  return catch_complaint([&] { load_surface(obstacle); });
}

TEST(HeightText, LinesAreRowsAndCommentsAreLeftOut) {
  const HeightTable table = parse_height_text("# heights\n1, 2;3\n\n4 5\t-6.5e-1 # the last row\n", "a.csv");
  EXPECT_EQ(table.columns, 3);
  EXPECT_EQ(table.rows, 2);
  EXPECT_THAT(table.values, ElementsAre(1, 2, 3, 4, 5, -0.65));
}

TEST(HeightText, OddLinesAreNamed) {
  EXPECT_THAT(find_complaint(make_field(write_file("a.csv", "1,2\n3,4,5\n"))),
              HasSubstr("a.csv:2: error: has 3 heights, the lines above have 2"));
  EXPECT_THAT(find_complaint(make_field(write_file("b.csv", "1,2\n3,x\n"))),
              HasSubstr("b.csv:2: error: 'x' is no number"));
  EXPECT_THAT(find_complaint(make_field(write_file("c.csv", "1,2\n3,nan\n"))), HasSubstr("not finite"));
  EXPECT_THAT(find_complaint(make_field(write_file("d.csv", "1,2\n"))), HasSubstr("two rows"));
  EXPECT_THAT(find_complaint(make_field(write_file("e.csv", ""))), HasSubstr("two rows"));
}

TEST(Pgm, PlainAndBinaryOfOneAndTwoBytesAreRead) {
  EXPECT_THAT(parse_pgm("P2 # plain\n3 1\n255\n0 128 255\n", "a.pgm").values, ElementsAre(0, 128, 255));
  EXPECT_THAT(parse_pgm(std::string("P5\n2 1\n255\n\x01\xff", 13), "a.pgm").values, ElementsAre(1, 255));
  EXPECT_THAT(parse_pgm(std::string("P5\n2 1\n65535\n\x01\x02\xff\xff", 17), "a.pgm").values, ElementsAre(258, 65535));
}

TEST(Pgm, DamagedFilesAreRefused) {
  const auto complain = [](const std::string& text) {
    return find_complaint(make_field(write_file("d.pgm", text), 0, 1));
  };
  EXPECT_THAT(complain("P6\n2 2\n255\n"), HasSubstr("expected P2 or P5"));
  EXPECT_THAT(complain("P2\n2 2\n255"), HasSubstr("'' where a number should be"));
  EXPECT_THAT(complain("P5\n2 2\n255\nabc"), HasSubstr("ends within its pixels"));
  EXPECT_THAT(complain("P2\n2 2\n255\n1 2 3"), HasSubstr("where a number should be"));
  EXPECT_THAT(complain("P5\n99999 99999\n255\n"), HasSubstr("pixels, expected 250000 at most"));
  EXPECT_THAT(complain("P5\n2 2\n0\n"), HasSubstr("largest value 0"));
  EXPECT_THAT(complain(""), HasSubstr("begins with ''"));
}

TEST(Png, TheHillsHaveTheirHeights) {
  const auto surface = load_surface(make_field(kTerrain + "hills.png", -0.1, 0.3));
  EXPECT_EQ(surface->columns, 81);
  EXPECT_EQ(surface->rows, 81);
  // The top of the first hill: x = -0.8 m, y = 0.5 m; white, which is 0.3 m.
  EXPECT_NEAR(surface->heights[size_t(30 * 81 + 24)], 0.3, 1e-4);
  EXPECT_NEAR(surface->heights[0], -0.1, 1e-3) << "a corner is nearly black";
}

TEST(Png, DamagedFilesAreRefused) {
  std::ifstream file(kTerrain + "hills.png", std::ios::binary);
  const std::string good{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(find_complaint(make_field(write_file("cut.png", good.substr(0, good.size() / 2)), 0, 1)),
              HasSubstr("damaged"));
  EXPECT_THAT(find_complaint(make_field(write_file("none.png", "hello"), 0, 1)), HasSubstr("is no PNG"));
}

TEST(HeightField, ImagesNeedHeightsOfBlackAndWhite) {
  EXPECT_THAT(find_complaint(make_field(kTerrain + "hills.png")), HasSubstr("needs 'low' and 'high'"));
  EXPECT_THAT(find_complaint(make_field(kTerrain + "waves.csv", 0.0, 1.0)), HasSubstr("are for images"));
  EXPECT_THAT(find_complaint(make_field(kTerrain + "README.md")), HasSubstr(".csv, .txt, .png and .pgm"));
}

TEST(HeightField, TheFirstRowHasTheLargestYAndTrianglesFaceUp) {
  Surface surface;
  surface.columns = 3;
  surface.rows = 2;
  surface.spacing = 0.5;
  surface.heights = {1, 2, 3, 4, 5, 6};
  const Mesh mesh = make_triangles(surface);
  EXPECT_EQ(mesh.vertices[0], Vector3d(-0.5, 0.25, 1));
  EXPECT_EQ(mesh.vertices[5], Vector3d(0.5, -0.25, 6));
  ASSERT_EQ(mesh.triangles.size(), 4u);
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.vertices[size_t(t[0])], b = mesh.vertices[size_t(t[1])], c = mesh.vertices[size_t(t[2])];
    EXPECT_NEAR((b - a).cross(c - a).z(), 0.25, 1e-15);
  }
}

TEST(MeshFile, StairsAreReadScaledAndWelded) {
  const auto surface = load_surface(make_mesh(kTerrain + "stairs.obj", 2.0));
  EXPECT_EQ(surface->mesh.triangles.size(), 28u);
  EXPECT_EQ(surface->mesh.vertices.size(), 16u);
  EXPECT_NEAR(surface->mesh.vertices[14].x(), 1.8, 1e-6) << "single precision in the reader";
}

TEST(MeshFile, ABodyThatFacesInwardIsRefused) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  EXPECT_EQ(find_complaint(make_mesh(write_file("out.obj", corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"))), "");
  EXPECT_THAT(find_complaint(make_mesh(write_file("in.obj", corners + "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"))),
              HasSubstr("faces inward"));
}

TEST(SurfaceMessage, ComesBackAsItWas) {
  for (const ObstacleSpec& obstacle : {make_mesh(kTerrain + "stairs.obj"), make_field(kTerrain + "waves.csv")}) {
    RobotDescription robot, back;
    robot.tree.links.resize(1);
    robot.surfaces.push_back(load_surface(obstacle));
    msg::RobotDescription message;
    to_message(robot, &message);
    from_message(message, &back);
    ASSERT_EQ(back.surfaces.size(), 1u);
    const Surface &a = *robot.surfaces[0], &b = *back.surfaces[0];
    EXPECT_EQ(a.obstacle, b.obstacle);
    EXPECT_EQ(a.heights, b.heights);
    EXPECT_EQ(a.spacing, b.spacing);
    EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
    EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  }
}

TEST(SurfaceMessage, OneThatCannotBeIsRefused) {
  msg::SurfaceDescription message;
  EXPECT_THROW(from_message(message), InputError);
  message.vertices().resize(3);
  message.triangles({0, 1, 3});
  EXPECT_THROW(from_message(message), InputError);
  message.triangles({0, 1, 2});
  EXPECT_NO_THROW(from_message(message));
  message.columns(1000000);
  message.rows(1000000);
  EXPECT_THROW(from_message(message), InputError);
}

TEST(LoggedDescription, OfBeforeThereWereSurfacesOrVisualsIsRead) {
  msg::RobotDescription message, back;
  message.name("robot");
  message.warnings({"a", "bcd"});
  std::vector<char> buffer;
  const Bytes whole = encode(message, &buffer);
  decode_logged({whole.data, whole.size - 8}, &back);  // without the numbers of surfaces and visuals
  EXPECT_EQ(back.name(), "robot");
  EXPECT_THAT(back.warnings(), ElementsAre("a", "bcd"));
  EXPECT_TRUE(back.surfaces().empty());
  message.surfaces().resize(2);
  message.surfaces()[1].obstacle("land");
  decode_logged(encode(message, &buffer), &back);
  ASSERT_EQ(back.surfaces().size(), 2u);
  const Bytes with_surfaces = encode(message, &buffer);
  decode_logged({with_surfaces.data, with_surfaces.size - 4}, &back);  // without the number of visuals
  ASSERT_EQ(back.surfaces().size(), 2u);
  EXPECT_TRUE(back.visuals().empty());
  EXPECT_EQ(back.surfaces()[1].obstacle(), "land");
  EXPECT_THROW(decode_logged({whole.data, 8}, &back), DecodeError);
}

}  // namespace
}  // namespace hrp

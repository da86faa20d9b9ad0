// SPDX-License-Identifier: BSD-3-Clause
// Nodes of COLLADA files that contain each other by reference. Without the check, Assimp 5.2 ends the program with a
// node that contains itself, and did not end within 12 s of processor time with 2^21 repetitions. And lists of whole
// numbers that have something else, and arrays that are too short.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/robot/mesh.h"
#include "tests/catch_complaint.h"

namespace hrp {
namespace {

constexpr const char* kTriangle =
    "<library_geometries><geometry id='g'><mesh><source id='p'><float_array id='pa' count='9'>0 0 0 1 0 0 0 1 0<"
    "/float_array>"
    "<technique_common><accessor source='#pa' count='3' stride='3'><param name='X' type='float'/><param name='Y' "
    "type='float'/>"
    "<param name='Z' type='float'/></accessor></technique_common></source><vertices id='v'><input semantic='POSITION' "
    "source='#p'/></vertices>"
    "<triangles count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p>"
    "</triangles></mesh></geometry></library_geometries>";
const std::string kShape = "<instance_geometry url='#g'/>";

size_t count_triangles_of(const std::string& text, const std::string& ending = ".dae") {
  const std::string path = ::testing::TempDir() + "/nodes_" + std::to_string(getpid()) + ending;
  std::ofstream(path) << text;
  const size_t count = load_mesh(path, Vector3d::Ones()).triangles.size();
  unlink(path.c_str());
  return count;
}

// A scene of these nodes, with a library of these.
std::string write_scene(const std::string& nodes, const std::string& library = "") {
  return std::string("<?xml version='1.0'?><COLLADA version='1.4.1'><asset/>") + kTriangle + "<library_nodes>" +
         library + "</library_nodes><library_visual_scenes><visual_scene id='s'>" + nodes +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>";
}

size_t count_triangles(const std::string& nodes, const std::string& library = "") {
  return count_triangles_of(write_scene(nodes, library));
}

void expect_complaint(const std::string& nodes, const std::string& part) {
  const std::string said = catch_complaint([&] { count_triangles(nodes); });
  EXPECT_NE(said.find(part), std::string::npos) << said;
}

std::string make_node(const std::string& id, const std::string& inside) {
  return "<node id='" + id + "'>" + inside + "</node>";
}
std::string make_copy(const std::string& of) { return "<instance_node url='#" + of + "'/>"; }

TEST(ColladaNodes, ThatAreSharedAreReadForEachReference) {
  EXPECT_EQ(count_triangles(make_node("a", kShape) + make_node("b", make_copy("a") + make_copy("a"))), 3u);
  // The name of a node may be the id of the one that it contains.
  EXPECT_EQ(
      count_triangles("<node id='w1' name = \"wheel\">" + make_copy("wheel") + "</node>", make_node("wheel", kShape)),
      1u);
}

TEST(ColladaNodes, ThatContainThemselvesAreRefused) {
  expect_complaint(make_node("a", kShape + make_copy("a")), "has a node that contains itself: 'a'");
  expect_complaint(make_node("a", kShape + make_copy("b")) + make_node("b", make_copy("a")), "contains itself");
  expect_complaint(make_node("a", make_node("b", kShape + make_copy("a"))), "contains itself");
}

TEST(ColladaNodes, ThatRepeatOthersWithoutEndAreRefused) {
  std::string nodes = make_node("n0", kShape);
  for (int k = 1; k < 40; ++k)
    nodes += make_node("n" + std::to_string(k),
                       make_copy("n" + std::to_string(k - 1)) + make_copy("n" + std::to_string(k - 1)));
  expect_complaint(nodes, "has more than 100000 nodes");
}

TEST(ColladaNodes, ThatAreTooDeepAreRefused) {
  std::string inside = kShape, chain = make_node("n0", kShape);
  for (int k = 0; k < 1000; ++k) inside = "<node>" + inside + "</node>";
  for (int k = 1; k < 1000; ++k) chain += make_node("n" + std::to_string(k), make_copy("n" + std::to_string(k - 1)));
  expect_complaint(inside, "more than 200 deep");
  expect_complaint(chain, "more than 200 deep");
}

// Without the check, each of these takes memory until none is left.
TEST(ColladaLists, WithSomethingElseThanWholeNumbersAreRefused) {
  const std::string shape = make_node("a", kShape), all = write_scene(shape);
  const auto expect_refusal = [&](const std::string& list, const std::string& part) {
    std::string text = all;
    text.replace(text.find("0 1 2</p>"), 5, list);
    const std::string said = catch_complaint([&] { count_triangles_of(text); });
    EXPECT_NE(said.find(part), std::string::npos) << list << ": " << said;
  };
  expect_refusal("0,1,2", "has ',1,2' in a list of whole numbers, <p>");
  expect_refusal("0 1 2.0", "has '.0' in");
  expect_refusal("0 1 # 2", "has '#' in");
  expect_refusal("<![CDATA[0 1 two]]>", "has 'two' in");
  expect_refusal("<?it's?>0 1 two", "has 'two' in");
}

TEST(ColladaLists, MayHaveCommentsAndBreaksOfLines) {
  std::string text = write_scene(make_node("a", kShape));
  text.replace(text.find("0 1 2</p>"), 5, "<!-- it's one --> 0\r\n1\t+2");
  EXPECT_EQ(count_triangles_of(text), 1u);
}

TEST(ColladaLists, AreCheckedUnderOtherEndings) {
  std::string text = write_scene(make_node("a", kShape));
  EXPECT_EQ(count_triangles_of(text, ".part"), 1u);
  EXPECT_NE(catch_complaint([&] { count_triangles_of(text, ".zae"); }).find("is packed"), std::string::npos);
  text.replace(text.find("0 1 2</p>"), 5, "0,1,2");
  EXPECT_NE(catch_complaint([&] { count_triangles_of(text, ".part"); }).find("has ',1,2'"), std::string::npos);
}

// What is not of a mesh is nobody's list.
TEST(ColladaLists, AreNoneOutsideMeshes) {
  EXPECT_EQ(count_triangles(make_node("a", kShape + "<extra><p>a word, or two</p></extra>")), 1u);
}

// Without the check, Assimp reads beyond the array: a null pointer where it is empty, else what lies there.
TEST(ColladaArrays, MustHaveWhatTheirAccessorReads) {
  const std::string all = write_scene(make_node("a", kShape));
  const auto expect_refusal = [&](const std::string& before, const std::string& after, const std::string& part) {
    std::string text = all;
    text.replace(text.find(before), before.size(), after);
    const std::string said = catch_complaint([&] { count_triangles_of(text); });
    EXPECT_NE(said.find(part), std::string::npos) << after << ": " << said;
  };
  const std::string fewer = "has an array 'pa' of fewer numbers than its accessor reads";
  expect_refusal("count='9'", "count='00'", fewer);
  expect_refusal("count='9'", "count='8'", fewer);
  expect_refusal("count='3'", "count='4'", fewer);
  expect_refusal("stride='3'", "stride='4'", fewer);
  expect_refusal("stride='3'", "stride='3' offset='1'", fewer);
  expect_refusal("float_array id='pa'", "float_array id='pb'", fewer);
  expect_refusal("count='3'", "count='0x3'", "has count='0x3': expected a whole number");
  expect_refusal("count='3'", "count='99999999999'", "has count='99999999999': expected");
}

TEST(ColladaArrays, MayEndWithTheLastValueThatIsRead) {
  std::string text = write_scene(make_node("a", kShape));
  const std::string nine = "count='9'>0 0 0 1 0 0 0 1 0<";
  text.replace(text.find(nine), nine.size(), "count='11'>0 0 0 7 1 0 0 7 0 1 0<");
  text.replace(text.find("stride='3'"), 10, "stride='4'");
  EXPECT_EQ(count_triangles_of(text), 1u);
}

}  // namespace
}  // namespace hrp

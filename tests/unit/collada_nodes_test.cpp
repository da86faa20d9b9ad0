// SPDX-License-Identifier: BSD-3-Clause
// Nodes of COLLADA files that contain each other by reference. Without the check, Assimp 5.2 ends the program with a
// node that contains itself, and did not end within 12 s of processor time with 2^21 repetitions.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/robot/mesh.h"
#include "tests/catch_complaint.h"

namespace hrp {
namespace {

constexpr const char* kTriangle =
    "<library_geometries><geometry id='g'><mesh><source id='p'><float_array id='pa' count='9'>0 0 0 1 0 0 0 1 "
    "0</float_array>"
    "<technique_common><accessor source='#pa' count='3' stride='3'><param name='X' type='float'/><param name='Y' "
    "type='float'/>"
    "<param name='Z' type='float'/></accessor></technique_common></source><vertices id='v'><input semantic='POSITION' "
    "source='#p'/></vertices>"
    "<triangles count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 "
    "2</p></triangles></mesh></geometry></library_geometries>";
const std::string kShape = "<instance_geometry url='#g'/>";

// A scene of these nodes, with a library of these.
size_t count_triangles(const std::string& nodes, const std::string& library = "") {
  const std::string path = ::testing::TempDir() + "/nodes_" + std::to_string(getpid()) + ".dae";
  std::ofstream(path)
      << "<?xml version='1.0'?><COLLADA version='1.4.1'><asset/>" << kTriangle << "<library_nodes>" << library
      << "</library_nodes><library_visual_scenes><visual_scene id='s'>" << nodes
      << "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>";
  const size_t count = load_mesh(path, Vector3d::Ones()).triangles.size();
  unlink(path.c_str());
  return count;
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

}  // namespace
}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// A robot as MJCF and SDF know it: bodies that hang from bodies, each by any number of joints, whose frames need not be
// the bodies'. make_urdf() says the same as a URDF, so that there is one way from a file to a robot.
#pragma once

#include <string>
#include <vector>

#include "common/robot/robot_description.h"

namespace hrp {

// A joint of body B against its parent, or against what the joint before it moves.
struct BodyJoint {
  JointSpec spec;                         // X_PF and mimic are not used
  Transform X_BF;                         // joint frame F in the body, in the pose that the file shows
  double shown = 0.0;                     // [rad or m] position in that pose
  std::string follows;                    // mimic: name of the joint that this one follows, empty for none
  double multiplier = 1.0, offset = 0.0;  // spec's q = multiplier q_followed + offset
  int line = 0;
};

struct BodyShape {
  CollisionShape shape;  // kind, X_LG (pose in the body), size, scale; mesh: as find_mesh() takes it
  bool touches = true;   // false: only drawn
  Eigen::Vector4d color = {0.62, 0.69, 0.77, 1.0};  // red, green, blue, alpha
  int line = 0;
};

struct BodyFrame {
  std::string name;
  Transform X_BS;
  int line = 0;
};

struct Body {
  std::string name;
  std::string parent;             // empty for the root
  Transform X_PB;                 // in the pose that the file shows
  LinkInertia inertia;            // in the body's frame
  std::vector<BodyJoint> joints;  // from the parent on; none: fixed to it
  std::vector<BodyShape> shapes;
  std::vector<BodyFrame> frames;  // sites: frames with a name
  int line = 0;
};

struct BodyTree {
  std::string name;
  std::vector<Body> bodies;  // the root first
};

// A URDF whose lines know where they come from.
struct UrdfText {
  std::string text;
  std::vector<int> source_lines;  // [i]: line of the source that line i + 1 was made from, 0 for none
};

// `source`: what a comment at the top names. A body that hangs by several joints becomes as many links, the first ones
// without mass; a joint beside the body's origin becomes a moving link that the body is fixed to.
UrdfText make_urdf(const BodyTree& tree, const std::string& source);

// A shape's cylinder, with a ball at each end: a capsule, whose length is that of the cylinder [m].
void add_capsule(double radius, double length, const BodyShape& shape, Body* body);

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// Robots that nobody here wrote, hung up by their root link: what is fixed to a link becomes part of it.
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <map>
#include <stdexcept>

#include "common/base/read_file.h"
#include "common/robot/mesh.h"
#include "diagnosis/generator/robot_parts.h"
#include "servers/model_parser/mesh_path.h"

namespace hrp::cases {
namespace {

Eigen::Isometry3d make_pose(const urdf::Pose& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() =
      Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z).toRotationMatrix();
  X.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return X;
}

// Mass [kg], first moment [kg m] and second moment about the frame's origin [kg m^2], all additive.
struct Moments {
  double mass = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

Eigen::Matrix3d make_steiner(double mass, const Eigen::Vector3d& p) {
  return mass * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
}

// Adds the inertia of `link`, whose frame is at X in the frame of the moments.
void add_link_inertia(const urdf::Link& link, const Eigen::Isometry3d& X, Moments* moments) {
  if (!link.inertial) return;
  const urdf::Inertial& i = *link.inertial;
  const Eigen::Isometry3d X_C = X * make_pose(i.origin);
  Eigen::Matrix3d I;
  I << i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz;
  moments->mass += i.mass;
  moments->first += i.mass * X_C.translation();
  moments->second += X_C.linear() * I * X_C.linear().transpose() + make_steiner(i.mass, X_C.translation());
}

void set_inertia(const Moments& moments, LinkPlan* link) {
  if (!(moments.mass > 0)) return;
  const Eigen::Vector3d com = moments.first / moments.mass;
  const Eigen::Matrix3d I = moments.second - make_steiner(moments.mass, com);
  link->mass = moments.mass;
  link->com = {com[0], com[1], com[2]};
  link->inertia = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  link->box = {0.05, 0.05, 0.05};
}

// A mesh that is not there has no points.
void add_mesh(const urdf::Mesh& mesh, const std::string& urdf_path, const Eigen::Isometry3d& X,
              std::vector<Eigen::Vector3d>* points) {
  const std::string path = find_mesh(mesh.filename, urdf_path);
  if (path.empty()) return;
  const Eigen::Vector3d scale(mesh.scale.x, mesh.scale.y, mesh.scale.z);
  for (const Eigen::Vector3d& v : load_mesh(path, scale).vertices) points->push_back(X * v);
}

// Corners of boxes, lowest points of spheres, vertices of meshes.
void add_points(const urdf::Link& link, const std::string& urdf_path, const Eigen::Isometry3d& X,
                std::vector<Eigen::Vector3d>* points) {
  for (const auto& shape : link.collision_array) {
    const Eigen::Isometry3d X_G = X * make_pose(shape->origin);
    if (const auto box = std::dynamic_pointer_cast<urdf::Box>(shape->geometry)) {
      const Eigen::Vector3d half(box->dim.x / 2, box->dim.y / 2, box->dim.z / 2);
      for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        points->push_back(X_G * half.cwiseProduct(sign));
      }
    }
    if (const auto ball = std::dynamic_pointer_cast<urdf::Sphere>(shape->geometry)) {
      points->push_back(X_G.translation() - Eigen::Vector3d(0, 0, ball->radius));
    }
    if (const auto mesh = std::dynamic_pointer_cast<urdf::Mesh>(shape->geometry)) {
      add_mesh(*mesh, urdf_path, X_G, points);
    }
  }
}

// What robots look like is of no use here, and a frequent cause of warnings. <visualize> is another thing.
std::string without_visuals(std::string text) {
  const std::string open = "<visual", close = "</visual>";
  std::size_t begin = 0;
  while ((begin = text.find(open, begin)) != std::string::npos) {
    const std::size_t after = begin + open.size(), tag = text.find('>', after);
    if (tag == std::string::npos) break;
    if (std::string(" \t\r\n/>").find(text[after]) == std::string::npos) {
      begin = after;
      continue;
    }
    const std::size_t end = text[tag - 1] == '/' ? tag + 1 : text.find(close, tag) + close.size();
    if (end < tag) break;  // no closing tag
    text.erase(begin, end - begin);
  }
  return text;
}

bool turns(const urdf::Joint& joint) {
  return (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS) && !joint.mimic;
}

// The link `at` index of the plan, with everything that is fixed to it; then the links beyond turning joints.
class Builder {
 public:
  Builder(RobotPlan* robot, const std::string& urdf_path, SolePoints* points)
      : robot_(robot), urdf_path_(urdf_path), points_(points) {}

  void add(const urdf::Link& link, int index) {
    Moments moments;
    if (points_) points_->resize(std::max(points_->size(), static_cast<std::size_t>(index) + 1));
    at_ = index;
    std::vector<std::pair<const urdf::Joint*, Eigen::Isometry3d>> beyond;
    merge(link, Eigen::Isometry3d::Identity(), &moments, &beyond);
    LinkPlan& plan = robot_->links[static_cast<std::size_t>(index)];
    set_inertia(moments, &plan);
    if (index > 0 && !(plan.mass > 0))
      throw std::runtime_error(urdf_path_ + ": link " + plan.name + " turns but has no mass");
    for (const auto& [joint, X] : beyond) {
      const Eigen::Vector3d p = X.translation();
      const Eigen::Vector3d ypr = X.linear().eulerAngles(2, 1, 0);
      LinkPlan child = make_link(joint->child_link_name, index, joint->name, {p[0], p[1], p[2]},
                                 {joint->axis.x, joint->axis.y, joint->axis.z});
      child.joint.rpy = {ypr[2], ypr[1], ypr[0]};
      robot_->links.push_back(child);
      add(*children_.at(joint), static_cast<int>(robot_->links.size()) - 1);
    }
  }

 private:
  void merge(const urdf::Link& link, const Eigen::Isometry3d& X, Moments* moments,
             std::vector<std::pair<const urdf::Joint*, Eigen::Isometry3d>>* beyond) {
    add_link_inertia(link, X, moments);
    if (points_) add_points(link, urdf_path_, X, &(*points_)[static_cast<std::size_t>(at_)]);
    for (const auto& child : link.child_links) {
      const urdf::Joint& joint = *child->parent_joint;
      const Eigen::Isometry3d X_J = X * make_pose(joint.parent_to_joint_origin_transform);
      children_[&joint] = child.get();
      if (turns(joint))
        beyond->push_back({&joint, X_J});
      else
        merge(*child, X_J, moments, beyond);
    }
  }

  RobotPlan* robot_;
  std::string urdf_path_;
  SolePoints* points_;
  int at_ = 0;  // link of the plan that is being merged
  std::map<const urdf::Joint*, const urdf::Link*> children_;
};

}  // namespace

RobotPlan read_urdf_links(const std::string& urdf_path, SolePoints* points) {
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(without_visuals(read_input(urdf_path)));
  if (!model || !model->getRoot()) throw std::runtime_error(urdf_path + ": not a URDF that can be read");
  RobotPlan robot;
  robot.name = model->getName();
  robot.links.push_back({});
  robot.links[0].name = model->getRoot()->name;
  Builder(&robot, urdf_path, points).add(*model->getRoot(), 0);
  if (robot.links.size() < 3) throw std::runtime_error(urdf_path + ": fewer than two joints that turn");
  return robot;
}

RobotPlan make_hung_robot(const std::string& urdf_path, Prng& random) {
  RobotPlan robot = read_urdf_links(urdf_path, nullptr);
  for (std::size_t i = 1; i < robot.links.size(); ++i) {
    draw_servo(robot, i, random);
    if (random.chance(0.5)) robot.links[i].joint.start = round_to(random.uniform(-0.5, 0.5), 4);
  }
  return robot;
}

}  // namespace hrp::cases

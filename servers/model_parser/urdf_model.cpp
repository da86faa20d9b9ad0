// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/urdf_model.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <mutex>
#include <string>

namespace hrp {
namespace {

// What urdfdom says on its console while it parses.
class MessageCatcher : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) text_ += (text_.empty() ? "" : "; ") + text;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Both parsers must have seen the same robot: on malformed text they could differ.
bool agrees(const urdf::ModelInterface& model, const UrdfScan& scan) {
  for (const LinkScan& link : scan.links) {
    if (!model.getLink(link.name)) return false;
  }
  for (const JointScan& joint : scan.joints) {
    if (!model.getJoint(joint.name)) return false;
  }
  return true;
}

// urdfdom's console is global.
std::mutex& get_urdfdom_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

std::shared_ptr<urdf::ModelInterface> parse_urdf(const UrdfScan& scan, Diagnostics* diagnostics) {
  std::shared_ptr<urdf::ModelInterface> model;
  MessageCatcher catcher;
  std::string thrown;
  {
    const std::lock_guard<std::mutex> lock(get_urdfdom_mutex());
    console_bridge::useOutputHandler(&catcher);
    try {
      model = urdf::parseURDF(scan.bare_xml);
    } catch (const std::exception& error) {
      thrown = error.what();
    }
    console_bridge::restorePreviousOutputHandler();
  }
  if (model && agrees(*model, scan) && catcher.text().empty()) return model;
  int line = 0;
  for (const LinkScan& link : scan.links) {
    if (line == 0 && catcher.text().find("[" + link.name + "]") != std::string::npos) line = link.line;
  }
  diagnostics->add_error({scan.file, "", line}, "urdfdom refuses it: " + (thrown.empty() ? catcher.text() : thrown));
  return nullptr;
}

Transform make_transform(const urdf::Pose& pose) {
  const Eigen::Quaterniond q(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z);
  return {q.normalized().toRotationMatrix(), {pose.position.x, pose.position.y, pose.position.z}};
}

Vector3d make_vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

LinkInertia make_inertia(const urdf::Link& link) {
  LinkInertia result;
  if (!link.inertial) return result;
  const urdf::Inertial& i = *link.inertial;
  const Transform X_LI = make_transform(i.origin);
  Matrix3d I;
  I << i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz;
  result.mass = i.mass;
  result.p_LLcm_L = X_LI.p;
  result.I_LLcm_L = X_LI.R * I * X_LI.R.transpose();
  return result;
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
#include "tests/engines/mujoco_engine.h"

#include <mujoco/mujoco.h>

#include <cstdio>
#include <iomanip>
#include <sstream>

namespace hrp::engines {
namespace {

void write_vector(std::ostream& out, const char* name, const Eigen::VectorXd& values) {
  out << " " << name << "=\"";
  for (Eigen::Index i = 0; i < values.size(); ++i) out << (i > 0 ? " " : "") << values[i];
  out << "\"";
}

void write_pose(std::ostream& out, const Transform& X) {
  const Eigen::Quaterniond q(X.R);
  write_vector(out, "pos", X.p);
  write_vector(out, "quat", Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
}

// Diagonalised here: MuJoCo's own solver stops at fewer digits than the comparison needs.
void write_inertia(std::ostream& out, const LinkInertia& inertia) {
  if (inertia.mass == 0) return;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(inertia.I_LLcm_L);
  Matrix3d R = solver.eigenvectors();
  if (R.determinant() < 0) R.col(0) *= -1;
  out << "<inertial mass=\"" << inertia.mass << "\"";
  write_pose(out, {R, inertia.p_LLcm_L});
  write_vector(out, "diaginertia", solver.eigenvalues());
  out << "/>\n";
}

void write_joint(std::ostream& out, const JointSpec& joint, int i) {
  out << "<joint name=\"j" << i << "\" type=\"" << (joint.kind == JointKind::kPrismatic ? "slide" : "hinge") << "\"";
  write_vector(out, "axis", joint.axis_F);
  out << " armature=\"" << joint.rotor_inertia << "\"/>\n";
}

void write_body(std::ostream& out, const TreeSpec& spec, int link) {
  const LinkSpec& L = spec.links[static_cast<size_t>(link)];
  out << "<body name=\"b" << link << "\"";
  if (link > 0) write_pose(out, L.joint.X_PF);
  out << ">\n";
  if (link > 0) write_joint(out, L.joint, link - 1);
  if (link == 0 && spec.floating_base) out << "<freejoint name=\"base\"/>\n";
  write_inertia(out, L.inertia);
  for (int child = link + 1; child < static_cast<int>(spec.links.size()); ++child) {
    if (spec.links[static_cast<size_t>(child)].parent == link) write_body(out, spec, child);
  }
  out << "</body>\n";
}

void write_ties(std::ostream& out, const std::vector<BallTie>& ties) {
  out << "<equality>\n";
  for (const BallTie& tie : ties) {
    out << "<connect body1=\"b" << tie.link_a << "\" body2=\"b" << tie.link_b << "\" solimp=\"0.9999 0.9999 0.001\"";
    write_vector(out, "anchor", tie.p_AP);
    out << "/>\n";
  }
  out << "</equality>\n";
}

std::string make_mjcf(const TreeSpec& spec, const Vector3d& gravity_W, const std::vector<BallTie>& ties) {
  std::ostringstream out;
  out << std::setprecision(17) << "<mujoco>\n<compiler angle=\"radian\" inertiafromgeom=\"false\" boundmass=\"0\"/>\n"
      << "<option";
  write_vector(out, "gravity", gravity_W);
  out << "><flag contact=\"disable\" constraint=\"" << (ties.empty() ? "disable" : "enable")
      << "\" passive=\"disable\" actuation=\"disable\" "
      << "limit=\"disable\" warmstart=\"disable\"/></option>\n<worldbody>\n";
  write_body(out, spec, 0);
  out << "</worldbody>\n";
  write_ties(out, ties);
  out << "</mujoco>\n";
  return out.str();
}

mjModel* load(const std::string& xml, std::string* error) {
  mjVFS vfs;
  mj_defaultVFS(&vfs);
  mj_makeEmptyFileVFS(&vfs, "model.xml", static_cast<int>(xml.size()));
  std::copy(xml.begin(), xml.end(), static_cast<char*>(vfs.filedata[vfs.nfile - 1]));
  char text[1000] = "";
  mjModel* model = mj_loadXML("model.xml", &vfs, text, sizeof(text));
  mj_deleteVFS(&vfs);
  if (model == nullptr) *error = text;
  return model;
}

}  // namespace

MujocoEngine::MujocoEngine(const TreeSpec& spec, const Vector3d& gravity_W, const std::vector<BallTie>& ties)
    : num_base_(spec.floating_base ? 6 : 0) {
  model_ = load(make_mjcf(spec, gravity_W, ties), &error_);
  if (model_ == nullptr) return;
  data_ = mj_makeData(model_);
  for (int i = 0; i < spec.num_joints(); ++i) {
    const int id = mj_name2id(model_, mjOBJ_JOINT, ("j" + std::to_string(i)).c_str());
    dofs_.push_back(model_->jnt_dofadr[id]);
    positions_.push_back(model_->jnt_qposadr[id]);
  }
  force_ = Eigen::VectorXd::Zero(model_->nv);
}

MujocoEngine::~MujocoEngine() {
  mj_deleteData(data_);
  mj_deleteModel(model_);
}

void MujocoEngine::set_state(const State& state) {
  R_WB_ = state.R_WB.toRotationMatrix();
  if (num_base_ > 0) {
    const Eigen::Quaterniond& q = state.R_WB;
    const double pose[7] = {state.p_WB.x(), state.p_WB.y(), state.p_WB.z(), q.w(), q.x(), q.y(), q.z()};
    std::copy(pose, pose + 7, data_->qpos);
    Eigen::Map<Vector3d>(data_->qvel) = state.V_WB.tail<3>();
    Eigen::Map<Vector3d>(data_->qvel + 3) = R_WB_.transpose() * state.V_WB.head<3>();
  }
  for (size_t i = 0; i < dofs_.size(); ++i) {
    data_->qpos[positions_[i]] = state.q[static_cast<Eigen::Index>(i)];
    data_->qvel[dofs_[i]] = state.qd[static_cast<Eigen::Index>(i)];
  }
}

void MujocoEngine::set_effort(const Eigen::VectorXd& effort) {
  for (size_t i = 0; i < dofs_.size(); ++i) data_->qfrc_applied[dofs_[i]] = effort[static_cast<Eigen::Index>(i)];
}

void MujocoEngine::set_acceleration(const Eigen::VectorXd& vdot) {
  Eigen::Map<Eigen::VectorXd>(data_->qacc, model_->nv) = calc_coordinate_change() * vdot;
}

// From positions to accelerations with nothing that a free tree does not need.
void MujocoEngine::run_forward_dynamics() {
  mj_kinematics(model_, data_);
  mj_comPos(model_, data_);
  mj_crb(model_, data_);
  mj_factorM(model_, data_);
  mj_comVel(model_, data_);
  mj_rne(model_, data_, 0, force_.data());
  for (int i = 0; i < model_->nv; ++i) force_[i] = data_->qfrc_applied[i] - force_[i];
  mj_solveM(model_, data_, data_->qacc, force_.data(), 1);
}

void MujocoEngine::run_full_forward() { mj_forward(model_, data_); }

void MujocoEngine::run_mass_matrix() {
  mj_kinematics(model_, data_);
  mj_comPos(model_, data_);
  mj_crb(model_, data_);
}

void MujocoEngine::run_inverse_dynamics() {
  mj_kinematics(model_, data_);
  mj_comPos(model_, data_);
  mj_comVel(model_, data_);
  mj_rne(model_, data_, 1, force_.data());
  for (int i = 0; i < model_->nv; ++i) force_[i] += model_->dof_armature[i] * data_->qacc[i];
}

Eigen::MatrixXd MujocoEngine::calc_coordinate_change() const {
  const auto nv = static_cast<Eigen::Index>(model_->nv);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(nv, nv);
  if (num_base_ > 0) {
    T.block<3, 3>(0, 3).setIdentity();
    T.block<3, 3>(3, 0) = R_WB_.transpose();
  }
  for (size_t i = 0; i < dofs_.size(); ++i) T(dofs_[i], num_base_ + static_cast<Eigen::Index>(i)) = 1;
  return T;
}

Eigen::VectorXd MujocoEngine::get_acceleration() const {
  return calc_coordinate_change().transpose() * Eigen::Map<const Eigen::VectorXd>(data_->qacc, model_->nv);
}

Eigen::MatrixXd MujocoEngine::get_mass_matrix() const {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(model_->nv, model_->nv);
  mj_fullM(model_, M.data(), data_->qM);
  const Eigen::MatrixXd T = calc_coordinate_change();
  return T.transpose() * M * T;
}

Eigen::VectorXd MujocoEngine::get_effort() const { return calc_coordinate_change().transpose() * force_; }

}  // namespace hrp::engines

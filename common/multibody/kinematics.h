// SPDX-License-Identifier: BSD-3-Clause
// Poses, velocities, accelerations and Jacobians. Everything else starts from update_kinematics.
#pragma once

#include "common/multibody/model.h"

namespace hrp {

// A state with the model's sizes, all zero.
State make_state(const Model& model);

// Fills data->kinematics (poses and velocities of all links) and data->qd.
void update_kinematics(const Model& model, const State& state, Data* data);

// The following read what update_kinematics has filled.
Transform get_pose(const Data& data, int link);     // X_WL
Vector6d get_velocity(const Data& data, int link);  // V_WL
// Velocity of the frame F of the same link whose origin is at p_WF: [w; v of F's origin].
Vector6d calc_point_velocity(const Data& data, int link, const Vector3d& p_WF);

// Index of a frame of the model by name is TreeSpec::find_frame.
Transform calc_frame_pose(const Model& model, const Data& data, int frame);
Vector6d calc_frame_velocity(const Model& model, const Data& data, int frame);

// Accelerations of all links for a given vdot (size nv) into data->motion alpha and acc: true ones, without gravity.
void update_accelerations(const Model& model, const Eigen::VectorXd& vdot, Data* data);
// [alpha; acceleration of the point], world axes, of what update_accelerations has filled.
Vector6d calc_point_acceleration(const Data& data, int link, const Vector3d& p_WQ);
Vector6d calc_frame_acceleration(const Model& model, const Data& data, int frame);
// Jdot v of a point: its acceleration when vdot = 0. Overwrites data->motion alpha and acc.
Vector6d calc_point_bias_acceleration(const Model& model, int link, const Vector3d& p_WQ, Data* data);

// J (6 x nv), [w; v of the point Q that is fixed to the link] = J v, world axes. J must have its size.
void calc_point_jacobian(const Model& model, const Data& data, int link, const Vector3d& p_WQ,
                         Eigen::Ref<Eigen::MatrixXd> J);
void calc_frame_jacobian(const Model& model, const Data& data, int frame, Eigen::Ref<Eigen::MatrixXd> J);

// v = [w_WB_W; v_WB_W; qd] of a state, and back.
void get_generalised_velocity(const Model& model, const State& state, Eigen::VectorXd* v);
void set_generalised_velocity(const Model& model, const Eigen::VectorXd& v, State* state);

// Moves the positions by velocity v during dt: exponential map on the attitude (world axes), then normalised.
void integrate_positions(const Model& model, const Eigen::VectorXd& v, double dt, State* state);

}  // namespace hrp

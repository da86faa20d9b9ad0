// SPDX-License-Identifier: BSD-3-Clause
// Centre of mass, momentum, energy. All need update_kinematics.
#pragma once

#include "common/multibody/model.h"

namespace hrp {

Vector3d calc_centre_of_mass(const Model& model, const Data& data);           // [m] p_WCom
Vector3d calc_centre_of_mass_velocity(const Model& model, const Data& data);  // [m/s]
// J (3 x nv): velocity of the centre of mass = J v.
void calc_centre_of_mass_jacobian(const Model& model, Data* data, Eigen::Ref<Eigen::MatrixXd> J);

// [angular momentum about Q; linear momentum] of all links, world axes. Rotors are seen as reflected inertias of their
// joints only: they add nothing here.
Vector6d calc_momentum(const Model& model, const Data& data, const Vector3d& p_WQ);
Vector6d calc_centroidal_momentum(const Model& model, const Data& data);

double calc_kinetic_energy(const Model& model, const Data& data);    // [J] with reflected rotor inertias
double calc_potential_energy(const Model& model, const Data& data);  // [J] of gravity, zero at the world's origin

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// consumer LOG: the installed libraries from a project that knows no more than their names.
#include <cstdio>

#include "common/log/log_table.h"
#include "common/messages/cdr.h"
#include "common/multibody/kinematics.h"
#include "common/multibody/mass_matrix.h"
#include "hrp_idl/control.h"

namespace {

// [kg m^2] of a point mass of 2 kg on a rod of 0.5 m, about its hinge: 0.5.
double calc_hinge_inertia() {
  hrp::TreeSpec tree;
  tree.floating_base = false;
  tree.links.resize(2);
  tree.links[1].parent = 0;
  tree.links[1].inertia.mass = 2.0;
  tree.links[1].inertia.p_LLcm_L = hrp::Vector3d(0.5, 0.0, 0.0);
  const hrp::Model model(tree);
  hrp::Data data(model);
  hrp::update_kinematics(model, hrp::make_state(model), &data);
  return hrp::update_mass_matrix(model, &data)(0, 0);
}

size_t count_positions_after_the_wire() {
  hrp::msg::JointCommands sent, received;
  sent.positions({1.0, 2.0, 3.0});
  std::vector<char> buffer;
  hrp::decode(hrp::encode(sent, &buffer), &received);
  return received.positions().size();
}

}  // namespace

int main(int, char** argv) {
  hrp::mcap::Reader log(argv[1]);
  const hrp::LogTable table = hrp::read_log_table(&log);
  std::printf("hinge %.3f kg m^2, %zu positions, log begins with %s\n", calc_hinge_inertia(),
              count_positions_after_the_wire(), table.names.at(0).c_str());
}

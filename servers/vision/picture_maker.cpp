// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/picture_maker.h"

namespace hrp {

PictureMaker::PictureMaker(const RobotDescription& robot, const Scenario& scenario)
    : sensors_(scenario.sensors), seed_(scenario.seed), world_(robot, scenario), caster_(world_.shapes()) {}

void PictureMaker::look(const Look& look, LookResult* result) {
  result->pictures.resize(cameras().size());
  result->scans.resize(lidars().size());
  world_.update(look.state, look.objects);
  caster_.place(world_.poses());
  for (const size_t sensor : look.sensors) {
    const NoiseKey noise{seed_, sensor, look.step};
    if (sensor < cameras().size()) {
      const CameraSpec& camera = cameras()[sensor];
      const Transform X_WO = world_.find_mount_pose(camera.link, camera.X_LC) * make_optical_frame();
      take_picture(camera, X_WO, world_, caster_, noise, &result->pictures[sensor]);
    } else {
      const LidarSpec& lidar = lidars()[sensor - cameras().size()];
      take_scan(lidar, world_.find_mount_pose(lidar.link, lidar.X_LC), world_, caster_, noise,
                &result->scans[sensor - cameras().size()]);
    }
  }
}

}  // namespace hrp

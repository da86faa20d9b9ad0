// SPDX-License-Identifier: BSD-3-Clause
// Which shape a ray meets first. Embree finds it; where it is met is then computed in double precision by solid_hit.h,
// so that a depth depends neither on the processor's instruction set nor on single precision. The only folder that
// includes Embree.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "servers/vision/solid_hit.h"
#include "servers/vision/visible_world.h"

namespace hrp {

struct SceneHit {
  double t = 0.0;
  Vector3d n_W = Vector3d::UnitZ();  // outward unit normal
  size_t shape = 0;                  // index in VisibleWorld::shapes()
};

class RayCaster {
 public:
  // Throws std::runtime_error when Embree cannot be started.
  explicit RayCaster(const std::vector<VisibleShape>& shapes);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  // X_WG of each shape; before the first cast.
  void place(const std::vector<Transform>& X_WG);
  // World axes.
  std::optional<SceneHit> cast(const Ray& ray) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hrp

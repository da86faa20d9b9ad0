// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "common/effects/link_law.h"
#include "diagnosis/toss/model.h"

namespace hrp::diagnosis::toss {

const TossInfo& get_toss_info(TossId id) {
  static const std::vector<TossInfo> table{
      {TossId::kGroundFriction,
       "ground_friction",
       "ground",
       "ground",
       {{"coefficient", "1", 0.5, 0.01, 0.0, 3.0}},
       "the ground's friction differs from the model's: speed along the ground is lost at another rate"},
      {TossId::kRestitution,
       "restitution",
       "ground",
       "ground",
       {{"coefficient", "1", 0.0, 0.01, 0.0, 1.0}},
       "the body bounces: of the speed at which a point strikes, this share comes back"},
      {TossId::kGroundSlope,
       "ground_slope",
       "ground",
       "ground",
       {{"roll", "rad", 0.0, 1e-3, -0.5, 0.5}, {"pitch", "rad", 0.0, 1e-3, -0.5, 0.5}},
       "the ground is not level"},
      {TossId::kComError,
       "com_error",
       "link",
       "",
       {{"offset_x", "m", 0.0, 1e-4, -1.0, 1.0},
        {"offset_y", "m", 0.0, 1e-4, -1.0, 1.0},
        {"offset_z", "m", 0.0, 1e-4, -1.0, 1.0}},
       "the centre of mass is elsewhere: in flight the body turns about another point"},
      {TossId::kPayload,
       "payload",
       "link",
       "",
       {{"mass", "kg", 0.0, 1e-3, 0.0, 1e3},
        {"com_x", "m", 0.0, 1e-3, -1.0, 1.0},
        {"com_y", "m", 0.0, 1e-3, -1.0, 1.0},
        {"com_z", "m", 0.0, 1e-3, -1.0, 1.0}},
       "an unmodelled mass is carried: centre of mass and inertia are both changed by it"},
      {TossId::kInertiaError,
       "inertia_error",
       "link",
       "",
       {{"scale", "1", 1.0, 0.01, 0.1, 10.0}},
       "the moments of inertia are those of another spread of mass: spin after an impact is off"},
      {TossId::kPositionBias,
       "sensor_bias",
       "sensor",
       "/base/pose/position",
       {{"value_z", "m", 0.0, 1e-4, -1.0, 1.0}},
       "recorded heights are shifted by a constant: the body seems to rest above or in the ground"},
      {TossId::kPositionScale,
       "sensor_scale",
       "sensor",
       "/base/pose/position",
       {{"scale", "1", 1.0, 1e-3, 0.5, 2.0}},
       "recorded positions are scaled: free fall has another acceleration"},
      {TossId::kMisalignment,
       "sensor_misalignment",
       "sensor",
       "/base/pose/orientation",
       {{"rpy_x", "rad", 0.0, 1e-3, -1.0, 1.0},
        {"rpy_y", "rad", 0.0, 1e-3, -1.0, 1.0},
        {"rpy_z", "rad", 0.0, 1e-3, -1.0, 1.0}},
       "the tracked frame is turned against the body: it lies flat at an attitude that is not flat"},
      {TossId::kOrientationDelay,
       "sensor_delay",
       "sensor",
       "/base/pose/orientation",
       {{"delay", "s", 0.0, 2e-4, -0.1, 0.1}},
       "attitudes come late against positions"},
      {TossId::kClockSkew,
       "clock_skew",
       "sensor",
       "/base/pose",
       {{"skew", "1", 0.0, 1e-3, -0.5, 0.5}},
       "the clock of the recording runs at another rate: free fall has another acceleration, lengths are right"},
      {TossId::kDrag, "air_drag", "link", "", {{"rate", "1/s", 0.0, 0.01, -10.0, 10.0}}, "speed is lost in flight"}};
  return table[static_cast<size_t>(id)];
}

TossEffect make_neutral(const TossProblem& problem, TossId id) {
  TossEffect effect{id, {}};
  for (const TossParameter& p : get_toss_info(id).parameters) effect.p.push_back(p.neutral);
  if (id == TossId::kGroundFriction) effect.p[0] = problem.nominal.ground.friction;
  if (id == TossId::kRestitution) effect.p[0] = problem.nominal.restitution;
  return effect;
}

bool has_effect(const TossHypothesis& hypothesis, TossId id) {
  return std::any_of(hypothesis.begin(), hypothesis.end(), [&](const TossEffect& e) { return e.id == id; });
}

namespace {

Vector3d get3(const std::vector<double>& p, size_t at = 0) { return {p[at], p[at + 1], p[at + 2]}; }

}  // namespace

TossModel make_toss_model(const TossProblem& problem, const TossHypothesis& hypothesis) {
  TossModel model{problem.nominal, {}};
  World& w = model.world;
  PoseSensor& s = model.sensor;
  LinkInertia& link = w.body.links[0].inertia;
  for (const TossEffect& e : hypothesis) {
    switch (e.id) {
      case TossId::kGroundFriction:
        w.ground.friction = e.p[0];
        break;
      case TossId::kRestitution:
        w.restitution = e.p[0];
        break;
      case TossId::kGroundSlope:
        w.ground.roll += e.p[0], w.ground.pitch += e.p[1];
        break;
      case TossId::kComError:
        link.p_LLcm_L += get3(e.p);
        break;
      case TossId::kPayload:
        add_payload(e.p[0], get3(e.p, 1), 0.0, &link);
        break;
      case TossId::kInertiaError:
        link.I_LLcm_L *= e.p[0];
        break;
      case TossId::kPositionBias:
        s.bias.z() = e.p[0];
        break;
      case TossId::kPositionScale:
        s.scale = e.p[0];
        break;
      case TossId::kMisalignment:
        s.R = make_rotation_from_rpy(get3(e.p));
        break;
      case TossId::kOrientationDelay:
        s.delay = e.p[0];
        break;
      case TossId::kClockSkew:
        s.skew = e.p[0];
        break;
      case TossId::kDrag:
        w.drag = e.p[0];
        break;
    }
  }
  return model;
}

}  // namespace hrp::diagnosis::toss

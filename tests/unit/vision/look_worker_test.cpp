// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/look_worker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes.h"

namespace hrp {
namespace {

constexpr char kWorld[] = "sensors: {camera: {eye: {width: 200, height: 150}, other: {width: 4, height: 4}}}\n";

LookJob make_job(uint64_t step, const SeenScene& scene) {
  LookJob job;
  job.look = scene.look;
  job.look.step = step;
  return job;
}

std::vector<uint64_t> take_all(LookWorker* worker) {
  std::vector<uint64_t> steps;
  while (worker->find_oldest_step()) {
    if (const auto done = worker->take_done())
      steps.push_back(done->job.look.step);
    else
      std::this_thread::yield();
  }
  return steps;
}

std::unique_ptr<LookWorker> make_worker(const SeenScene& scene, LookWorker::Late late) {
  return std::make_unique<LookWorker>(std::make_unique<PictureMaker>(scene.robot, scene.scenario), late);
}

TEST(LookWorker, ThatQueuesTakesEveryLookInOrder) {
  SeenScene scene(kWorld);
  const auto worker = make_worker(scene, LookWorker::Late::kQueue);
  for (uint64_t step = 0; step < 20; ++step) EXPECT_EQ(worker->post(make_job(step, scene)), 0u);
  std::vector<uint64_t> all(20);
  for (size_t i = 0; i < all.size(); ++i) all[i] = i;
  EXPECT_EQ(take_all(worker.get()), all);
}

TEST(LookWorker, ThatDropsCountsWhatItDropsAndTakesTheNewest) {
  SeenScene scene(kWorld);
  const auto worker = make_worker(scene, LookWorker::Late::kDrop);
  size_t dropped = 0;
  for (uint64_t step = 0; step < 1000; ++step) dropped += worker->post(make_job(step, scene));
  const std::vector<uint64_t> taken = take_all(worker.get());
  EXPECT_EQ(dropped % 2, 0u) << "whole looks, of two cameras each";
  EXPECT_EQ(taken.size() + dropped / 2, 1000u) << "what is not dropped is taken";
  EXPECT_GT(dropped, 0u) << "a thousand pictures take longer than a thousand posts";
  EXPECT_EQ(taken.back(), 999u);
  EXPECT_TRUE(std::is_sorted(taken.begin(), taken.end()));
}

// A run that begins anew counts its steps from zero: a look of the old one must not count as progress of the new one.
TEST(LookWorker, NothingOfWhatIsForgottenCountsOrComes) {
  SeenScene scene(kWorld);
  const auto worker = make_worker(scene, LookWorker::Late::kQueue);
  for (uint64_t step = 5000; step < 5010; ++step) worker->post(make_job(step, scene));
  worker->forget_all();
  EXPECT_FALSE(worker->find_oldest_step());
  worker->post(make_job(3, scene));
  EXPECT_THAT(take_all(worker.get()), testing::ElementsAre(3));
}

TEST(LookWorker, GivesTheBitsOfAPictureThatIsTakenAlone) {
  SeenScene scene("sensors: {camera: {eye: {xyz: [-3, 0, 0.5], color_noise: 0.01}}}\n");
  const auto worker = make_worker(scene, LookWorker::Late::kQueue);
  for (const uint64_t step : {3, 4, 5}) worker->post(make_job(step, scene));
  for (const uint64_t step : {3, 4, 5}) {
    std::optional<LookDone> done;
    while (!(done = worker->take_done())) std::this_thread::yield();
    EXPECT_EQ(done->fault, "");
    EXPECT_EQ(done->result.pictures[0].rgb, scene.see(0.0, step).pictures[0].rgb);
  }
}

TEST(LookWorker, SaysWhyAStateOfAnotherRobotCannotBeSeen) {
  SeenScene scene(kWorld);
  const auto worker = make_worker(scene, LookWorker::Late::kQueue);
  LookJob job = make_job(0, scene);
  job.look.state.q.resize(7);
  worker->post(job);
  std::optional<LookDone> done;
  while (!(done = worker->take_done())) std::this_thread::yield();
  EXPECT_THAT(done->fault, ::testing::HasSubstr("a state of 7 joints"));
}

}  // namespace
}  // namespace hrp

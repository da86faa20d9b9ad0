// SPDX-License-Identifier: BSD-3-Clause
// From whom pushes come and when they act: common/node/live_pushes.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/node/live_pushes.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

msg::Push make_push(const std::string& link, double force, uint64_t steps) {
  msg::Push push;
  push.link(link);
  push.force().x(force);
  push.steps(steps);
  return push;
}

// Sum of the forces of each step.
std::vector<double> play(LivePushes* live, uint64_t first, uint64_t count) {
  std::vector<double> forces;
  for (uint64_t step = first; step < first + count; ++step) {
    double sum = 0.0;
    for (const PushForce& force : live->find(step)) sum += force.force_W.x();
    forces.push_back(sum);
  }
  return forces;
}

TEST(PushQueue, APushBeginsWithTheFirstStepThatIsNotGranted) {
  PushQueue queue;
  queue.add(make_push("hand", 5.0, 10));
  const auto given = queue.give_out(64, 3);
  ASSERT_EQ(given.size(), 1u);
  EXPECT_EQ(given[0].from_step(), 64u);
  EXPECT_EQ(given[0].number(), 1u);
}

// Only the last grant is sure to arrive, so a push is in all of them until dynamics has begun with it.
TEST(PushQueue, APushIsGivenOutUnchangedUntilItHasBegun) {
  PushQueue queue;
  queue.add(make_push("hand", 5.0, 10));
  queue.give_out(64, 3);
  EXPECT_EQ(queue.give_out(128, 64).at(0).from_step(), 64u);
  EXPECT_TRUE(queue.give_out(192, 65).empty());
}

TEST(PushQueue, WhileARunIsPausedTheLastPushOfALinkCounts) {
  PushQueue queue;
  for (double force : {1.0, 2.0, 3.0}) queue.add(make_push("hand", force, 10));
  queue.add(make_push("head", 7.0, 10));
  const auto given = queue.give_out(0, 0);
  ASSERT_EQ(given.size(), 2u);
  EXPECT_EQ(given[0].force().x(), 3.0);
  EXPECT_EQ(given[1].force().x(), 7.0);
}

TEST(LivePushes, APushActsForItsStepsAndNoLonger) {
  LivePushes live;
  PushQueue queue;
  queue.add(make_push("hand", 5.0, 3));
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (const msg::Push& push : queue.give_out(2, 0)) live.add(push);
  }
  EXPECT_THAT(play(&live, 0, 7), ::testing::ElementsAre(0, 0, 5, 5, 5, 0, 0));
  EXPECT_TRUE(live.empty());
}

// It goes on with the epoch, in which dynamics has taken pushes of the scheduler before it.
TEST(LivePushes, PushesOfARestartedSchedulerAct) {
  LivePushes live;
  PushQueue before(100), after(2000);
  before.add(make_push("hand", 5.0, 2));
  for (const msg::Push& push : before.give_out(0, 0)) live.add(push);
  after.add(make_push("hand", 7.0, 2));
  for (const msg::Push& push : after.give_out(4, 3)) live.add(push);
  EXPECT_THAT(play(&live, 0, 7), ::testing::ElementsAre(5, 5, 0, 0, 7, 7, 0));
}

TEST(LivePushes, TheNextPushOfTheLinkEndsTheOneBefore) {
  LivePushes live;
  PushQueue queue;
  queue.add(make_push("hand", 5.0, 100));
  queue.add(make_push("head", 1.0, 100));
  queue.give_out(1, 0);
  queue.add(make_push("hand", 8.0, 100));
  queue.give_out(3, 0);
  queue.add(make_push("hand", 0.0, 0));  // lets go
  for (const msg::Push& push : queue.give_out(5, 0)) live.add(push);
  EXPECT_THAT(play(&live, 0, 7), ::testing::ElementsAre(0, 6, 6, 9, 9, 1, 1));
}

TEST(Push, WhatCannotBeIsSaid) {
  TreeSpec tree;
  tree.links.emplace_back().name = "hand";
  EXPECT_EQ(find_push_fault(make_push("hand", 5.0, 3), tree, {}), "");
  EXPECT_THAT(find_push_fault(make_push("tail", 5.0, 3), tree, {}), HasSubstr("no link 'tail'"));
  Mover crate, partner;
  crate.name = "crate";
  partner.name = "partner";
  partner.is_robot = true;
  crate.robot.tree = partner.robot.tree = tree;
  for (const char* body : {"hand", "crate", "partner/hand"})
    EXPECT_EQ(find_push_fault(make_push(body, 5.0, 3), tree, {crate, partner}), "");
  for (const char* body : {"crate/hand", "partner", "partner/tail", "hand/partner"}) {
    EXPECT_THAT(find_push_fault(make_push(body, 5.0, 3), tree, {crate, partner}), HasSubstr("ROBOT/LINK")) << body;
  }
  EXPECT_THAT(find_push_fault(make_push("hand", std::nan(""), 3), tree, {}), HasSubstr("finite"));
  EXPECT_THAT(find_push_fault(make_push("hand", std::numeric_limits<double>::infinity(), 3), tree, {}),
              HasSubstr("finite"));
  EXPECT_THAT(find_push_fault(make_push("hand", 2e5, 3), tree, {}), HasSubstr("200000"));
  EXPECT_THAT(find_push_fault(make_push("hand", 5.0, 2000000), tree, {}), HasSubstr("at most 1000000 steps"));
}

}  // namespace
}  // namespace hrp

/* SPDX-License-Identifier: BSD-3-Clause
 * ros_stamps DOMAIN: says the stamp of every message of a run, as a node of ROS 2 reads them, until it is ended:
 *   TOPIC SECONDS NANOSECONDS */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "ros_views.h"

enum { kClock, kTf, kJoints, kImu, kWrench, kTopics, kBatch = 64 };

static dds_entity_t check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "ros_stamps: %s: %s\n", what, dds_strretcode(entity));
  exit(1);
}

static builtin_interfaces_msg_dds__Time_ find_stamp(int topic, const void* sample) {
  switch (topic) {
    case kClock: return ((const rosgraph_msgs_msg_dds__Clock_*)sample)->clock;
    case kTf: return ((const tf2_msgs_msg_dds__TFMessage_*)sample)->transforms._buffer[0].header.stamp;
    case kJoints: return ((const sensor_msgs_msg_dds__JointState_*)sample)->header.stamp;
    case kImu: return ((const sensor_msgs_msg_dds__Imu_*)sample)->header.stamp;
    default: return ((const geometry_msgs_msg_dds__WrenchStamped_*)sample)->header.stamp;
  }
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  setvbuf(stdout, NULL, _IOLBF, 0);
  const char* names[kTopics] = {"rt/clock", "rt/tf", "rt/joint_states", "rt/imu/chest", "rt/wrench/left_foot"};
  const dds_topic_descriptor_t* types[kTopics] = {
      &rosgraph_msgs_msg_dds__Clock__desc, &tf2_msgs_msg_dds__TFMessage__desc, &sensor_msgs_msg_dds__JointState__desc,
      &sensor_msgs_msg_dds__Imu__desc, &geometry_msgs_msg_dds__WrenchStamped__desc};
  const dds_entity_t participant =
      check(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  dds_entity_t readers[kTopics];
  for (int i = 0; i < kTopics; ++i) {
    const dds_entity_t topic = check(dds_create_topic(participant, types[i], names[i], NULL, NULL), names[i]);
    readers[i] = check(dds_create_reader(participant, topic, qos, NULL), names[i]);
  }
  for (;; dds_sleepfor(DDS_MSECS(5))) {
    for (int topic = 0; topic < kTopics; ++topic) {
      void* samples[kBatch] = {NULL};
      dds_sample_info_t infos[kBatch];
      const int taken = dds_take(readers[topic], samples, infos, kBatch, kBatch);
      for (int i = 0; i < taken; ++i) {
        if (!infos[i].valid_data) continue;
        const builtin_interfaces_msg_dds__Time_ stamp = find_stamp(topic, samples[i]);
        printf("%s %d %u\n", names[topic], stamp.sec, stamp.nanosec);
      }
      if (taken > 0) dds_return_loan(readers[topic], samples, taken);
    }
  }
}

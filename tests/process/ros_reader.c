/* SPDX-License-Identifier: BSD-3-Clause
 * ros_reader DOMAIN COUNT [NAMESPACE]: reads a run as a node of ROS 2 does, with idlc's types and nothing of ours,
 * until COUNT messages of /tf have come and everything else at least once. One line a finding: end TOPIC TYPE USER_DATA
 * urdf LENGTH            fixed COUNT     clock SECONDS NANOSECONDS tf SECONDS NANOSECONDS PARENT CHILD x y z joints
 * COUNT    (tf: the first frame of the last message) root CHILD x y z (frames of that message below the same parent)
 * NAMESPACE "partner": of robot_description and joint_states. */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ros_views.h"

enum { kClock, kTf, kFixed, kUrdf, kJoints, kTopics, kBatch = 64 };
static long counts[kTopics];

static dds_entity_t check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "ros_reader: %s: %s\n", what, dds_strretcode(entity));
  exit(1);
}

/* rmw's default quality of service; that of latched topics. */
static dds_entity_t make_reader(dds_entity_t participant, const dds_topic_descriptor_t* type, const char* name,
                                int latched) {
  const dds_entity_t topic = check(dds_create_topic(participant, type, name, NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, latched ? 1 : 10);
  dds_qset_durability(qos, latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  const dds_entity_t reader = check(dds_create_reader(participant, topic, qos, NULL), name);
  dds_delete_qos(qos);
  return reader;
}

static void print_ends(dds_entity_t publications) {
  void* samples[1024] = {NULL};
  static dds_sample_info_t infos[1024];
  const int taken = dds_read(publications, samples, infos, 1024, 1024);
  for (int i = 0; i < taken; ++i) {
    const dds_builtintopic_endpoint_t* end = samples[i];
    void* data = NULL;
    size_t size = 0;
    if (!infos[i].valid_data || strncmp(end->topic_name, "rt/", 3) || !dds_qget_userdata(end->qos, &data, &size))
      continue;
    printf("end %s %s %.*s\n", end->topic_name, end->type_name, (int)size, data ? (const char*)data : "");
    dds_free(data);
  }
  if (taken > 0) dds_return_loan(publications, samples, taken);
}

static void print_last(int topic, const void* sample) {
  const rosgraph_msgs_msg_dds__Clock_* clock = sample;
  const tf2_msgs_msg_dds__TFMessage_* frames = sample;
  const geometry_msgs_msg_dds__TransformStamped_* first = topic == kTf ? &frames->transforms._buffer[0] : NULL;
  if (topic == kClock) printf("clock %d %u\n", clock->clock.sec, clock->clock.nanosec);
  if (topic == kTf) {
    printf("tf %d %u %s %s %.17g %.17g %.17g\n", first->header.stamp.sec, first->header.stamp.nanosec,
           first->header.frame_id, first->child_frame_id, first->transform.translation.x,
           first->transform.translation.y, first->transform.translation.z);
    for (uint32_t i = 0; i < frames->transforms._length; ++i) {
      const geometry_msgs_msg_dds__TransformStamped_* each = &frames->transforms._buffer[i];
      if (strcmp(each->header.frame_id, first->header.frame_id)) continue;
      printf("root %s %.17g %.17g %.17g\n", each->child_frame_id, each->transform.translation.x,
             each->transform.translation.y, each->transform.translation.z);
    }
  }
  if (topic == kFixed) printf("fixed %u\n", frames->transforms._length);
  if (topic == kUrdf) printf("urdf %zu\n", strlen(((const std_msgs_msg_dds__String_*)sample)->data));
  if (topic == kJoints) printf("joints %u\n", ((const sensor_msgs_msg_dds__JointState_*)sample)->name._length);
}

static int is_done(long count) {
  for (int i = 0; i < kTopics; ++i) {
    if (counts[i] == 0) return 0;
  }
  return counts[kTf] >= count;
}

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) return 2;
  char urdf[256], joints[256];
  snprintf(urdf, sizeof urdf, "rt/%s%srobot_description", argc > 3 ? argv[3] : "", argc > 3 ? "/" : "");
  snprintf(joints, sizeof joints, "rt/%s%sjoint_states", argc > 3 ? argv[3] : "", argc > 3 ? "/" : "");
  const long count = atol(argv[2]);
  const dds_entity_t participant =
      check(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  const dds_entity_t publications =
      check(dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL), "ends");
  const dds_entity_t readers[kTopics] = {
      make_reader(participant, &rosgraph_msgs_msg_dds__Clock__desc, "rt/clock", 0),
      make_reader(participant, &tf2_msgs_msg_dds__TFMessage__desc, "rt/tf", 0),
      make_reader(participant, &tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", 1),
      make_reader(participant, &std_msgs_msg_dds__String__desc, urdf, 1),
      make_reader(participant, &sensor_msgs_msg_dds__JointState__desc, joints, 0)};
  for (int done = 0; !done;) {
    dds_sleepfor(DDS_MSECS(5));
    done = is_done(count);
    for (int topic = 0; topic < kTopics; ++topic) {
      void* samples[kBatch] = {NULL};
      dds_sample_info_t infos[kBatch];
      const int taken = dds_take(readers[topic], samples, infos, kBatch, kBatch);
      for (int i = 0; i < taken; ++i) {
        if (!infos[i].valid_data) continue;
        ++counts[topic];
        if (done || topic == kFixed || topic == kUrdf) print_last(topic, samples[i]);
      }
      if (taken > 0)
        dds_return_loan(readers[topic], samples, taken);
      else if (done && topic != kFixed && topic != kUrdf)
        done = 0; /* each says something in the last round */
    }
  }
  print_ends(publications);
  dds_delete(participant);
  return 0;
}

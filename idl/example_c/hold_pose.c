/* SPDX-License-Identifier: BSD-3-Clause
 * hold_pose DOMAIN: a controller. It answers each sample of sensor data with the pose of the first one, as references
 * of the joint servos. Ends with the run. CYCLONEDDS_URI names cyclone.xml (docs/client_in_c.md). */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "control.h"  /* idlc made them from idl/control.idl */
#include "dynamics.h" /* and idl/dynamics.idl */

static dds_entity_t check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "hold_pose: %s: %s\n", what, dds_strretcode(entity));
  exit(1);
}

/* Your law goes here: readings in, one reference a joint out. */
static void control(const hrp_msg_SensorData* sensors, hrp_msg_JointCommands* command) {
  if (command->positions._length > 0) return; /* the pose of the first sample stays */
  const uint32_t joints = sensors->positions._length;
  command->positions._buffer = malloc(joints * sizeof(double));
  command->positions._length = command->positions._maximum = joints;
  memcpy(command->positions._buffer, sensors->positions._buffer, joints * sizeof(double)); /* [rad] */
}

/* Reliable and with all samples: the simulation waits for each answer. */
static dds_entity_t make_reader(dds_entity_t participant) {
  const dds_entity_t topic =
      check(dds_create_topic(participant, &hrp_msg_SensorData_desc, "hrp/sensor_data", NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  const dds_entity_t reader = check(dds_create_reader(participant, topic, qos, NULL), "reader");
  dds_delete_qos(qos);
  return reader;
}

static dds_entity_t make_writer(dds_entity_t participant) {
  const dds_entity_t topic =
      check(dds_create_topic(participant, &hrp_msg_JointCommands_desc, "hrp/joint_commands", NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1024);
  const dds_entity_t writer = check(dds_create_writer(participant, topic, qos, NULL), "writer");
  dds_delete_qos(qos);
  return writer;
}

static int has_ended(dds_entity_t reader) {
  dds_subscription_matched_status_t status;
  dds_get_subscription_matched_status(reader, &status);
  return status.total_count > 0 && status.current_count == 0;
}

int main(int argc, char** argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: hold_pose DOMAIN\n");
    return 2;
  }
  const dds_entity_t participant =
      check(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  const dds_entity_t reader = make_reader(participant), writer = make_writer(participant);
  const dds_entity_t waitset = check(dds_create_waitset(participant), "waitset");
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset, reader, 0);
  hrp_msg_JointCommands command;
  memset(&command, 0, sizeof command);
  long answers = 0;
  while (!has_ended(reader)) {
    enum { kBatch = 16 };
    void* samples[kBatch] = {NULL};
    dds_sample_info_t infos[kBatch];
    dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(100));
    const int taken = dds_take(reader, samples, infos, kBatch, kBatch);
    for (int i = 0; i < taken; ++i) {
      const hrp_msg_SensorData* sensors = samples[i];
      if (!infos[i].valid_data) continue;
      control(sensors, &command);
      command.header = sensors->header; /* epoch, step and time of the sample that is answered */
      if (dds_write(writer, &command) == DDS_RETCODE_OK) ++answers;
    }
    if (taken > 0) dds_return_loan(reader, samples, taken);
  }
  printf("%ld samples answered\n", answers);
  dds_delete(participant);
  return 0;
}

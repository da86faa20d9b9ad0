/* SPDX-License-Identifier: BSD-3-Clause
 * foreign_ends DOMAIN FAULT: an end of somebody else's program that is wrong in one way, until standard input closes.
 * FAULT: best_effort_writer | late_reader | eager_reader | other_type | misspelt. CYCLONEDDS_URI names cyclone.xml. */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "control.h"
#include "dynamics.h"
#include "scheduling.h"

static dds_entity_t check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "foreign_ends: %s: %s\n", what, dds_strretcode(entity));
  exit(1);
}

static void make_end(dds_entity_t participant, const dds_topic_descriptor_t* type, const char* name, int writer,
                     int reliable, int transient_local) {
  const dds_entity_t topic = check(dds_create_topic(participant, type, name, NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
  dds_qset_durability(qos, transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  check(writer ? dds_create_writer(participant, topic, qos, NULL) : dds_create_reader(participant, topic, qos, NULL),
        "end");
  dds_delete_qos(qos);
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const dds_entity_t participant =
      check(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  const char* fault = argv[2];
  if (!strcmp(fault, "best_effort_writer"))
    make_end(participant, &hrp_msg_JointCommands_desc, "hrp/joint_commands", 1, 0, 0);
  else if (!strcmp(fault, "late_reader"))
    make_end(participant, &hrp_msg_RunStatus_desc, "hrp/run_status", 0, 1, 0);
  else if (!strcmp(fault, "eager_reader"))
    make_end(participant, &hrp_msg_SensorData_desc, "hrp/sensor_data", 0, 1, 1);
  else if (!strcmp(fault, "other_type"))
    make_end(participant, &hrp_msg_SensorData_desc, "hrp/contact_set", 0, 1, 0);
  else if (!strcmp(fault, "misspelt"))
    make_end(participant, &hrp_msg_SensorData_desc, "hrp/sensor_dta", 0, 1, 0);
  else
    return 2;
  puts("there");
  fflush(stdout);
  getchar();
  dds_delete(participant);
  return 0;
}

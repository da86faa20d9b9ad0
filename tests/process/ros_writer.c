/* SPDX-License-Identifier: BSD-3-Clause
 * Commands a robot as a node of ROS 2 does, with idlc's types and rmw's quality of service, and nothing of ours:
 *   ros_writer DOMAIN trajectory JOINT POSITION SECONDS      to POSITION and at rest there SECONDS after its arrival
 *   ros_writer DOMAIN positions POSITION ...                 of all joints, from now on
 * Prints TOPIC TYPE USER_DATA of the reader. */
#include <dds/dds.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ros_views.h"

static dds_entity_t check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "ros_writer: %s: %s\n", what, dds_strretcode(entity));
  exit(1);
}

static void print_reader(dds_entity_t writer) {
  dds_instance_handle_t handle;
  if (dds_get_matched_subscriptions(writer, &handle, 1) < 1) return;
  dds_builtintopic_endpoint_t* end = dds_get_matched_subscription_data(writer, handle);
  if (end == NULL) return;
  void* data = NULL;
  size_t size = 0;
  dds_qget_userdata(end->qos, &data, &size);
  printf("%s %s %.*s\n", end->topic_name, end->type_name, (int)size, data ? (const char*)data : "");
  dds_free(data);
  dds_builtintopic_free_endpoint(end);
}

/* Once a reader is there, as `ros2 topic pub --once` does; the time on both sides is for what discovery and UDP need.
 */
static void send(int domain, const dds_topic_descriptor_t* type, const char* name, const void* message) {
  const dds_entity_t participant = check(dds_create_participant((dds_domainid_t)domain, NULL, NULL), "participant");
  const dds_entity_t topic = check(dds_create_topic(participant, type, name, NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
  const dds_entity_t writer = check(dds_create_writer(participant, topic, qos, NULL), name);
  dds_delete_qos(qos);
  dds_publication_matched_status_t matched = {0};
  while (matched.current_count == 0) {
    dds_sleepfor(DDS_MSECS(10));
    check(dds_get_publication_matched_status(writer, &matched), "status");
  }
  dds_sleepfor(DDS_MSECS(300));
  print_reader(writer);
  check(dds_write(writer, message), "write");
  check(dds_wait_for_acks(writer, DDS_SECS(10)), "acknowledgement");
  dds_delete(participant);
}

static int send_trajectory(char** argv) {
  double position = atof(argv[4]), velocity = 0.0;
  const double seconds = atof(argv[5]);
  char* names[] = {argv[3]};
  trajectory_msgs_msg_dds__JointTrajectoryPoint_ point;
  memset(&point, 0, sizeof point);
  point.positions._length = point.velocities._length = 1;
  point.positions._buffer = &position;
  point.velocities._buffer = &velocity;
  point.time_from_start.sec = (int32_t)floor(seconds);
  point.time_from_start.nanosec = (uint32_t)lround((seconds - floor(seconds)) * 1e9);
  trajectory_msgs_msg_dds__JointTrajectory_ message;
  memset(&message, 0, sizeof message);
  message.header.frame_id = (char*)"";
  message.joint_names._length = message.points._length = 1;
  message.joint_names._buffer = names;
  message.points._buffer = &point;
  send(atoi(argv[1]), &trajectory_msgs_msg_dds__JointTrajectory__desc, "rt/joint_trajectory", &message);
  return 0;
}

static int send_positions(int argc, char** argv) {
  double positions[256];
  std_msgs_msg_dds__Float64MultiArray_ message;
  memset(&message, 0, sizeof message);
  message.data._buffer = positions;
  for (int i = 3; i < argc && message.data._length < 256; ++i) positions[message.data._length++] = atof(argv[i]);
  send(atoi(argv[1]), &std_msgs_msg_dds__Float64MultiArray__desc, "rt/position_commands", &message);
  return 0;
}

int main(int argc, char** argv) {
  if (argc == 6 && !strcmp(argv[2], "trajectory")) return send_trajectory(argv);
  if (argc > 3 && !strcmp(argv[2], "positions")) return send_positions(argc, argv);
  return 2;
}

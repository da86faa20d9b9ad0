// SPDX-License-Identifier: BSD-3-Clause
// foreign_controller DOMAIN: a controller that knows nothing of this project but the IDL files: C types as idlc makes
// them and the C interface of Cyclone DDS, no header of ours. It holds the pose of the first sample, counts contact
// forces, and compares the ROS 2 views with the sensor data of the same time. Ends on SIGTERM with one line of counts.
#include <dds/dds.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "control.h"
#include "dynamics.h"
#include "ros_views.h"

enum { kMost = 64, kKept = 4096, kBatch = 64 };

struct Kept {      // of a SensorData sample
  long long time;  // [ns]
  double q[kMost], force[3], torque[3], acceleration[3];
};

static struct Kept kept[kKept];
static long sensor_count, command_count, force_count, joint_view_count, imu_view_count, wrench_view_count, different;
static hrp_msg_JointCommands command;
static double newest_foot_force;  // [N] sum over the points, upwards
static volatile sig_atomic_t stop;

static void note_stop(int signal_number) {
  (void)signal_number;
  stop = 1;
}

static dds_entity_t check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "foreign_controller: %s: %s\n", what, dds_strretcode(entity));
  exit(1);
}

static dds_entity_t make_reader(dds_entity_t participant, const dds_topic_descriptor_t* type, const char* name) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  const dds_entity_t topic = check(dds_create_topic(participant, type, name, NULL, NULL), name);
  const dds_entity_t reader = check(dds_create_reader(participant, topic, qos, NULL), name);
  dds_delete_qos(qos);
  return reader;
}

static void answer(const hrp_msg_SensorData* sensors, dds_entity_t writer) {
  if (command.positions._length == 0) {
    const uint32_t n = sensors->positions._length;
    command.positions._buffer = malloc(n * sizeof(double));
    memcpy(command.positions._buffer, sensors->positions._buffer, n * sizeof(double));
    command.positions._length = command.positions._maximum = n;
  }
  command.header = sensors->header;
  if (dds_write(writer, &command) == DDS_RETCODE_OK) ++command_count;
}

static void keep(const hrp_msg_SensorData* sensors) {
  struct Kept* place = &kept[sensor_count++ % kKept];
  place->time = llround(sensors->header.time * 1e9);
  for (uint32_t i = 0; i < sensors->positions._length && i < kMost; ++i) place->q[i] = sensors->positions._buffer[i];
  if (sensors->wrenches._length > 0) {
    memcpy(place->force, &sensors->wrenches._buffer[0].force, sizeof place->force);
    memcpy(place->torque, &sensors->wrenches._buffer[0].torque, sizeof place->torque);
  }
  if (sensors->imus._length > 0) {
    memcpy(place->acceleration, &sensors->imus._buffer[0].linear_acceleration, sizeof place->acceleration);
  }
}

static const struct Kept* find_kept(const builtin_interfaces_msg_dds__Time_* stamp) {
  const long long time = stamp->sec * 1000000000ll + stamp->nanosec;
  const long count = sensor_count < kKept ? sensor_count : kKept;
  for (long i = 0; i < count; ++i) {
    if (kept[i].time == time) return &kept[i];
  }
  return NULL;
}

static void compare(const char* name, const void* view, const double* expected, uint32_t count, const struct Kept* at) {
  if (memcmp(view, expected, count * sizeof(double)) == 0) return;
  if (different++ > 0) return;
  fprintf(stderr, "%s at %lld ns:", name, at->time);
  for (uint32_t i = 0; i < count; ++i) fprintf(stderr, " %.17g/%.17g", ((const double*)view)[i], expected[i]);
  fprintf(stderr, "\n");
}

static void take_forces(dds_entity_t reader) {
  void* samples[kBatch] = {NULL};
  dds_sample_info_t infos[kBatch];
  const int taken = dds_take(reader, samples, infos, kBatch, kBatch);
  for (int i = 0; i < taken; ++i) {
    const hrp_msg_ContactForces* forces = samples[i];
    if (!infos[i].valid_data) continue;
    ++force_count;
    newest_foot_force = 0.0;
    for (uint32_t pair = 0; pair < forces->pairs._length; ++pair) {
      newest_foot_force += forces->pairs._buffer[pair].total.force.z;
    }
  }
  if (taken > 0) dds_return_loan(reader, samples, taken);
}

static void take_sensors(dds_entity_t reader, dds_entity_t writer) {
  void* samples[kBatch] = {NULL};
  dds_sample_info_t infos[kBatch];
  const int taken = dds_take(reader, samples, infos, kBatch, kBatch);
  for (int i = 0; i < taken; ++i) {
    if (!infos[i].valid_data) continue;
    answer(samples[i], writer);
    keep(samples[i]);
  }
  if (taken > 0) dds_return_loan(reader, samples, taken);
}

// Views are taken before the sensor data that they were made from, which were sent first: so those are there.
static void compare_views(dds_entity_t joints, dds_entity_t imu, dds_entity_t wrench, dds_entity_t sensors,
                          dds_entity_t writer) {
  void *joint_samples[kBatch] = {NULL}, *imu_samples[kBatch] = {NULL}, *wrench_samples[kBatch] = {NULL};
  dds_sample_info_t joint_infos[kBatch], imu_infos[kBatch], wrench_infos[kBatch];
  const int joint_taken = dds_take(joints, joint_samples, joint_infos, kBatch, kBatch);
  const int imu_taken = dds_take(imu, imu_samples, imu_infos, kBatch, kBatch);
  const int wrench_taken = dds_take(wrench, wrench_samples, wrench_infos, kBatch, kBatch);
  take_sensors(sensors, writer);
  for (int i = 0; i < joint_taken; ++i) {
    const sensor_msgs_msg_dds__JointState_* view = joint_samples[i];
    const struct Kept* same = joint_infos[i].valid_data ? find_kept(&view->header.stamp) : NULL;
    if (!same) continue;
    ++joint_view_count;
    compare("joint_states", view->position._buffer, same->q, view->position._length, same);
  }
  for (int i = 0; i < imu_taken; ++i) {
    const sensor_msgs_msg_dds__Imu_* view = imu_samples[i];
    const struct Kept* same = imu_infos[i].valid_data ? find_kept(&view->header.stamp) : NULL;
    if (!same) continue;
    ++imu_view_count;
    compare("imu", &view->linear_acceleration, same->acceleration, 3, same);
  }
  for (int i = 0; i < wrench_taken; ++i) {
    const geometry_msgs_msg_dds__WrenchStamped_* view = wrench_samples[i];
    const struct Kept* same = wrench_infos[i].valid_data ? find_kept(&view->header.stamp) : NULL;
    if (!same) continue;
    ++wrench_view_count;
    compare("force", &view->wrench.force, same->force, 3, same);
    compare("torque", &view->wrench.torque, same->torque, 3, same);
  }
  if (joint_taken > 0) dds_return_loan(joints, joint_samples, joint_taken);
  if (imu_taken > 0) dds_return_loan(imu, imu_samples, imu_taken);
  if (wrench_taken > 0) dds_return_loan(wrench, wrench_samples, wrench_taken);
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  signal(SIGTERM, note_stop);
  const dds_entity_t participant =
      check(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  const dds_entity_t sensors = make_reader(participant, &hrp_msg_SensorData_desc, "hrp/sensor_data");
  const dds_entity_t forces = make_reader(participant, &hrp_msg_ContactForces_desc, "hrp/contact_forces");
  const dds_entity_t joints = make_reader(participant, &sensor_msgs_msg_dds__JointState__desc, "rt/joint_states");
  const dds_entity_t imu = make_reader(participant, &sensor_msgs_msg_dds__Imu__desc, "rt/imu/chest");
  const dds_entity_t wrench =
      make_reader(participant, &geometry_msgs_msg_dds__WrenchStamped__desc, "rt/wrench/left_foot");
  const dds_entity_t topic =
      check(dds_create_topic(participant, &hrp_msg_JointCommands_desc, "hrp/joint_commands", NULL, NULL), "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1024);
  const dds_entity_t writer = check(dds_create_writer(participant, topic, qos, NULL), "writer");
  dds_delete_qos(qos);
  const dds_entity_t waitset = check(dds_create_waitset(participant), "waitset");
  dds_set_status_mask(sensors, DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset, sensors, 0);
  while (!stop) {
    dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(50));
    compare_views(joints, imu, wrench, sensors, writer);
    take_forces(forces);
  }
  take_forces(forces);
  printf("commands %ld forces %ld foot_force %.1f joint_views %ld imu_views %ld wrench_views %ld different %ld\n",
         command_count, force_count, newest_foot_force, joint_view_count, imu_view_count, wrench_view_count, different);
  dds_delete(participant);
  return 0;
}

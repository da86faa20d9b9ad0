/* SPDX-License-Identifier: BSD-3-Clause
 * watch_forces DOMAIN: prints the force on each pair of bodies in contact, ten times a simulated second, until the run
 * ends. Reads best effort, so it never slows the run. CYCLONEDDS_URI names cyclone.xml (docs/client_in_c.md). */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "dynamics.h" /* idlc made it from idl/dynamics.idl */

static void print_forces(const hrp_msg_ContactForces* forces) {
  for (uint32_t i = 0; i < forces->pairs._length; ++i) {
    const hrp_msg_PairForce* pair = &forces->pairs._buffer[i];
    const hrp_msg_Vector3* force = &pair->total.force; /* [N] on body A, world axes, z up */
    printf("t = %6.3f s   %s on %s   %8.2f %8.2f %8.2f N\n", forces->header.time, pair->name_b, pair->name_a, force->x,
           force->y, force->z);
  }
  fflush(stdout);
}

/* The writer was there, and is gone: the run has ended. */
static int has_ended(dds_entity_t reader) {
  dds_subscription_matched_status_t status;
  dds_get_subscription_matched_status(reader, &status);
  return status.total_count > 0 && status.current_count == 0;
}

int main(int argc, char** argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: watch_forces DOMAIN\n");
    return 2;
  }
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  const dds_entity_t topic =
      dds_create_topic(participant, &hrp_msg_ContactForces_desc, "hrp/contact_forces", NULL, NULL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 64);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  if (reader < 0) {
    fprintf(stderr, "watch_forces: %s\n", dds_strretcode(reader));
    return 1;
  }
  while (!has_ended(reader)) {
    enum { kBatch = 16 };
    void* samples[kBatch] = {NULL};
    dds_sample_info_t infos[kBatch];
    const int taken = dds_take(reader, samples, infos, kBatch, kBatch);
    for (int i = 0; i < taken; ++i) {
      const hrp_msg_ContactForces* forces = samples[i];
      if (infos[i].valid_data && forces->header.step % 100 == 0) print_forces(forces);
    }
    if (taken > 0) dds_return_loan(reader, samples, taken);
    if (taken <= 0) dds_sleepfor(DDS_MSECS(2));
  }
  dds_delete(participant);
  return 0;
}

/* SPDX-License-Identifier: BSD-3-Clause
 * ros_caller DOMAIN GUID CALL: calls a service of a run as rmw_cyclonedds does, with idlc's types and nothing of ours.
 * GUID is what the client puts into its requests; replies to others are passed over. CALL: pause, go, resume, step or
 * reset. Prints end TOPIC TYPE USER_DATA      of both ends of the server reply SUCCESS MESSAGE         or "silence"
 * after two seconds without a reply */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rmw_cyclonedds.h"

typedef std_srvs_srv_dds__SetBool_Response_ Reply; /* that of Trigger has the same fields */

static dds_entity_t check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "ros_caller: %s: %s\n", what, dds_strretcode(entity));
  exit(1);
}

static void print_end(dds_builtintopic_endpoint_t* end) {
  void* data = NULL;
  size_t size = 0;
  if (end == NULL) return;
  dds_qget_userdata(end->qos, &data, &size);
  printf("end %s %s %.*s\n", end->topic_name, end->type_name, (int)size, data ? (const char*)data : "");
  dds_free(data);
  dds_builtintopic_free_endpoint(end);
}

/* As rmw_service_server_is_available(): both ends are there. */
static void wait_for_server(dds_entity_t writer, dds_entity_t reader) {
  dds_instance_handle_t handle;
  while (dds_get_matched_subscriptions(writer, &handle, 1) < 1) dds_sleepfor(DDS_MSECS(10));
  print_end(dds_get_matched_subscription_data(writer, handle));
  while (dds_get_matched_publications(reader, &handle, 1) < 1) dds_sleepfor(DDS_MSECS(10));
  print_end(dds_get_matched_publication_data(reader, handle));
  dds_sleepfor(DDS_MSECS(300)); /* the other side must know us, too */
}

static void await_reply(dds_entity_t reader, uint64_t guid, int64_t seq) {
  for (int i = 0; i < 200; ++i) {
    void* sample = NULL;
    dds_sample_info_t info;
    while (dds_take(reader, &sample, &info, 1, 1) == 1) {
      const Reply* reply = sample;
      if (info.valid_data && reply->guid == guid && reply->seq == seq) {
        printf("reply %d %s\n", reply->success, reply->message);
        return;
      }
      dds_return_loan(reader, &sample, 1);
      sample = NULL;
    }
    dds_sleepfor(DDS_MSECS(10));
  }
  printf("silence\n");
}

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const int go = !strcmp(argv[3], "go"), sets = go || !strcmp(argv[3], "pause");
  char asked[64], answered[64];
  snprintf(asked, sizeof asked, "rq/run/%sRequest", go ? "pause" : argv[3]);
  snprintf(answered, sizeof answered, "rr/run/%sReply", go ? "pause" : argv[3]);
  const dds_topic_descriptor_t* request_type =
      sets ? &std_srvs_srv_dds__SetBool_Request__desc : &std_srvs_srv_dds__Trigger_Request__desc;
  const dds_topic_descriptor_t* reply_type =
      sets ? &std_srvs_srv_dds__SetBool_Response__desc : &std_srvs_srv_dds__Trigger_Response__desc;
  const dds_entity_t participant =
      check(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  dds_qos_t* qos = dds_create_qos(); /* rmw_qos_profile_services_default */
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  const dds_entity_t writer =
      check(dds_create_writer(participant, check(dds_create_topic(participant, request_type, asked, NULL, NULL), asked),
                              qos, NULL),
            asked);
  const dds_entity_t reader = check(
      dds_create_reader(participant, check(dds_create_topic(participant, reply_type, answered, NULL, NULL), answered),
                        qos, NULL),
      answered);
  dds_delete_qos(qos);
  wait_for_server(writer, reader);
  const std_srvs_srv_dds__SetBool_Request_ request = {strtoull(argv[2], NULL, 10), 7,
                                                      !go}; /* a Trigger's byte may be anything */
  check(dds_write(writer, &request), "write");
  await_reply(reader, request.guid, request.seq);
  dds_delete(participant);
  return 0;
}

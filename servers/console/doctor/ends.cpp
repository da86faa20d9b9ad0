// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/doctor/ends.h"

#include <map>
#include <set>

#include "common/base/diagnostics.h"
#include "common/base/printable.h"
#include "common/messages/ros_topics.h"

namespace hrp {
namespace {

std::string name_end(const EndSeen& end) {
  return std::string("a ") + (end.writer ? "writer" : "reader") + " of " + make_printable_line(end.topic) + " (" +
         end.vendor + ", participant " + end.participant + ")";
}

std::string find_mismatch(const EndSeen& reader, const EndSeen& writer) {
  if (reader.reliable && !writer.reliable) return "the reader is RELIABLE, the writer is BEST_EFFORT";
  if (reader.transient_local && !writer.transient_local) return "the reader is TRANSIENT_LOCAL, the writer is VOLATILE";
  return "";
}

// One line a topic and mismatch, however many ends have it.
void add_once(std::set<std::string>* said, const std::string& key, Finding finding, Findings* findings) {
  if (said->insert(key).second) findings->push_back(std::move(finding));
}

const char kQosMend[] = "writers RELIABLE; readers TRANSIENT_LOCAL only where history is \"last\" (idl/README.md)";

bool misses_last(const EndSeen& end) {
  const TopicSpec* known = topics::find_any_topic(end.topic);
  return !end.writer && known && known->retention == Retention::kLatest && !(end.reliable && end.transient_local);
}

std::vector<std::string> list_our_names() {
  std::vector<std::string> names;
  for (const char* name :
       {"robot_description", "model_refused", "robot_state", "sensor_data", "contact_set", "contact_forces", "events",
        "joint_commands", "server_status", "step_grant", "run_control", "run_status", "view"}) {
    names.push_back(std::string("hrp/") + name);
  }
  return names;
}

}  // namespace

Finding judge_participants(const std::vector<EndSeen>& ends, bool expected) {
  std::map<std::string, std::set<std::string>> by_vendor;
  for (const EndSeen& end : ends) by_vendor[end.vendor].insert(end.participant);
  std::string text;
  for (const auto& [vendor, participants] : by_vendor) {
    text += (text.empty() ? "" : ", ") + std::to_string(participants.size()) + " of " + vendor;
  }
  if (!text.empty()) return make_ok("discovery", "sees participants: " + text);
  if (!expected) return make_ok("discovery", "nobody is in this domain");
  return make_problem("discovery", "the run holds its domain, but nobody is seen there",
                      "the run ends or hangs: build/bin/hrp-run list, then look at its terminal");
}

Findings judge_qos(const std::vector<EndSeen>& ends) {
  Findings findings;
  std::set<std::string> said;
  for (const EndSeen& reader : ends) {
    if (reader.writer) continue;
    for (const EndSeen& writer : ends) {
      if (!writer.writer || writer.topic != reader.topic || writer.participant == reader.participant) continue;
      const std::string mismatch = find_mismatch(reader, writer);
      if (mismatch.empty()) continue;
      add_once(
          &said, reader.topic + mismatch,
          make_problem("qos", make_printable_line(reader.topic) + ": " + mismatch + ", so they do not match", kQosMend),
          &findings);
    }
    if (misses_last(reader)) {
      add_once(&said, reader.topic + "last",
               make_problem("qos", name_end(reader) + " does not get what was sent before it came",
                            "make it RELIABLE and TRANSIENT_LOCAL"),
               &findings);
    }
  }
  if (findings.empty()) findings.push_back(make_ok("qos", "every reader asks for what its writers offer"));
  return findings;
}

Findings judge_types(const std::vector<EndSeen>& ends) {
  Findings findings;
  std::set<std::string> said;
  std::map<std::string, std::string> types;
  for (const EndSeen& end : ends) {
    const TopicSpec* known = topics::find_any_topic(end.topic);
    const std::string& expected = types.emplace(end.topic, known ? known->type_name : end.type_name).first->second;
    if (end.type_name == expected) continue;
    add_once(&said, end.topic + end.type_name,
             make_problem("types",
                          name_end(end) + " has the type " + make_printable_line(end.type_name) + ", not " +
                              make_printable_line(expected),
                          "generate its types from idl/ (build/bin/hrp-topic type " +
                              expected.substr(expected.rfind(':') + 1) + ")"),
             &findings);
  }
  if (findings.empty()) findings.push_back(make_ok("types", "every topic has one type"));
  return findings;
}

Findings judge_names(const std::vector<EndSeen>& ends) {
  Findings findings;
  std::set<std::string> said;
  for (const EndSeen& end : ends) {
    if (topics::find_any_topic(end.topic)) continue;
    const std::string ros_topic = topics::find_ros_topic(end.topic),
                      plain = ros_topic.empty() ? end.topic : ros_topic.substr(1);
    std::string nearest = find_nearest(plain, list_our_names());
    if (nearest.empty()) nearest = find_nearest("hrp/" + plain, list_our_names());
    if (nearest.empty()) continue;
    add_once(&said, end.topic, make_problem("names", name_end(end) + " meets nobody of ours", "is it " + nearest + "?"),
             &findings);
  }
  if (findings.empty()) findings.push_back(make_ok("names", "no topic is misspelt"));
  return findings;
}

}  // namespace hrp

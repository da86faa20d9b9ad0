// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/viewer.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "common/base/diagnostics.h"
#include "common/mcap/reader.h"
#include "common/messages/logged_description.h"
#include "common/messages/reflection/sample.h"
#include "common/messages/topics.h"
#include "common/node/run_token.h"
#include "servers/viewer/access.h"
#include "servers/viewer/dump_json.h"
#include "servers/viewer/foxglove_client.h"
#include "servers/viewer/page_client.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Which topics there are changes rarely; asking costs a walk through the discovery.
constexpr auto kRefreshPeriod = std::chrono::milliseconds(500);
// Real-time factor from which on a run is limited by the machine, not paced for people. Its servers then report a
// hundred times a second and more, reliably: the one figure of interest, who is late, is in the scheduler's word, too.
constexpr double kFast = 3.0;
constexpr auto kPeekTime = std::chrono::seconds(5);
// A logger that closes a large file takes some time after the end of the run.
constexpr auto kLogPatience = std::chrono::seconds(8);

const char kNobodyListens[] =
    "{\"op\":\"error\",\"message\":\"no scheduler listens: the run is over or has not begun\",\"id\":-1}";

Bytes get_bytes(const SampleBytes& sample) { return {sample.data(), sample.size()}; }

std::string get_kind(const Field& field) {
  if (field.type.structure) return field.type.structure->name;
  if (field.type.kind == ValueKind::kString) return "string";
  if (field.type.enumeration) return "enum";
  return field.type.kind == ValueKind::kBool ? "bool" : "number";
}

// Fields and units of all our types, for the list of signals.
Json make_types() {
  Json types = Json::object();
  for (const std::string& name : get_schema().find_struct_names()) {
    Json fields = Json::array();
    for (const Field& field : get_schema().find_struct(name)->fields) {
      fields.push_back(
          {{"name", field.name}, {"type", get_kind(field)}, {"list", field.type.is_list()}, {"unit", field.unit}});
    }
    types[name] = fields;
  }
  return types;
}

const char* find_content_type(const std::string& path) {
  const std::string ending = fs::path(path).extension().string();
  if (ending == ".html") return "text/html; charset=utf-8";
  if (ending == ".js") return "text/javascript; charset=utf-8";
  if (ending == ".css") return "text/css; charset=utf-8";
  if (ending == ".svg") return "image/svg+xml";
  return "text/plain; charset=utf-8";
}

// "run.mcap" of epoch 2 is "run.2.mcap".
std::string find_log_of_epoch(const std::string& log, uint64_t epoch) {
  const fs::path path(log);
  const fs::path later =
      path.parent_path() / (path.stem().string() + "." + std::to_string(epoch) + path.extension().string());
  return epoch > 0 && fs::exists(later) ? later.string() : log;
}

bool is_closed_log(const std::string& path) {
  try {
    return mcap::Reader(path).indexed();
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

Viewer::~Viewer() = default;

void Viewer::show(std::vector<std::unique_ptr<Recording>> recordings) {
  recordings_ = std::move(recordings);
  if (recordings_.empty()) return;
  const auto topic = recordings_[0]->topics().find(topics::kRobotDescription.name);
  if (topic == recordings_[0]->topics().end() || topic->second.samples.empty()) return;
  try {
    msg::RobotDescription description;
    decode_logged(topic->second.samples.front().get(), &description);
    foxglove_scene_.set_robot(description);
  } catch (const DecodeError&) {
    // A log of another version: its topics are there all the same.
  }
}

std::unique_ptr<Client> Viewer::make_page_client(Connection& connection) {
  return std::make_unique<PageClient>(connection, *this);
}

std::unique_ptr<Client> Viewer::make_foxglove_client(Connection& connection) {
  return std::make_unique<FoxgloveClient>(connection, *this);
}

std::optional<WebFile> Viewer::find_file(const std::string& target) {
  const std::string path = target.substr(0, target.find('?'));
  if (path == "/mesh") {
    const std::string source = find_query_value(target, "source");
    const bool number =
        !source.empty() && source.size() < 6 && source.find_first_not_of("0123456789") == std::string::npos;
    const Scene* scene = number ? find_scene(std::stoul(source)) : nullptr;
    const Scene* robot = scene ? find_robot_scene(*scene, find_query_value(target, "robot")) : nullptr;
    return robot ? read_mesh(*robot, find_query_value(target, "file")) : std::nullopt;
  }
  // The page is a flat folder: a name with a slash or a dot in front is none of its files.
  const std::string name = path == "/" ? "index.html" : path.substr(1);
  if (name.empty() || name[0] == '.' || name.find_first_of("/\\%") != std::string::npos) return std::nullopt;
  std::ifstream file(fs::path(options_.page_folder) / name, std::ios::binary);
  if (!file) {
    if (name != "index.html") return std::nullopt;
    return WebFile{
        "<!doctype html><title>openhrp-dds</title><p>The page has not been built. Run "
        "<code>scripts/build_page.sh</code>.",
        find_content_type(name)};
  }
  std::ostringstream content;
  content << file.rdbuf();
  return WebFile{content.str(), find_content_type(name)};
}

const Scene* Viewer::find_scene(size_t source) const {
  if (live_) return source == 0 ? &scene_ : nullptr;
  return source < recordings_.size() ? &recordings_[source]->scene() : nullptr;
}

std::string Viewer::make_hello() const {
  static const std::string types = make_types().dump();
  std::string text = std::string("{\"op\":\"hello\",\"live\":") + (live_ ? "true" : "false") +
                     ",\"control\":" + (live_ && live_->has_control() ? "true" : "false") + ",\"types\":" + types +
                     ",\"topics\":" + dump_json(find_topics()) + ",\"recordings\":[";
  for (size_t i = 0; i < recordings_.size() && !live_; ++i) {
    const Recording& recording = *recordings_[i];
    text += (i ? ",{" : "{") + std::string("\"name\":") + dump_json(recording.name()) +
            ",\"begin\":" + Json(recording.begin()).dump() + ",\"end\":" + Json(recording.end()).dump() +
            ",\"notes\":" + dump_json(recording.notes()) + "}";
  }
  return text + "]}";
}

void Viewer::send_present(Connection& connection) const {
  if (!live_) return;
  const auto send = [&](const std::string& text) {
    if (!text.empty()) connection.send(make_payload(text), false, Urgency::kNeeded);
  };
  if (!scene_.json.empty()) send("{\"op\":\"scene\",\"source\":0,\"scene\":" + scene_.json + "}");
  send(status_);
  send(frame_);
}

std::map<std::string, std::string> Viewer::find_topics() const {
  if (live_) return live_topics_;
  std::map<std::string, std::string> found;
  if (recordings_.empty()) return found;
  for (const auto& [name, topic] : recordings_[0]->topics()) found[name] = topic.type->name;
  if (recordings_[0]->pictures()) found.merge(recordings_[0]->pictures()->topics());
  return found;
}

std::string Viewer::find_schema(const std::string& topic) const {
  if (!live_) {
    const auto recorded = recordings_.empty() ? nullptr : &recordings_[0]->topics();
    return recorded && recorded->count(topic) ? recorded->at(topic).schema_text : "";
  }
  const auto found = live_topics_.find(topic);
  return found == live_topics_.end() ? "" : find_schema_text(found->second);
}

void Viewer::peek(const std::string& topic) {
  if (live_ && live_topics_.count(topic) && !is_picture_topic(topic)) peeks_[topic] = Clock::now() + kPeekTime;
}

void Viewer::tick() {
  send_pictures();
  if (!live_) return;
  if (Clock::now() >= next_refresh_) refresh_topics();
  if (live_->send_requests()) send_pages(kNobodyListens, Urgency::kNeeded);
  update_readers();
  const std::map<std::string, Arrivals> arrivals = live_->take();
  const auto description = arrivals.find(topics::kRobotDescription.name);
  if (description != arrivals.end() && description->second.fresh) take_description(description->second);
  take_status(arrivals);
  send_samples(arrivals);
  send_frame(arrivals);
  send_foxglove(arrivals);
  watch_end();
}

void Viewer::refresh_topics() {
  next_refresh_ = Clock::now() + kRefreshPeriod;
  auto found = live_->find_topics();
  if (found == live_topics_) return;
  live_topics_ = std::move(found);
  send_pages("{\"op\":\"topics\",\"topics\":" + dump_json(live_topics_) + "}", Urgency::kNeeded);
  for (FoxgloveClient* client : foxgloves_) client->advertise();
}

void Viewer::update_readers() {
  std::set<std::string> wanted{topics::kRobotDescription.name, topics::kRunStatus.name};
  std::set<std::string> whole;
  reads_servers_ = run_status_.phase() != msg::RUN_RUNNING || run_status_.real_time_factor() < kFast;
  if (reads_servers_) whole.insert(topics::kServerStatus.name);
  if (!pages_.empty()) wanted.insert({topics::kRobotState.name, topics::kContactForces.name});
  const auto now = Clock::now();
  for (auto peek = peeks_.begin(); peek != peeks_.end();) {
    if (peek->second < now) {
      peek = peeks_.erase(peek);
    } else {
      wanted.insert((peek++)->first);
    }
  }
  for (PageClient* page : pages_) {
    for (const std::string& signal : page->signals()) {
      const std::string topic = signal.substr(0, signal.find(':'));
      if (!is_picture_topic(topic)) wanted.insert(topic);
    }
  }
  for (const auto& [topic, type] : live_topics_) {
    if (!is_picture(type) && reads_foxglove(topic)) whole.insert(topic);
  }
  // Pictures need no sample of each step.
  for (const FoxgloveScene::Channel& channel : FoxgloveScene::channels()) {
    if (reads_foxglove(channel.topic)) wanted.insert(channel.source);
  }
  wanted.insert(whole.begin(), whole.end());
  live_->read_topics(wanted, whole);
  read_pictures();
}

void Viewer::take_description(const Arrivals& arrivals) {
  if (arrivals.latest == description_) return;
  description_ = arrivals.latest;
  msg::RobotDescription description;
  try {
    decode(get_bytes(arrivals.latest), &description);
  } catch (const DecodeError&) {
    return;
  }
  scene_ = make_scene(description);
  foxglove_scene_.set_robot(description);
  signals_.clear();
  send_pages("{\"op\":\"scene\",\"source\":0,\"scene\":" + scene_.json + "}", Urgency::kNeeded);
}

void Viewer::take_run_status(const Arrivals& arrivals) {
  msg::RunStatus status;
  decode(get_bytes(arrivals.latest), &status);
  if (!live_->believes(run_status_, status)) return;
  run_status_ = status;
  run_text_ = print_json(*arrivals.type, get_bytes(arrivals.latest));
}

void Viewer::take_status(const std::map<std::string, Arrivals>& arrivals) {
  const Arrivals& run = arrivals.at(topics::kRunStatus.name);
  const auto server = arrivals.find(topics::kServerStatus.name);
  const bool news = server != arrivals.end() && server->second.fresh;
  if (!run.fresh && !news) return;
  try {
    const std::vector<SampleBytes> reports = news ? server->second.all : std::vector<SampleBytes>();
    for (const SampleBytes& sample : reports) {
      msg::ServerStatus status;
      decode(get_bytes(sample), &status);
      if (!status.file().empty() && fs::path(status.file()).parent_path() == fs::path(options_.log_after).parent_path())
        log_file_ = status.file();
      servers_[status.server()] = print_json(*server->second.type, get_bytes(sample));
    }
    if (run.fresh) take_run_status(run);
    std::string text = "{\"op\":\"status\",\"run\":" + run_text_;
    text += std::string(",\"servers_now\":") + (reads_servers_ ? "true" : "false") + ",\"servers\":{";
    for (const auto& [role, json] : servers_) text += (text.back() == '{' ? "" : ",") + dump_json(role) + ":" + json;
    status_ = text + "}}";
  } catch (const DecodeError&) {
    return;
  }
  send_pages(status_, Urgency::kDroppable);
}

// {"op":"samples","epoch":0,"signals":{"topic:path":{"times":[...],"values":[...],"unit":"N"}}} or {"error":...}
void Viewer::send_samples(const std::map<std::string, Arrivals>& arrivals) {
  std::set<std::string> wanted;
  for (PageClient* page : pages_) wanted.insert(page->signals().begin(), page->signals().end());
  for (auto each = signals_.begin(); each != signals_.end();)
    each = wanted.count(each->first) ? std::next(each) : signals_.erase(each);
  Json json = Json::object();
  for (const std::string& text : wanted) {
    try {
      const SignalName name = split_signal(text);
      const auto found = arrivals.find(name.topic);
      if (found == arrivals.end()) continue;
      const Arrivals& topic = found->second;
      std::unique_ptr<Signal>& signal = signals_[text];
      if (!signal) signal = std::make_unique<Signal>(*topic.type, name.path, scene_.joints, scene_.ground_height);
      if (topic.thinned.empty()) continue;
      const SampleTime time(*topic.type);
      Json times = Json::array(), values = Json::array();
      for (const SampleBytes& sample : topic.thinned) {
        const double value = time.known() ? signal->find(get_bytes(sample)) : kNoValue;
        times.push_back(time.find(get_bytes(sample)));
        values.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
      }
      json[text] = {{"times", times}, {"values", values}, {"unit", signal->unit()}};
    } catch (const std::exception& error) {
      // A name that makes no sense, or a sample that cannot be read: said at the chart, nothing else suffers.
      json[text] = {{"error", error.what()}};
    }
  }
  if (json.empty()) return;
  send_pages(dump_json({{"op", "samples"}, {"epoch", run_status_.epoch()}, {"signals", json}}), Urgency::kDroppable);
}

void Viewer::send_frame(const std::map<std::string, Arrivals>& arrivals) {
  std::string text = "{\"op\":\"frame\",\"topics\":{";
  bool fresh = false, first = true;
  for (const auto& [name, topic] : arrivals) {
    const bool own =
        name == topics::kRobotDescription.name || name == topics::kServerStatus.name || name == topics::kRunStatus.name;
    if (own || topic.latest.empty()) continue;
    fresh = fresh || topic.fresh;
    try {
      text += (first ? "\"" : ",\"") + name + "\":" + print_json(*topic.type, get_bytes(topic.latest));
      first = false;
    } catch (const DecodeError&) {
    }
  }
  if (!fresh) return;
  frame_ = text + "}}";
  send_pages(frame_, Urgency::kDroppable);
}

void Viewer::send_pages(const std::string& text, Urgency urgency) {
  if (pages_.empty()) return;
  const Payload payload = make_payload(text);
  // A page that is cut off leaves the set.
  const std::set<PageClient*> pages = pages_;
  for (PageClient* page : pages) page->connection().send(payload, false, urgency);
}

// When the run is over and its log is known, the page goes on with the log.
void Viewer::watch_end() {
  if (!is_over(run_status_) || options_.log_after.empty()) return;
  if (over_since_ == Clock::time_point{}) over_since_ = Clock::now();
  // The logger says where it writes: another name than the usual one if that was taken.
  const std::string log =
      fs::exists(log_file_) ? log_file_ : find_log_of_epoch(options_.log_after, run_status_.epoch());
  if (!is_closed_log(log) && Clock::now() - over_since_ < kLogPatience) return;
  try {
    std::vector<std::unique_ptr<Recording>> recordings;
    recordings.push_back(read_log(log));
    show(std::move(recordings));
  } catch (const std::exception&) {
    options_.log_after.clear();  // there is none: the last picture stays
    return;
  }
  live_.reset();
  payloads_.clear();
  for (PageClient* page : pages_) page->pictures().forget();
  for (FoxgloveClient* client : foxgloves_) client->pictures().forget();
  send_pages(make_hello(), Urgency::kNeeded);
}

}  // namespace hrp

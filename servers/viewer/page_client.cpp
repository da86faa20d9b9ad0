// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/page_client.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "common/base/diagnostics.h"
#include "common/messages/convert.h"
#include "servers/viewer/dump_json.h"

namespace hrp {
namespace {

using Json = nlohmann::json;

constexpr size_t kMostSignals = 64;
constexpr size_t kMostPictures = 16;
constexpr size_t kLongestSignal = 256;
constexpr double kMostSteps = 1e6;

double get_number(const Json& request, const char* key, double otherwise) {
  const auto found = request.find(key);
  return found != request.end() && found->is_number() ? found->get<double>() : otherwise;
}

std::string get_text(const Json& request, const char* key) {
  const auto found = request.find(key);
  return found != request.end() && found->is_string() ? found->get<std::string>() : "";
}

// A list of at most so many names. Throws ProtocolError.
std::set<std::string> get_names(const Json& request, const char* key, size_t most) {
  const auto list = request.find(key);
  if (list == request.end() || !list->is_array() || list->size() > most) {
    throw ProtocolError("expected at most " + std::to_string(most) + " " + key);
  }
  std::set<std::string> names;
  for (const Json& name : *list) {
    if (!name.is_string() || name.get_ref<const std::string&>().size() > kLongestSignal)
      throw ProtocolError(std::string("expected names of ") + key);
    names.insert(name.get<std::string>());
  }
  return names;
}

// Three finite numbers. Throws ProtocolError.
msg::Vector3 get_vector(const Json& request, const char* key) {
  const auto list = request.find(key);
  const bool good = list != request.end() && list->is_array() && list->size() == 3 &&
                    std::all_of(list->begin(), list->end(), [](const Json& value) {
                      return value.is_number() && std::isfinite(value.get<double>());
                    });
  if (!good) throw ProtocolError(std::string("expected three numbers as ") + key);
  return to_message(Vector3d((*list)[0].get<double>(), (*list)[1].get<double>(), (*list)[2].get<double>()));
}

// Times to the nanosecond, values exact: what the page shows is what was recorded.
Json make_series(const Series& series) {
  Json times = Json::array(), values = Json::array();
  for (size_t i = 0; i < series.times.size(); ++i) {
    times.push_back(series.times[i]);
    values.push_back(series.values[i]);
  }
  return {{"times", times}, {"values", values}, {"unit", series.unit}};
}

// Only what lies within the times that a chart shows, so that zooming in shows every sample.
Series cut_out(const Series& series, double begin, double end) {
  Series cut;
  cut.unit = series.unit;
  for (size_t i = 0; i < series.times.size(); ++i) {
    if (series.times[i] < begin || series.times[i] > end) continue;
    cut.times.push_back(series.times[i]);
    cut.values.push_back(series.values[i]);
  }
  return cut;
}

}  // namespace

PageClient::PageClient(Connection& connection, Viewer& viewer) : connection_(connection), viewer_(viewer) {
  viewer_.join(this);
  answer(viewer_.make_hello());
  viewer_.send_present(connection_);
}

PageClient::~PageClient() { viewer_.leave(this); }

void PageClient::answer(const std::string& text) { connection_.send(make_payload(text), false, Urgency::kNeeded); }

void PageClient::answer_error(const std::string& text, int64_t id) {
  answer(dump_json({{"op", "error"}, {"message", text}, {"id", id}}));
}

void PageClient::on_message(const std::string& message, bool binary) {
  const Json request = binary ? Json() : Json::parse(message, nullptr, false);
  if (!request.is_object()) throw ProtocolError("expected a JSON object");
  const std::string op = get_text(request, "op");
  if (op == "open") return open(request);
  if (op == "subscribe") return subscribe(request);
  if (op == "pictures") return show_pictures(request);
  if (op == "control") return control(request);
  if (op == "push") return push(request);
  if (op == "at") return go_to(request);
  if (op == "series") return send_series(request);
  if (op == "peek") return viewer_.peek(get_text(request, "topic"));
  throw ProtocolError("unknown op '" + op + "'");
}

void PageClient::open(const Json& request) {
  const double source = get_number(request, "source", -1);
  // A larger number has no size_t. A live run is source 0, without recordings.
  const bool possible = source >= 0 && source <= static_cast<double>(viewer_.recordings().size());
  const Scene* scene = possible ? viewer_.find_scene(static_cast<size_t>(source)) : nullptr;
  if (!scene || scene->json.empty()) return answer_error("there is no such recording, or no robot in it", -1);
  answer("{\"op\":\"scene\",\"source\":" + std::to_string(static_cast<size_t>(source)) + ",\"scene\":" + scene->json +
         "}");
}

void PageClient::subscribe(const Json& request) { signals_ = get_names(request, "signals", kMostSignals); }

// {"op":"pictures","topics":["rt/head/image_raw"]}: those that are on the screen, and no others.
void PageClient::show_pictures(const Json& request) {
  picture_topics_ = get_names(request, "topics", kMostPictures);
  update_pictures();
  pictures_.forget();  // the page has forgotten what it had
}

void PageClient::update_pictures() {
  std::set<PictureKey> keys;
  for (const size_t source : sources_) {
    for (const std::string& topic : picture_topics_) keys.insert({source, topic});
  }
  pictures_.show(keys);
}

void PageClient::control(const Json& request) {
  const std::string word = get_text(request, "request");
  msg::RunControl control;
  if (word == "run")
    control.request(msg::REQUEST_RUN);
  else if (word == "pause")
    control.request(msg::REQUEST_PAUSE);
  else if (word == "step")
    control.request(msg::REQUEST_STEP);
  else if (word == "reset")
    control.request(msg::REQUEST_RESET);
  else
    throw ProtocolError("unknown request '" + word + "'");
  const double steps = get_number(request, "steps", 1), speed = get_number(request, "speed", 0);
  if (!(steps >= 1 && steps <= kMostSteps) || !(speed >= 0 && std::isfinite(speed)))
    throw ProtocolError("steps or speed out of range");
  control.steps(static_cast<uint64_t>(steps));
  control.speed(speed);
  control.change_speed(request.find("speed") != request.end());
  send(control);
}

// {"op":"push","link":"CHEST","point":[0,0,0.1],"force":[50,0,0],"steps":200}: what that is stands in msg::Push.
void PageClient::push(const Json& request) {
  msg::RunControl control;
  control.request(msg::REQUEST_PUSH);
  control.push().link(get_text(request, "link"));
  control.push().p_LQ(get_vector(request, "point"));
  control.push().force(get_vector(request, "force"));
  const double steps = get_number(request, "steps", 0);
  if (!(steps >= 0 && steps <= kMostSteps)) throw ProtocolError("steps out of range");
  control.push().steps(static_cast<uint64_t>(steps));
  send(control);
}

void PageClient::send(const msg::RunControl& control) {
  if (!viewer_.live()) return answer_error("this is a recording: there is no run to steer", -1);
  if (!viewer_.live()->has_control()) return answer_error("run control is switched off (--read-only)", -1);
  viewer_.live()->request(control);
}

// {"op":"at","time":...,"sources":[0,1],"steps":0}: time counts from the begin of each recording, so that two of them
// stand side by side; `steps` moves by samples of the first one.
void PageClient::go_to(const Json& request) {
  const auto& recordings = viewer_.recordings();
  std::vector<size_t> sources;
  const auto named = request.find("sources");
  if (named != request.end() && named->is_array()) {
    for (const Json& source : *named) {
      if (source.is_number_unsigned() && source.get<size_t>() < recordings.size() && sources.size() < 2)
        sources.push_back(source);
    }
  }
  if (sources.empty()) return answer_error("there is no such recording", -1);
  double time = get_number(request, "time", 0);
  const double steps = std::clamp(get_number(request, "steps", 0), -kMostSteps, kMostSteps);
  const Recording& first = *recordings[sources[0]];
  if (steps != 0) time = first.find_step(first.begin() + time, static_cast<int>(steps)) - first.begin();
  std::string text = "{\"op\":\"frames\",\"time\":" + Json(time).dump() + ",\"frames\":[";
  for (size_t i = 0; i < sources.size(); ++i) {
    const Recording& recording = *recordings[sources[i]];
    text += (i ? "," : "") + recording.make_frame(recording.begin() + time);
  }
  answer(text + "]}");
  sources_ = sources;
  time_ = time;
  update_pictures();
  viewer_.show_time(first.begin() + time);
}

void PageClient::send_series(const Json& request) {
  const int64_t id = static_cast<int64_t>(std::clamp(get_number(request, "id", 0), -1e15, 1e15));
  const auto& recordings = viewer_.recordings();
  const double source = get_number(request, "source", -1), minus = get_number(request, "minus", -1);
  const double most = static_cast<double>(recordings.size());
  if (!(source >= 0 && source < most) || minus >= most) return answer_error("there is no such recording", id);
  const std::string signal = get_text(request, "signal");
  const size_t points = static_cast<size_t>(std::clamp(get_number(request, "points", 2000), 2.0, 20000.0));
  try {
    const Recording& recording = *recordings[static_cast<size_t>(source)];
    Series series = recording.find_series(signal);
    if (minus >= 0) {
      const Recording& other = *recordings[static_cast<size_t>(minus)];
      series = subtract(series, recording.begin(), other.find_series(signal), other.begin());
    }
    for (double& time : series.times) time -= recording.begin();
    series = thin_out(cut_out(series, get_number(request, "begin", -1e300), get_number(request, "end", 1e300)), points);
    Json json = make_series(series);
    json["op"] = "series";
    json["id"] = id;
    answer(dump_json(json));
  } catch (const InputError& error) {
    answer_error(error.what(), id);
  }
}

}  // namespace hrp

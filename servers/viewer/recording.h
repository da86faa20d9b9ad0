// SPDX-License-Identifier: BSD-3-Clause
// A run that is over, in memory: for every topic its samples in the order of time.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/messages/reflection/schema.h"
#include "servers/viewer/picture_log.h"
#include "servers/viewer/scene.h"
#include "servers/viewer/signal.h"

namespace hrp {

struct Series {
  std::vector<double> times;  // [s]
  std::vector<double> values;
  std::string unit;
};

// At most `most` points that look the same: of each stretch of time the smallest and the largest value stay, so that
// peaks do. Points without a value are left out.
Series thin_out(const Series& series, size_t most);

class Recording {
 public:
  struct Sample {
    double time = 0.0;  // [s] simulated (recordings of others: their own clock)
    std::vector<uint8_t> bytes;
    Bytes get() const { return {bytes.data(), bytes.size()}; }
  };
  struct Topic {
    const StructType* type = nullptr;
    std::string schema_text;
    std::vector<Sample> samples;
  };

  explicit Recording(std::string name) : name_(std::move(name)) {}

  // Building: schemas live as long as the recording. add() keeps the memory within bounds by leaving out every second
  // sample of all topics when there is too much.
  const StructType* add_schema(const std::string& text, const std::string& type_name);
  void add_topic(const std::string& topic, const StructType* type, const std::string& schema_text);
  void add(const std::string& topic, double time, Bytes sample);
  void add_note(const std::string& note) { notes_.push_back(note); }
  void set_scene(Scene scene) { scene_ = std::move(scene); }
  void set_pictures(std::unique_ptr<PictureLog> pictures) { pictures_ = std::move(pictures); }
  // After the last sample: notes, first and last time.
  void finish();

  const std::string& name() const { return name_; }
  const Scene& scene() const { return scene_; }
  const std::vector<std::string>& notes() const { return notes_; }
  const std::map<std::string, Topic>& topics() const { return topics_; }
  // nullptr when there are none.
  PictureLog* pictures() const { return pictures_.get(); }
  double begin() const { return begin_; }
  double end() const { return end_; }

  // {"time":...,"topics":{topic: message}}: of each topic the last sample that is not after `time`. Lists of numbers
  // and names as they were recorded, exactly.
  std::string make_frame(double time) const;
  // The sample of a topic at `time`, nullptr when there is none yet.
  const Sample* find_sample(const Topic& topic, double time) const;
  // The time `count` samples after (before, when negative) that of `time` in the topic that moves the robot.
  double find_step(double time, int count) const;
  // Throws InputError for signals that are not there.
  Series find_series(const std::string& signal) const;

 private:
  const Topic* find_motion() const;
  std::string name_;
  Scene scene_;
  std::vector<std::unique_ptr<Schema>> schemas_;
  std::map<std::string, Topic> topics_;
  std::unique_ptr<PictureLog> pictures_;
  std::vector<std::string> notes_;
  size_t bytes_ = 0;
  int stride_ = 1;                        // one sample of so many is kept
  std::map<std::string, size_t> counts_;  // samples offered
  double begin_ = 0.0, end_ = 0.0;
};

// The difference of two series at the times of the first one, the second one interpolated; times count from the
// begins of their recordings, which are given.
Series subtract(const Series& first, double begin_first, const Series& second, double begin_second);

// Throws McapError.
std::unique_ptr<Recording> read_log(const std::string& path);
// One recording for each CSV file of an experiment folder (docs/viewer.md). Throws InputError.
std::vector<std::unique_ptr<Recording>> read_experiment(const std::string& path);

}  // namespace hrp

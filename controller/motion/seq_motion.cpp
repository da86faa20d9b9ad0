// SPDX-License-Identifier: BSD-3-Clause
// Choreonoid writes these files line by line in one style; a reader of that style takes 20 ms where a general YAML
// reader takes over a second for the 1.3 MB of SR1's walking pattern.
#include <cmath>
#include <set>

#include "common/base/diagnostics.h"
#include "controller/motion/motion.h"
#include "controller/motion/motion_text.h"

namespace hrp {
namespace {

class SeqReader {
 public:
  SeqReader(const std::string& text, const std::string& path)
      : at_(text.data()), end_(at_ + text.size()), path_(path) {}
  Motion read(const std::vector<std::string>& joint_order);

 private:
  void read_key(const std::string& line);
  void read_frame();
  void start_component();
  void finish_component();
  double read_value(const std::string& value, const std::string& key);

  const char* at_;
  const char* end_;
  const char* line_start_ = nullptr;
  std::string path_;
  int line_ = 0;
  bool in_components_ = false;
  // of the component at hand
  std::string content_;
  size_t parts_ = 0;
  double rate_ = 0.0;
  std::vector<double> values_;
  size_t frames_ = 0;
  int component_line_ = 0;
  // results
  double file_rate_ = 0.0;
  bool found_ = false;
  size_t found_parts_ = 0;
  double found_rate_ = 0.0;
  std::vector<double> found_values_;
  bool is_composite_ = false;
};

double SeqReader::read_value(const std::string& value, const std::string& key) {
  const char* at = value.data();
  double number = 0.0;
  if (!read_number(&at, value.data() + value.size(), &number) || number <= 0.0) {
    refuse_input({path_, "", line_}, key + " is '" + value + "', expected a number > 0");
  }
  return number;
}

void SeqReader::start_component() {
  finish_component();
  content_.clear();
  parts_ = 0;
  frames_ = 0;
  rate_ = 0.0;
  values_.clear();
  component_line_ = line_;
}

void SeqReader::finish_component() {
  if (content_ != "JointDisplacement" && content_ != "JointPosition") return;
  if (found_) refuse_input({path_, "", component_line_}, "is a second component of joint displacements");
  if (frames_ == 0) refuse_input({path_, "", component_line_}, "JointDisplacement has no frames");
  found_ = true;
  found_parts_ = parts_;
  found_rate_ = rate_;
  found_values_.swap(values_);
  content_.clear();
}

void SeqReader::read_key(const std::string& line) {
  std::string text = line;
  const size_t first = text.find_first_not_of(' ');
  if (in_components_ && text[first] == '-') {
    start_component();
    text[first] = ' ';
  }
  const size_t start = text.find_first_not_of(" \r");
  if (start == std::string::npos) return;
  const size_t colon = text.find(':', start);
  if (colon == std::string::npos)
    refuse_input({path_, "", line_}, "is " + show_word(&text[start], &text[text.size()]) + ", expected 'key: value'");
  const std::string key = text.substr(start, colon - start);
  std::string value = text.substr(colon + 1);
  const size_t last = value.find_last_not_of(" \r\"'");
  const size_t begin = value.find_first_not_of(" \"'");
  value = begin == std::string::npos || last == std::string::npos ? "" : value.substr(begin, last - begin + 1);
  if (key == "type" && !in_components_) is_composite_ = value == "CompositeSeq";
  if (key == "components") in_components_ = true;
  if (key == "content" || key == "purpose") content_ = value;
  if (key == "numParts") parts_ = static_cast<size_t>(std::min(read_value(value, key), 1e4));
  if (key == "frameRate") (in_components_ ? rate_ : file_rate_) = read_value(value, key);
}

// "- [ a, b, ... ]", which may go on over several lines.
void SeqReader::read_frame() {
  const int first_line = line_;
  const bool wanted = content_ == "JointDisplacement" || content_ == "JointPosition";
  size_t count = 0;
  while (at_ < end_ && *at_ != '[') ++at_;
  ++at_;
  while (true) {
    while (at_ < end_ && (*at_ == ' ' || *at_ == ',' || *at_ == '\r' || *at_ == '\n')) line_ += *at_++ == '\n' ? 1 : 0;
    if (at_ >= end_)
      refuse_input({path_, "", first_line}, "the frame that begins here has no ']': the file is cut off");
    if (*at_ == ']') break;
    double value = 0.0;
    if (!read_number(&at_, end_, &value)) {
      refuse_input({path_, "", line_}, "value " + std::to_string(count + 1) + " of the frame is " +
                                           show_word(at_, end_) + ", expected a finite number");
    }
    if (wanted) values_.push_back(value);
    ++count;
  }
  while (at_ < end_ && *at_ != '\n') ++at_;
  if (wanted && parts_ > 0 && count != parts_) {
    refuse_input({path_, "", first_line},
                 "has " + std::to_string(count) + " values, expected numParts = " + std::to_string(parts_));
  }
  ++frames_;
}

Motion SeqReader::read(const std::vector<std::string>& joint_order) {
  while (at_ < end_) {
    line_start_ = at_;
    ++line_;
    const char* p = at_;
    while (p < end_ && (*p == ' ' || *p == '-')) ++p;
    if (p < end_ && *p == '[') {
      read_frame();
    } else {
      while (at_ < end_ && *at_ != '\n') ++at_;
      const std::string line(line_start_, at_);
      const size_t first = line.find_first_not_of(" \r");
      if (first != std::string::npos && line[first] != '#') read_key(line);
    }
    if (at_ < end_) ++at_;
  }
  finish_component();
  if (!is_composite_) refuse_input({path_, "", 1}, "is no Choreonoid motion, expected 'type: CompositeSeq'");
  if (!found_) refuse_input({path_, "", line_}, "has no component with content JointDisplacement");
  const double rate = found_rate_ > 0.0 ? found_rate_ : file_rate_;
  if (rate <= 0.0) refuse_input({path_, "", line_}, "has no frameRate");
  if (found_parts_ == 0) refuse_input({path_, "", line_}, "has no numParts");
  if (joint_order.size() != found_parts_) {
    refuse_input(path_, "has " + std::to_string(found_parts_) + " joints without names; controller.joint_order names " +
                            std::to_string(joint_order.size()));
  }
  const size_t frames = found_values_.size() / found_parts_;
  Motion motion;
  motion.joints = joint_order;
  for (size_t k = 0; k < frames; ++k) motion.times.push_back(static_cast<double>(k) / rate);
  motion.positions =
      Eigen::Map<const Eigen::MatrixXd>(found_values_.data(), Eigen::Index(found_parts_), Eigen::Index(frames));
  return motion;
}

}  // namespace

Motion parse_seq_motion(const std::string& text, const std::string& path, const std::vector<std::string>& joint_order) {
  return SeqReader(text, path).read(joint_order);
}

}  // namespace hrp

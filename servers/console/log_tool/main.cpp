// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <functional>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/diagnostics.h"
#include "common/base/number_option.h"
#include "common/base/version.h"
#include "common/base/write_file.h"
#include "common/plot/robot_pictures.h"
#include "servers/console/log_tool/commands.h"

namespace hrp {
namespace {

// The command line: subcommands with their options, and the work that the chosen one asks for.
class LogTool {
 public:
  LogTool() {
    app_.set_version_flag("--version", get_version_text("hrp-log"));
    app_.require_subcommand(1);
    add("info", "topics, counts, steps, and whether the file is complete", [this] { return show_info(file_); });
    add_cat();
    add_output(add("csv", "sensors and commands as a CSV table, with the columns of recordings",
                   [this] { return write([this] { return write_csv(file_, out_); }); }),
               "CSV file");
    add_plot();
    add_pictures();
    add_image();
    add_converter("foxglove", "a file for Foxglove: the log, and the robot with its forces in the 3D panel",
                  "MCAP file", write_foxglove);
    add_converter("rosbag", "a ROS 2 bag for rosbag2 and PlotJuggler: /tf, /joint_states, /zmp, ...", "folder",
                  write_rosbag);
    add("pushes", "pushes that people gave live, as the section 'pushes' of a scenario that repeats the run",
        [this] { return show_pushes(file_); });
    add("hash", "hash of all payloads of each topic; equal runs have equal hashes",
        [this] { return show_hashes(file_); });
    add("compare", "first difference of two logs; exit status 1 if there is one",
        [this] { return compare_logs(file_, other_); })
        ->add_option("other", other_, "second log")
        ->required();
    add_recover();
  }

  // Throws what the work throws.
  int run(int argc, char** argv) {
    if (const auto status = take_command_line(&app_, argc, argv)) return *status;
    return work_();
  }

 private:
  using Work = std::function<int()>;

  CLI::App* add(const char* name, const char* text, Work work) {
    CLI::App* command = app_.add_subcommand(name, text);
    command->add_option("file", file_, "log")->required();
    command->callback([this, work] { work_ = work; });
    return command;
  }

  void add_output(CLI::App* command, const char* text) {
    command->add_option("--out", out_, text)->required();
    command->add_flag("--force", force_, "overwrite OUT even if it is a log");
  }

  int write(const Work& work) const {
    check_output(file_, out_, force_);
    return work();
  }

  void add_cat() {
    CLI::App* show = add("cat", "messages as text or JSON lines", [this] {
      cat_.file = file_;
      return show_messages(cat_);
    });
    show->add_option("topic", cat_.topic, "only this topic, e.g. contact_forces");
    show->add_flag("--json", cat_.json, "one line of JSON per message");
    show->add_option("--field", cat_.field, "only this part, e.g. pairs[0].total.force.z");
    show->add_option("--from", cat_.from, "simulated time to begin with [s]")->check(refuse_nan);
    show->add_option("--to", cat_.to, "simulated time to end with [s]")->check(refuse_nan);
  }

  void add_plot() {
    CLI::App* plot = add("plot", "an SVG plot of signals; by default, of the vertical forces on the feet",
                         [this] { return write([this] { return write_plot(file_, signals_, out_); }); });
    add_output(plot, "SVG file");
    plot->add_option("--signal", signals_,
                     "a CSV column, or topic:field, such as contact_forces:pairs[0].total.force.z");
  }

  void add_pictures() {
    CLI::App* pictures = add("pictures", "pictures of the robots at equal intervals, side by side, as SVG", [this] {
      return write([this] {
        write_robot_pictures(file_, look_, out_);
        return 0;
      });
    });
    add_output(pictures, "SVG file");
    pictures->add_option("--from", look_.from, "simulated time of the first picture [s]")->check(refuse_nan);
    pictures->add_option("--to", look_.to, "simulated time of the last picture [s]; default: the end")
        ->check(refuse_nan);
    pictures->add_option("--robot", look_.robot, "name of the robot that the camera follows; default: the first one");
    pictures->add_option("--count", look_.count, "number of pictures")->check(CLI::Range(1, 40));
    pictures
        ->add_option("--azimuth", look_.azimuth, "direction of the camera: 0 in front, pi/2 on the robot's left [rad]")
        ->check(refuse_nan);
    pictures->add_option("--elevation", look_.elevation, "elevation of the camera [rad]")->check(refuse_nan);
  }

  void add_image() {
    CLI::App* picture =
        add("image", "one picture of a camera as PNG: colours, or depth in millimetres with 16 bits", [this] {
          image_.file = file_;
          image_.out = out_;
          return write([this] { return write_image(image_); });
        });
    picture->add_option("topic", image_.topic, "topic of the picture, such as head/image_raw or head/depth/image_raw")
        ->required();
    picture->add_option("--at", image_.at, "simulated time [s]: writes the first picture at or after it")
        ->check(refuse_nan)
        ->capture_default_str();
    add_output(picture, "PNG file");
  }

  void add_converter(const char* name, const char* text, const char* out_text, int (*work)(const ConvertOptions&)) {
    CLI::App* command = add(name, text, [this, work] {
      convert_.file = file_;
      convert_.out = out_;
      convert_.force = force_;
      return work(convert_);
    });
    add_output(command, out_text);
    command->add_option("--rate", convert_.rate, "samples per simulated second [Hz]; 0: every sample")
        ->check(refuse_nan)
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
  }

  void add_recover() {
    CLI::App* recover = add("recover", "copies the readable part of a damaged log into a new log",
                            [this] { return recover_log(file_, out_, force_); });
    recover->add_option("out", out_, "new file")->required();
    recover->add_flag("--force", force_, "overwrite OUT");
  }

  CLI::App app_{"Shows, plots, converts and compares logs (MCAP) of runs.", "hrp-log"};
  Work work_;
  std::string file_, other_, out_;
  bool force_ = false;
  std::vector<std::string> signals_;
  CatOptions cat_;
  PictureOptions look_;
  ImageOptions image_;
  ConvertOptions convert_;
};

}  // namespace
}  // namespace hrp

int main(int argc, char** argv) {
  hrp::LogTool tool;
  try {
    const int status = tool.run(argc, argv);
    return hrp::finish_output("hrp-log") ? status : std::max(status, 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-log: %s\n", error.what());
    return 2;
  }
}

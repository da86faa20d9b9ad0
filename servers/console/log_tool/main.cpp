// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <functional>

#include <CLI/CLI.hpp>

#include "common/base/diagnostics.h"
#include "common/base/version.h"
#include "common/plot/robot_pictures.h"
#include "servers/console/log_tool/commands.h"

int main(int argc, char** argv) {
  CLI::App app("Shows, plots, converts and compares logs (MCAP) of runs.", "hrp-log");
  app.set_version_flag("--version", hrp::get_version_text("hrp-log"));
  app.require_subcommand(1);
  std::string file, other, out;
  bool force = false;
  std::vector<std::string> signals;
  hrp::CatOptions cat;
  std::function<int()> run;
  const auto add = [&](const char* name, const char* text, std::function<int()> work) {
    CLI::App* command = app.add_subcommand(name, text);
    command->add_option("file", file, "log")->required();
    command->callback([&run, work] { run = work; });
    return command;
  };
  add("info", "topics, counts, steps, and whether the file is complete", [&] { return hrp::show_info(file); });
  CLI::App* show = add("cat", "messages as text or JSON lines", [&] {
    cat.file = file;
    return hrp::show_messages(cat);
  });
  show->add_option("topic", cat.topic, "only this topic, e.g. contact_forces");
  show->add_flag("--json", cat.json, "one line of JSON per message");
  show->add_option("--field", cat.field, "only this part, e.g. pairs[0].total.force.z");
  show->add_option("--from", cat.from, "simulated time to begin with [s]");
  show->add_option("--to", cat.to, "simulated time to end with [s]");
  const auto add_output = [&](CLI::App* command, const char* text) {
    command->add_option("--out", out, text)->required();
    command->add_flag("--force", force, "overwrite OUT even if it is a log");
  };
  add_output(add("csv", "sensors and commands as a CSV table, with the columns of recordings", [&] {
    hrp::check_output(file, out, force);
    return hrp::write_csv(file, out);
  }), "CSV file");
  CLI::App* plot = add("plot", "an SVG plot of signals; by default, of the vertical forces on the feet",
                       [&] {
                         hrp::check_output(file, out, force);
                         return hrp::write_plot(file, signals, out);
                       });
  add_output(plot, "SVG file");
  plot->add_option("--signal", signals, "a CSV column, or topic:field, such as contact_forces:pairs[0].total.force.z");
  hrp::PictureOptions look;
  CLI::App* pictures = add("pictures", "pictures of the robots at equal intervals, side by side, as SVG", [&] {
    hrp::check_output(file, out, force);
    hrp::write_robot_pictures(file, look, out);
    return 0;
  });
  add_output(pictures, "SVG file");
  pictures->add_option("--from", look.from, "simulated time of the first picture [s]");
  pictures->add_option("--to", look.to, "simulated time of the last picture [s]; default: the end");
  pictures->add_option("--robot", look.robot, "name of the robot that the camera follows; default: the first one");
  pictures->add_option("--count", look.count, "number of pictures")->check(CLI::Range(1, 40));
  pictures->add_option("--azimuth", look.azimuth, "direction of the camera: 0 in front, pi/2 on the robot's left [rad]");
  pictures->add_option("--elevation", look.elevation, "elevation of the camera [rad]");
  hrp::ImageOptions image;
  CLI::App* picture = add("image", "one picture of a camera as PNG: colours, or depth in millimetres with 16 bits", [&] {
    hrp::check_output(file, out, force);
    image.file = file, image.out = out;
    return hrp::write_image(image);
  });
  picture->add_option("topic", image.topic, "topic of the picture, such as head/image_raw or head/depth/image_raw")->required();
  picture->add_option("--at", image.at, "simulated time [s]: writes the first picture at or after it")->capture_default_str();
  add_output(picture, "PNG file");
  hrp::ConvertOptions convert;
  const auto add_converter = [&](const char* name, const char* text, const char* out_text, int (*work)(const hrp::ConvertOptions&)) {
    CLI::App* command = add(name, text, [&, work] {
      convert.file = file, convert.out = out, convert.force = force;
      return work(convert);
    });
    add_output(command, out_text);
    command->add_option("--rate", convert.rate, "samples per simulated second [Hz]; 0: every sample")->check(CLI::NonNegativeNumber)->capture_default_str();
  };
  add_converter("foxglove", "a file for Foxglove: the log, and the robot with its forces in the 3D panel", "MCAP file", hrp::write_foxglove);
  add_converter("rosbag", "a ROS 2 bag for rosbag2 and PlotJuggler: /tf, /joint_states, /zmp, ...", "folder", hrp::write_rosbag);
  add("hash", "hash of all payloads of each topic; equal runs have equal hashes", [&] { return hrp::show_hashes(file); });
  add("compare", "first difference of two logs; exit status 1 if there is one", [&] {
    return hrp::compare_logs(file, other);
  })->add_option("other", other, "second log")->required();
  CLI::App* recover = add("recover", "copies the readable part of a damaged log into a new log",
                          [&] { return hrp::recover_log(file, out, force); });
  recover->add_option("out", out, "new file")->required();
  recover->add_flag("--force", force, "overwrite OUT");
  try {
    app.parse(argc, argv);
    return run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-log: %s\n", error.what());
    return 2;
  }
}

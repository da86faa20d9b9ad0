// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <CLI/CLI.hpp>

namespace hrp {

// Takes the words of a command line. A status when the program ends at once: 0 after --help and --version, 2 after
// words that cannot be used, as after all other bad input (CLI11's own statuses are above 100).
inline std::optional<int> take_command_line(CLI::App* app, int argc, char** argv) {
  try {
    app->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    return app->exit(error) == 0 ? 0 : 2;
  }
}

}  // namespace hrp

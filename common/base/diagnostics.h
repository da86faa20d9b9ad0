// SPDX-License-Identifier: BSD-3-Clause
// What is wrong with input that people wrote: file, line, field, value and what was expected.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace hrp {

struct Diagnostic {
  enum class Severity { kWarning, kError };
  Severity severity = Severity::kError;
  std::string file;
  int line = 0;         // 1 is the first line; 0 = unknown
  int column = 0;       // 1 is the first column; 0 = unknown
  std::string field;    // key, element or column name: "servo.default.kp", "joint 'knee' <limit>"
  std::string message;  // what is wrong, the value, what was expected
  // "file:line:column: error: field: message"; parts that are unknown are left out.
  std::string text() const;
};

// Where in the input something is wrong; what is not known stays at its default. See Diagnostic.
struct InputPlace {
  // Not explicit: a whole file is a place.
  InputPlace(std::string file_in, std::string field_in = "", int line_in = 0, int column_in = 0)
      : file(std::move(file_in)), field(std::move(field_in)), line(line_in), column(column_in) {}
  std::string file, field;
  int line, column;
};

// Collects everything that is wrong, so that people see it at once.
class Diagnostics {
 public:
  void add(Diagnostic diagnostic);  // with its own severity
  void add_error(Diagnostic diagnostic);
  void add_error(const InputPlace& place, const std::string& message);
  void add_warning(Diagnostic diagnostic);
  void add_warning(const InputPlace& place, const std::string& message);
  bool has_errors() const;
  const std::vector<Diagnostic>& all() const { return all_; }
  std::vector<std::string> warning_texts() const;
  // All errors, one a line.
  std::string error_text() const;

 private:
  std::vector<Diagnostic> all_;
};

// Input that cannot be used. what() holds every diagnostic, one a line.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const Diagnostics& diagnostics);
  explicit InputError(const Diagnostic& diagnostic);
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

// Throws InputError of this one error.
[[noreturn]] void refuse_input(const InputPlace& place, const std::string& message);

// The candidate nearest to a mistyped word, empty when none is near.
std::string find_nearest(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace hrp

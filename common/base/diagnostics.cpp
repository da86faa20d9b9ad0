// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/diagnostics.h"

#include <algorithm>
#include <cctype>
#include <numeric>

#include "common/base/printable.h"

namespace hrp {
namespace {

std::string join_errors(const std::vector<Diagnostic>& all) {
  std::string text;
  for (const Diagnostic& d : all) {
    if (d.severity != Diagnostic::Severity::kError) continue;
    if (!text.empty()) text += '\n';
    text += d.text();
  }
  return text;
}

Diagnostic make_diagnostic(const InputPlace& place, const std::string& message) {
  Diagnostic d;
  d.file = place.file;
  d.line = place.line;
  d.column = place.column;
  d.field = place.field;
  d.message = message;
  return d;
}

// Levenshtein distance.
size_t calc_edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

}  // namespace

std::string Diagnostic::text() const {
  std::string out = make_printable_line(file);
  if (line > 0) out += ":" + std::to_string(line);
  if (line > 0 && column > 0) out += ":" + std::to_string(column);
  if (!out.empty()) out += ": ";
  out += severity == Severity::kError ? "error: " : "warning: ";
  if (!field.empty()) out += make_printable_line(field) + ": ";
  return out + make_printable(message);
}

void Diagnostics::add(Diagnostic diagnostic) { all_.push_back(std::move(diagnostic)); }

void Diagnostics::add_error(Diagnostic diagnostic) {
  diagnostic.severity = Diagnostic::Severity::kError;
  add(std::move(diagnostic));
}

void Diagnostics::add_warning(Diagnostic diagnostic) {
  diagnostic.severity = Diagnostic::Severity::kWarning;
  add(std::move(diagnostic));
}

void Diagnostics::add_error(const InputPlace& place, const std::string& message) {
  add_error(make_diagnostic(place, message));
}
void Diagnostics::add_warning(const InputPlace& place, const std::string& message) {
  add_warning(make_diagnostic(place, message));
}

bool Diagnostics::has_errors() const {
  return std::any_of(all_.begin(), all_.end(),
                     [](const Diagnostic& d) { return d.severity == Diagnostic::Severity::kError; });
}

std::vector<std::string> Diagnostics::warning_texts() const {
  std::vector<std::string> texts;
  for (const Diagnostic& d : all_) {
    if (d.severity == Diagnostic::Severity::kWarning) texts.push_back(d.text());
  }
  return texts;
}

std::string Diagnostics::error_text() const { return join_errors(all_); }

InputError::InputError(const Diagnostics& diagnostics)
    : std::runtime_error(diagnostics.error_text()), diagnostics_(diagnostics.all()) {}

InputError::InputError(const Diagnostic& diagnostic)
    : std::runtime_error(diagnostic.text()), diagnostics_{diagnostic} {}

void refuse_input(const InputPlace& place, const std::string& message) {
  throw InputError(make_diagnostic(place, message));
}

std::string find_nearest(const std::string& word, const std::vector<std::string>& candidates) {
  // Only upper and lower case differ: nothing is nearer ("kP" is kp, not kd).
  const auto lower = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  for (const std::string& candidate : candidates) {
    if (lower(candidate) == lower(word)) return candidate;
  }
  std::string best;
  size_t best_distance = std::max<size_t>(1, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const size_t distance = calc_edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace hrp

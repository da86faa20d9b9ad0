// SPDX-License-Identifier: BSD-3-Clause
// Samples as JSON and as text for people.
#include <cmath>
#include <cstdio>

#include "common/base/bit_hash.h"
#include "common/base/exact_number.h"
#include "common/messages/reflection/sample.h"

namespace hrp {
namespace {

std::string find_special(double value) { return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf"; }

// The code of a control character, which must not reach a terminal: C0, DEL, or C1 as UTF-8 has it (0xc2 and one more
// byte); 0 where there is none at this place.
unsigned find_control(const std::string& text, size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  if (byte < 0x20 || byte == 0x7f) return byte;
  if (byte != 0xc2 || at + 1 == text.size()) return 0;
  const auto next = static_cast<unsigned char>(text[at + 1]);
  return next >= 0x80 && next < 0xa0 ? next : 0;
}

std::string quote(const std::string& text) {
  std::string quoted = "\"";
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const unsigned control = find_control(text, i);
    switch (c) {
      case '"': quoted += "\\\""; break;
      case '\\': quoted += "\\\\"; break;
      case '\n': quoted += "\\n"; break;
      case '\r': quoted += "\\r"; break;
      case '\t': quoted += "\\t"; break;
      default:
        if (control == 0 && c != '\0') {
          quoted += c;
          break;
        }
        char code[8];
        std::snprintf(code, sizeof(code), "\\u%04x", control);
        quoted += code;
        if (control >= 0x80) ++i;
    }
  }
  return quoted + "\"";
}

std::string find_enum_name(const EnumType& type, uint32_t value) {
  return value < type.values.size() ? type.values[value] : std::to_string(value);
}

class JsonPrinter : public SampleVisitor {
 public:
  std::string text;
  void begin_struct(const StructType&) override { open('{'); }
  void end_struct() override { close('}'); }
  void begin_field(const Field& field) override {
    separate();
    text += quote(field.name) + ":";
    first_ = true;
  }
  void begin_list(const FieldType&, size_t) override { open('['); }
  void end_list() override { close(']'); }
  void on_bool(bool value) override { add(value ? "true" : "false"); }
  void on_signed(int64_t value) override { add(std::to_string(value)); }
  void on_unsigned(uint64_t value) override { add(std::to_string(value)); }
  void on_hash(uint64_t value) override { add(quote(format_hash(value))); }
  void on_float(double value) override {
    add(std::isfinite(value) ? format_exact(value) : "\"" + find_special(value) + "\"");
  }
  void on_string(const std::string& value) override { add(quote(value)); }
  void on_enum(const EnumType& type, uint32_t value) override { add(quote(find_enum_name(type, value))); }

 private:
  void separate() {
    if (!first_) text += ",";
    first_ = false;
  }
  void add(const std::string& value) {
    separate();
    text += value;
  }
  void open(char bracket) {
    separate();
    text += bracket;
    first_ = true;
  }
  void close(char bracket) {
    text += bracket;
    first_ = false;
  }
  bool first_ = true;
};

// YAML-like: one field a line, lists of numbers on one line, elements of struct lists start with a dash.
class TextPrinter : public SampleVisitor {
 public:
  std::string text;

  void begin_struct(const StructType&) override {
    if (!in_list_.empty() && in_list_.back() == kStructList) {
      dash_ = true;
    } else if (depth_ >= 0) {
      end_line();
    }
    ++depth_;
    in_list_.push_back(kNoList);
  }

  void end_struct() override {
    --depth_;
    in_list_.pop_back();
  }

  void begin_field(const Field& field) override {
    std::string indent(static_cast<size_t>(2 * depth_), ' ');
    if (dash_ && depth_ > 0) indent[indent.size() - 2] = '-';
    dash_ = false;
    text += indent + field.name + (field.unit.empty() || field.unit == "hex" ? "" : " [" + field.unit + "]") + ":";
  }

  void begin_list(const FieldType& type, size_t size) override {
    const bool structs = type.kind == ValueKind::kStruct && size > 0;
    if (!structs) {
      text += depth_ >= 0 ? " [" : "[";
      in_list_.push_back(kInlineList);
      first_ = true;
      return;
    }
    if (depth_ >= 0) end_line();
    in_list_.push_back(kStructList);
  }

  void end_list() override {
    const bool in_line = in_list_.back() == kInlineList;
    in_list_.pop_back();
    if (!in_line) return;
    text += "]";
    end_line();
  }

  void on_bool(bool value) override { add(value ? "true" : "false"); }
  void on_signed(int64_t value) override { add(std::to_string(value)); }
  void on_unsigned(uint64_t value) override { add(std::to_string(value)); }
  void on_hash(uint64_t value) override { add(format_hash(value)); }
  void on_float(double value) override { add(std::isfinite(value) ? format_exact(value) : find_special(value)); }
  void on_string(const std::string& value) override {
    constexpr size_t kMost = 160;
    add(value.size() <= kMost ? quote(value)
                              : quote(value.substr(0, kMost)) + "... (" + std::to_string(value.size()) + " bytes)");
  }
  void on_enum(const EnumType& type, uint32_t value) override { add(find_enum_name(type, value)); }

 private:
  enum ListKind { kNoList, kInlineList, kStructList };

  void add(const std::string& value) {
    if (!in_list_.empty() && in_list_.back() == kInlineList) {
      text += (first_ ? "" : ", ") + value;
      first_ = false;
      return;
    }
    text += (in_list_.empty() ? "" : " ") + value;
    end_line();
  }

  void end_line() { text += "\n"; }

  int depth_ = -1;  // of the struct whose fields are printed
  std::vector<ListKind> in_list_;
  bool dash_ = false;
  bool first_ = true;
};

}  // namespace

std::string print_json(const StructType& type, Bytes sample) {
  JsonPrinter printer;
  visit_sample(type, sample, &printer);
  return printer.text;
}

std::string print_text(const StructType& type, Bytes sample) {
  TextPrinter printer;
  visit_sample(type, sample, &printer);
  return printer.text;
}

std::optional<std::string> print_json(const StructType& type, Bytes sample, const FieldPath& path) {
  JsonPrinter printer;
  if (!visit_field(type, sample, path, &printer)) return std::nullopt;
  return printer.text;
}

std::optional<std::string> print_text(const StructType& type, Bytes sample, const FieldPath& path) {
  TextPrinter printer;
  if (!visit_field(type, sample, path, &printer)) return std::nullopt;
  return printer.text;
}

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// A recursive descent over tokens; comments are looked up by position, so that the grammar does not see them.
#include <cctype>
#include <cstdlib>

#include "common/base/diagnostics.h"
#include "common/base/trim.h"
#include "common/messages/reflection/schema.h"

namespace hrp {
namespace {

struct Token {
  std::string text;
  size_t begin = 0;  // in the file's text
  size_t end = 0;
  int line = 1;
};

struct Comment {
  std::string text;  // without the slashes
  size_t begin = 0;
  int line = 1;
  bool alone = true;  // nothing in front of it on its line
};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

// "[N m] total joint effort" -> "N m"
std::string find_unit(const std::string& comment) {
  if (comment.empty() || comment[0] != '[') return "";
  const size_t end = comment.find(']');
  return end == std::string::npos ? "" : comment.substr(1, end - 1);
}

class Lexer {
 public:
  explicit Lexer(const std::string& text) : text_(text) {
    while (position_ < text_.size()) step();
  }
  std::vector<Token> tokens;
  std::vector<Comment> comments;

 private:
  void step() {
    const char c = text_[position_];
    if (c == '\n') {
      ++line_;
      ++position_;
      line_empty_ = true;
    } else if (std::isspace(static_cast<unsigned char>(c))) {
      ++position_;
    } else if (c == '#') {
      position_ = find_line_end();
    } else if (text_.compare(position_, 2, "//") == 0) {
      const size_t end = find_line_end();
      comments.push_back({trim(text_.substr(position_ + 2, end - position_ - 2)), position_, line_, line_empty_});
      position_ = end;
    } else {
      take_token();
    }
  }

  size_t find_line_end() const {
    const size_t end = text_.find('\n', position_);
    return end == std::string::npos ? text_.size() : end;
  }

  void take_token() {
    size_t end = position_ + 1;
    if (is_word(text_[position_])) {
      // Scoped names are one token.
      while (end < text_.size() && (is_word(text_[end]) || text_.compare(end, 2, "::") == 0)) {
        end += is_word(text_[end]) ? 1 : 2;
      }
    }
    tokens.push_back({text_.substr(position_, end - position_), position_, end, line_});
    position_ = end;
    line_empty_ = false;
  }

  const std::string& text_;
  size_t position_ = 0;
  int line_ = 1;
  bool line_empty_ = true;
};

}  // namespace

class IdlParser {
 public:
  IdlParser(const IdlFile& file, Schema* schema) : file_(file), schema_(*schema), lexer_(file.text) {}

  void parse() {
    while (next_ < lexer_.tokens.size()) parse_definition();
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    const auto& tokens = lexer_.tokens;
    refuse_input({file_.name, "", tokens.empty() ? 0 : tokens[std::min(next_, tokens.size() - 1)].line}, message);
  }

  const Token& peek() const {
    if (next_ >= lexer_.tokens.size()) fail("the file ends in the middle of a definition");
    return lexer_.tokens[next_];
  }

  const Token& take() {
    const Token& token = peek();
    ++next_;
    return token;
  }

  void expect(const std::string& text) {
    if (peek().text != text) fail("'" + peek().text + "' where '" + text + "' was expected");
    ++next_;
  }

  std::string take_name() {
    if (!is_word(peek().text[0])) fail("'" + peek().text + "' where a name was expected");
    return take().text;
  }

  void parse_definition() {
    const size_t first = next_;
    if (peek().text == "@") {
      ++next_;
      if (take_name() != "final") fail("only @final types are part of our IDL");
    }
    const std::string keyword = take_name();
    if (keyword == "module") return parse_module();
    if (keyword != "struct" && keyword != "enum") fail("'" + keyword + "' is not part of our IDL");
    const std::string name = find_scope() + take_name();
    if (schema_.definitions_.count(name)) fail(name + " is defined twice");
    Schema::Definition definition;
    keyword == "struct" ? parse_struct(name, lexer_.tokens[first], &definition) : parse_enum(name);
    definition.modules = modules_;
    definition.order = schema_.definitions_.size();
    definition.text = cut_text(lexer_.tokens[first], lexer_.tokens[next_ - 1]);
    schema_.definitions_.emplace(name, std::move(definition));
  }

  void parse_module() {
    modules_.push_back(take_name());
    expect("{");
    while (peek().text != "}") parse_definition();
    expect("}");
    expect(";");
    modules_.pop_back();
  }

  void parse_struct(const std::string& name, const Token& first, Schema::Definition* definition) {
    auto type = std::make_unique<StructType>();
    type->name = name;
    type->comment = find_comment_above(first);
    expect("{");
    while (peek().text != "}") {
      Field field;
      const Token& start = peek();
      field.type = parse_type(&definition->needs);
      field.name = take_name();
      if (peek().text == "[") {
        ++next_;
        field.type.array_size = std::strtoul(take().text.c_str(), nullptr, 10);
        if (field.type.array_size == 0 || field.type.is_sequence) fail("not an array of our IDL");
        expect("]");
      }
      expect(";");
      field.comment = find_comment_behind(lexer_.tokens[next_ - 1], start);
      field.unit = find_unit(field.comment);
      type->fields.push_back(std::move(field));
    }
    if (type->fields.empty()) fail(name + " has no fields");
    expect("}");
    expect(";");
    schema_.structs_.emplace(name, std::move(type));
  }

  void parse_enum(const std::string& name) {
    auto type = std::make_unique<EnumType>();
    type->name = name;
    expect("{");
    while (true) {
      type->values.push_back(take_name());
      if (peek().text == "}") break;
      expect(",");
    }
    expect("}");
    expect(";");
    schema_.enums_.emplace(name, std::move(type));
  }

  FieldType parse_type(std::vector<std::string>* needs) {
    if (peek().text != "sequence") return parse_single_type(needs);
    ++next_;
    expect("<");
    FieldType type = parse_single_type(needs);
    if (type.is_sequence) fail("a sequence of sequences is not part of our IDL");
    type.is_sequence = true;
    expect(">");
    return type;
  }

  FieldType parse_single_type(std::vector<std::string>* needs) {
    static const std::map<std::string, ValueKind> kBasic{
        {"boolean", ValueKind::kBool},    {"octet", ValueKind::kUint8},
        {"uint8", ValueKind::kUint8},     {"int8", ValueKind::kInt8},
        {"short", ValueKind::kInt16},     {"unsigned short", ValueKind::kUint16},
        {"long", ValueKind::kInt32},      {"unsigned long", ValueKind::kUint32},
        {"long long", ValueKind::kInt64}, {"unsigned long long", ValueKind::kUint64},
        {"float", ValueKind::kFloat32},   {"double", ValueKind::kFloat64},
        {"string", ValueKind::kString}};
    FieldType type;
    std::string name = take_name();
    while ((name == "unsigned" || name == "long" || name == "unsigned long") &&
           (peek().text == "long" || peek().text == "short")) {
      name += " " + take().text;
    }
    const auto basic = kBasic.find(name);
    if (basic != kBasic.end()) {
      type.kind = basic->second;
      return type;
    }
    const std::string full = find_full_name(name);
    type.structure = schema_.find_struct(full);
    type.enumeration = schema_.find_enum(full);
    type.kind = type.structure ? ValueKind::kStruct : ValueKind::kEnum;
    needs->push_back(full);
    return type;
  }

  std::string find_scope() const {
    std::string scope;
    for (const std::string& module : modules_) scope += module + "::";
    return scope;
  }

  // Looks in the modules that are open, innermost first.
  std::string find_full_name(const std::string& name) const {
    for (size_t depth = modules_.size() + 1; depth-- > 0;) {
      std::string full;
      for (size_t i = 0; i < depth; ++i) full += modules_[i] + "::";
      full += name;
      if (schema_.find_struct(full) || schema_.find_enum(full)) return full;
    }
    fail("'" + name + "' is not a type that is defined above");
  }

  // The comment lines right above a token, as one line.
  std::string find_comment_above(const Token& token) const {
    std::string text;
    int line = token.line - 1;
    for (size_t i = lexer_.comments.size(); i-- > 0;) {
      const Comment& comment = lexer_.comments[i];
      if (comment.line > line) continue;
      if (comment.line < line || !comment.alone) break;
      text = text.empty() ? comment.text : comment.text + " " + text;
      --line;
    }
    return text;
  }

  // The comment at the end of the token's line, else the one above the field.
  std::string find_comment_behind(const Token& token, const Token& field) const {
    for (const Comment& comment : lexer_.comments) {
      if (comment.line == token.line && !comment.alone) return comment.text;
    }
    return find_comment_above(field);
  }

  std::string cut_text(const Token& first, const Token& last) const {
    size_t begin = first.begin;
    int line = first.line - 1;
    for (size_t i = lexer_.comments.size(); i-- > 0;) {
      const Comment& comment = lexer_.comments[i];
      if (comment.line > line) continue;
      if (comment.line < line || !comment.alone) break;
      begin = comment.begin;
      --line;
    }
    return file_.text.substr(begin, last.end - begin);
  }

  const IdlFile& file_;
  Schema& schema_;
  Lexer lexer_;
  size_t next_ = 0;
  std::vector<std::string> modules_;
};

Schema parse_idl(const std::vector<IdlFile>& files) {
  Schema schema;
  for (const IdlFile& file : files) IdlParser(file, &schema).parse();
  return schema;
}

}  // namespace hrp

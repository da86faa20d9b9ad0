// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/reflection/sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "tests/unit/messages/every_message.h"
#include "tests/unit/messages/random_sample.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

Bytes as_bytes(const std::vector<uint8_t>& bytes) { return {bytes.data(), bytes.size()}; }

msg::ContactForces make_forces() {
  msg::ContactForces forces;
  forces.header().step(7);
  forces.header().time(0.007);
  forces.pairs().resize(2);
  forces.pairs()[1].name_a("left_foot");
  forces.pairs()[1].total().force().z(412.5);
  forces.pairs()[1].clipped(true);
  forces.pairs()[1].points().resize(1);
  return forces;
}

TEST(Schema, KnowsUnitsAndCommentsOfFields) {
  const StructType* type = get_schema().find_struct("hrp::msg::ContactPoint");
  ASSERT_NE(type, nullptr);
  EXPECT_EQ(type->fields[2].name, "depth");
  EXPECT_EQ(type->fields[2].unit, "m");
  EXPECT_THAT(type->fields[2].comment, HasSubstr("penetration"));
  EXPECT_THAT(type->comment, HasSubstr("One point of a contact."));
}

TEST(Schema, TextOfATypeStandsByItself) {
  for (const MessageCase& message : find_every_message()) {
    SCOPED_TRACE(message.type_name);
    const std::string text = find_schema_text(message.type_name);
    EXPECT_EQ(text.find('#'), std::string::npos);
    const Schema alone = parse_idl({{"text", text}});
    EXPECT_NE(alone.find_struct(message.type_name), nullptr);
  }
  EXPECT_THAT(find_schema_text("hrp::msg::ContactSet"), HasSubstr("[m] penetration"));
  EXPECT_EQ(find_schema_text("hrp::msg::Nothing"), "");
}

TEST(Schema, RefusesWhatIsNotOurIdlWithFileAndLine) {
  try {
    parse_idl({{"odd.idl", "module a {\n  @final struct B {\n    Unknown x;\n  };\n};\n"}});
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("odd.idl:3"));
    EXPECT_THAT(error.what(), HasSubstr("Unknown"));
  }
}

TEST(Cdr, EveryMessageDecodesAndEncodesToTheSameBytes) {
  for (const MessageCase& message : find_every_message()) {
    for (unsigned seed = 0; seed < 50; ++seed) {
      const RandomSample sample(*get_schema().find_struct(message.type_name), seed);
      ASSERT_EQ(message.encode_again(as_bytes(sample.bytes())), sample.bytes()) << message.type_name << " " << seed;
    }
  }
}

TEST(Cdr, CutSamplesAreDecodeErrorsEverywhere) {
  for (const MessageCase& message : find_every_message()) {
    const StructType& type = *get_schema().find_struct(message.type_name);
    const std::vector<uint8_t> whole = RandomSample(type, 3).bytes();
    for (size_t size = 0; size + 4 < whole.size(); size += 4) {
      const std::vector<uint8_t> cut(whole.begin(), whole.begin() + static_cast<long>(size));
      EXPECT_THROW(print_json(type, as_bytes(cut)), DecodeError) << message.type_name << " " << size;
      EXPECT_THROW(message.encode_again(as_bytes(cut)), DecodeError) << message.type_name << " " << size;
    }
  }
}

TEST(Cdr, DamagedSamplesNeverCrash) {
  std::mt19937 random(5);
  for (const MessageCase& message : find_every_message()) {
    const StructType& type = *get_schema().find_struct(message.type_name);
    for (unsigned seed = 0; seed < 200; ++seed) {
      std::vector<uint8_t> bytes = RandomSample(type, seed).bytes();
      for (int i = 0; i < 4; ++i) bytes[4 + random() % (bytes.size() - 4)] = static_cast<uint8_t>(random());
      try {
        print_text(type, as_bytes(bytes));
        message.encode_again(as_bytes(bytes));
      } catch (const DecodeError&) {
      }
    }
  }
}

TEST(Print, JsonHasEveryFieldAndExactNumbers) {
  std::vector<char> buffer;
  const Bytes sample = encode(make_forces(), &buffer);
  const std::string json = print_json(*get_schema().find_struct("hrp::msg::ContactForces"), sample);
  EXPECT_THAT(json, HasSubstr(R"({"header":{"epoch":0,"step":7,"time":0.007},"pairs":[{"body_a":0)"));
  EXPECT_THAT(json,
              HasSubstr(R"("total":{"moment":{"x":0,"y":0,"z":0},"force":{"x":0,"y":0,"z":412.5}},"clipped":true)"));
}

TEST(Print, NoControlCharacterReachesATerminal) {
  msg::ServerStatus status;
  status.message(
      "\x1b[2J\x7f\xc2\x9b"
      "1m\xc3\xa9");
  std::vector<char> buffer;
  const Bytes sample = encode(status, &buffer);
  const StructType& type = *get_schema().find_struct("hrp::msg::ServerStatus");
  for (const std::string& text : {print_json(type, sample), print_text(type, sample)}) {
    EXPECT_THAT(text, HasSubstr("\\u001b[2J\\u007f\\u009b1m\xc3\xa9"));
  }
}

TEST(Print, JsonQuotesAndSaysNotANumber) {
  msg::ServerStatus status;
  status.message("a \"b\"\n");
  status.foot_forces({std::nan("")});
  std::vector<char> buffer;
  const Bytes sample = encode(status, &buffer);
  const std::string json = print_json(*get_schema().find_struct("hrp::msg::ServerStatus"), sample);
  EXPECT_THAT(json, HasSubstr(R"("message":"a \"b\"\n","foot_forces":["nan"])"));
  EXPECT_THAT(json, HasSubstr(R"("phase":"SERVER_STARTING")"));
}

TEST(Print, TextShowsUnitsAndNesting) {
  std::vector<char> buffer;
  const Bytes sample = encode(make_forces(), &buffer);
  const std::string text = print_text(*get_schema().find_struct("hrp::msg::ContactForces"), sample);
  EXPECT_THAT(text, HasSubstr("header:\n  epoch: 0\n  step: 7\n  time [s]: 0.007\npairs:\n- body_a: 0\n  body_b: 0\n"));
  EXPECT_THAT(text, HasSubstr("  total:\n    moment [N m]:\n      x: 0\n"));
  EXPECT_THAT(text, HasSubstr("  points:\n  - p_WC [m]:\n      x: 0\n"));
}

TEST(FieldPath, FindsNumbersAndParts) {
  const StructType& type = *get_schema().find_struct("hrp::msg::ContactForces");
  std::vector<char> buffer;
  const Bytes sample = encode(make_forces(), &buffer);
  EXPECT_EQ(find_number(type, sample, FieldPath(type, "pairs[1].total.force.z")), 412.5);
  EXPECT_EQ(find_number(type, sample, FieldPath(type, "pairs[1].clipped")), 1.0);
  EXPECT_EQ(find_number(type, sample, FieldPath(type, "header.step")), 7.0);
  EXPECT_EQ(find_number(type, sample, FieldPath(type, "pairs[2].total.force.z")), std::nullopt);
  EXPECT_EQ(find_number(type, sample, FieldPath(type, "header")), std::nullopt);
  EXPECT_EQ(print_json(type, sample, FieldPath(type, "pairs[1].total.force")), R"({"x":0,"y":0,"z":412.5})");
  EXPECT_EQ(print_text(type, sample, FieldPath(type, "pairs[1].total.force.z")), "412.5\n");
  EXPECT_EQ(print_text(type, sample, FieldPath(type, "pairs[1].total.force")), "x: 0\ny: 0\nz: 412.5\n");
}

TEST(FieldPath, NamesTheStepThatDoesNotExist) {
  const StructType& type = *get_schema().find_struct("hrp::msg::ContactForces");
  for (const char* path : {"pairs[0].totl", "pairs.total", "header[0]", "header.step.x", "pairs[x]", ""}) {
    EXPECT_THROW(FieldPath(type, path), InputError) << path;
  }
  try {
    FieldPath(type, "pairs[0].totl.force");
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'total'"));
  }
}

}  // namespace
}  // namespace hrp

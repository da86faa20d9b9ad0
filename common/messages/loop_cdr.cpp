// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/loop_cdr.h"

#include <cstring>
#include <string>

#include "common/messages/cdr.h"
#include "common/messages/plain_numbers.h"
#include "hrp_idl/collision.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"

namespace hrp {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the numbers of a message are copied as they stand in memory");

constexpr size_t kEncapsulation = 4;

// Both archives know: numbers(), a list of doubles; block(), a struct of nothing but numbers of 8 bytes in the order of
// its fields; integer(); flag(); text(); and sequence(), whose elements are visited one by one.

class Encoder {
 public:
  explicit Encoder(std::vector<char>* buffer) : buffer_(*buffer) {
    static constexpr char kPlainLittleEndian[kEncapsulation] = {0, 1, 0, 0};
    std::memcpy(take(kEncapsulation), kPlainLittleEndian, kEncapsulation);
  }
  template <size_t count, typename T>
  void block(T& value) {
    static_assert(kIsPlainNumbers<T, count>);
    align(8);
    std::memcpy(take(sizeof value), static_cast<const void*>(&value), sizeof value);
  }
  void numbers(const std::vector<double>& values) {
    integer(static_cast<uint32_t>(values.size()));
    if (values.empty()) return;  // no gap before what is not there
    align(8);
    std::memcpy(take(8 * values.size()), values.data(), 8 * values.size());
  }
  template <typename T>
  void integer(const T& value) {
    static_assert(sizeof value == 4);
    align(4);
    std::memcpy(take(4), &value, 4);
  }
  void flag(bool value) { *take(1) = value ? 1 : 0; }
  void text(const std::string& value) {
    const size_t size = std::strlen(value.c_str()) + 1;
    integer(static_cast<uint32_t>(size));
    std::memcpy(take(size), value.c_str(), size);
  }
  template <typename T, typename Visit>
  void sequence(std::vector<T>& values, Visit visit) {
    integer(static_cast<uint32_t>(values.size()));
    for (T& value : values) visit(value);
  }
  Bytes finish() {
    align(4);
    return {reinterpret_cast<const uint8_t*>(buffer_.data()), size_};
  }

 private:
  char* take(size_t size) {
    if (buffer_.size() < size_ + size) buffer_.resize(2 * (size_ + size));
    size_ += size;
    return buffer_.data() + size_ - size;
  }
  // Gaps are zero.
  void align(size_t size) {
    while ((size_ - kEncapsulation) % size != 0) *take(1) = 0;
  }

  std::vector<char>& buffer_;
  size_t size_ = 0;
};

// Stops at the first thing that is not as an Encoder writes it: good() is then false, and Fast CDR has the last word.
class Decoder {
 public:
  explicit Decoder(Bytes sample) : data_(sample.data), size_(sample.size) {
    good_ = size_ >= kEncapsulation && data_[0] == 0 && data_[1] == 1;
    at_ = kEncapsulation;
  }
  bool good() const { return good_; }
  template <size_t count, typename T>
  void block(T& value) {
    static_assert(kIsPlainNumbers<T, count>);
    align(8);
    if (const uint8_t* from = take(sizeof value)) std::memcpy(static_cast<void*>(&value), from, sizeof value);
  }
  void numbers(std::vector<double>& values) {
    const uint32_t count = read_count(8);
    values.resize(count);
    if (count == 0) return;
    align(8);
    if (const uint8_t* from = take(8 * size_t{count})) std::memcpy(values.data(), from, 8 * size_t{count});
  }
  template <typename T>
  void integer(T& value) {
    static_assert(sizeof value == 4);
    align(4);
    if (const uint8_t* from = take(4)) std::memcpy(&value, from, 4);
  }
  void flag(bool& value) {
    const uint8_t* from = take(1);
    if (from != nullptr && *from > 1) good_ = false;
    if (good_) value = *from == 1;
  }
  void text(std::string& value) {
    const uint32_t size = read_count(1);
    const uint8_t* from = take(size);
    if (from == nullptr || size == 0 || from[size - 1] != 0) {
      good_ = false;
      return;
    }
    value.assign(reinterpret_cast<const char*>(from), size - 1);
  }
  template <typename T, typename Visit>
  void sequence(std::vector<T>& values, Visit visit) {
    values.resize(read_count(4));
    for (T& value : values) {
      if (!good_) return;
      visit(value);
    }
  }

 private:
  const uint8_t* take(size_t size) {
    if (!good_ || at_ > size_ || size > size_ - at_) {
      good_ = false;
      return nullptr;
    }
    at_ += size;
    return data_ + at_ - size;
  }
  void align(size_t size) { at_ += (size - (at_ - kEncapsulation) % size) % size; }
  // Zero when the bytes could not hold so many of this size.
  uint32_t read_count(size_t size_of_one) {
    uint32_t count = 0;
    integer(count);
    if (good_ && count > (size_ - at_) / size_of_one) good_ = false;
    return good_ ? count : 0;
  }

  const uint8_t* data_;
  size_t size_;
  size_t at_ = 0;
  bool good_ = false;
};

// Fields in the order of the IDL files.

template <typename Archive>
void visit(Archive& archive, msg::RobotState& m) {
  archive.template block<3>(m.header());
  archive.template block<7>(m.X_WB());
  archive.template block<6>(m.V_WB());
  archive.numbers(m.positions());
  archive.numbers(m.velocities());
  archive.numbers(m.efforts());
  archive.template block<1>(m.hash());
  archive.sequence(m.objects(), [&](msg::ObjectState& object) {
    archive.text(object.name());
    archive.template block<7>(object.X_WO());
    archive.template block<6>(object.V_WO());
  });
  archive.sequence(m.robots(), [&](msg::OtherRobotState& robot) {
    archive.text(robot.name());
    archive.template block<7>(robot.X_WB());
    archive.template block<6>(robot.V_WB());
    archive.numbers(robot.positions());
    archive.numbers(robot.velocities());
    archive.numbers(robot.efforts());
  });
  archive.sequence(m.pushes(), [&](msg::PushForce& push) {
    archive.text(push.name());
    archive.text(push.link());
    archive.template block<3>(push.p_LQ());
    archive.template block<3>(push.force());
  });
}

template <typename Archive>
void visit(Archive& archive, msg::PointForce& m) {
  archive.template block<3>(m.p_WC());
  archive.template block<3>(m.n_BA_W());
  archive.template block<1>(m.depth());
  archive.template block<3>(m.spring());
  archive.template block<3>(m.damper());
  archive.template block<3>(m.friction());
  archive.template block<3>(m.total());
  archive.template block<3>(m.slip());
  archive.flag(m.clipped());
}

template <typename Archive>
void visit(Archive& archive, msg::ContactForces& m) {
  archive.template block<3>(m.header());
  archive.sequence(m.pairs(), [&](msg::PairForce& pair) {
    archive.integer(pair.body_a());
    archive.integer(pair.body_b());
    archive.text(pair.name_a());
    archive.text(pair.name_b());
    archive.template block<3>(pair.reference());
    archive.template block<6>(pair.spring());
    archive.template block<6>(pair.damper());
    archive.template block<6>(pair.friction());
    archive.template block<6>(pair.total());
    archive.flag(pair.clipped());
    archive.sequence(pair.points(), [&](msg::PointForce& point) { visit(archive, point); });
  });
}

template <typename Archive>
void visit(Archive& archive, msg::ContactSet& m) {
  archive.template block<3>(m.header());
  archive.sequence(m.pairs(), [&](msg::ContactPair& pair) {
    archive.integer(pair.body_a());
    archive.integer(pair.body_b());
    archive.text(pair.name_a());
    archive.text(pair.name_b());
    archive.sequence(pair.points(), [&](msg::ContactPoint& point) {
      archive.template block<3>(point.p_WC());
      archive.template block<3>(point.n_BA_W());
      archive.template block<1>(point.depth());
    });
    archive.template block<3>(pair.separation());
    archive.template block<3>(pair.separation_turn());
    archive.template block<3>(pair.reference());
    archive.template block<1>(pair.friction());
  });
}

template <typename Archive>
void visit(Archive& archive, msg::SensorData& m) {
  archive.template block<3>(m.header());
  archive.numbers(m.positions());
  archive.numbers(m.velocities());
  archive.numbers(m.efforts());
  archive.sequence(m.imus(), [&](msg::ImuSample& imu) {
    archive.text(imu.name());
    archive.template block<4>(imu.orientation());
    archive.template block<3>(imu.angular_velocity());
    archive.template block<3>(imu.linear_acceleration());
  });
  archive.sequence(m.wrenches(), [&](msg::WrenchSample& wrench) {
    archive.text(wrench.name());
    archive.template block<3>(wrench.force());
    archive.template block<3>(wrench.torque());
  });
  archive.sequence(m.base_pose(), [&](msg::Pose& pose) { archive.template block<7>(pose); });
  archive.sequence(m.base_twist(), [&](msg::Twist& twist) { archive.template block<6>(twist); });
}

template <typename Archive>
void visit(Archive& archive, msg::JointCommands& m) {
  archive.template block<3>(m.header());
  archive.numbers(m.positions());
  archive.numbers(m.velocities());
  archive.numbers(m.efforts());
}

// Generated accessors give references of messages that are not const only; an Encoder changes nothing.
template <typename Message>
Bytes encode_in_blocks(const Message& message, std::vector<char>* buffer) {
  Encoder encoder(buffer);
  visit(encoder, const_cast<Message&>(message));
  return encoder.finish();
}

template <typename Message>
void decode_in_blocks(Bytes sample, Message* message) {
  Decoder decoder(sample);
  if (decoder.good()) visit(decoder, *message);
  if (!decoder.good()) decode<Message>(sample, message);
}

}  // namespace

Bytes encode(const msg::RobotState& message, std::vector<char>* buffer) { return encode_in_blocks(message, buffer); }
Bytes encode(const msg::ContactForces& message, std::vector<char>* buffer) { return encode_in_blocks(message, buffer); }
Bytes encode(const msg::ContactSet& message, std::vector<char>* buffer) { return encode_in_blocks(message, buffer); }
Bytes encode(const msg::SensorData& message, std::vector<char>* buffer) { return encode_in_blocks(message, buffer); }
Bytes encode(const msg::JointCommands& message, std::vector<char>* buffer) { return encode_in_blocks(message, buffer); }

void decode(Bytes sample, msg::RobotState* message) { decode_in_blocks(sample, message); }
void decode(Bytes sample, msg::ContactForces* message) { decode_in_blocks(sample, message); }
void decode(Bytes sample, msg::ContactSet* message) { decode_in_blocks(sample, message); }
void decode(Bytes sample, msg::SensorData* message) { decode_in_blocks(sample, message); }
void decode(Bytes sample, msg::JointCommands* message) { decode_in_blocks(sample, message); }

}  // namespace hrp

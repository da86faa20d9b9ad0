// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/format.h"

namespace hrp::mcap {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they lie in memory");

using CrcTables = std::array<std::array<uint32_t, 256>, 8>;

constexpr CrcTables make_crc_tables() {
  CrcTables tables{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xEDB88320u : 0u);
    tables[0][i] = crc;
  }
  for (size_t slice = 1; slice < 8; ++slice) {
    for (size_t i = 0; i < 256; ++i) {
      const uint32_t previous = tables[slice - 1][i];
      tables[slice][i] = (previous >> 8) ^ tables[0][previous & 0xFF];
    }
  }
  return tables;
}

constexpr CrcTables kCrc = make_crc_tables();

}  // namespace

// Eight bytes at a time (slicing-by-8, Kounavis and Berry 2005): the checksum must not cost more than the compression.
uint32_t update_crc(uint32_t crc, const uint8_t* data, size_t size) {
  crc = ~crc;
  for (; size >= 8; size -= 8, data += 8) {
    uint32_t low, high;
    std::memcpy(&low, data, 4);
    std::memcpy(&high, data + 4, 4);
    low ^= crc;
    crc = kCrc[7][low & 0xFF] ^ kCrc[6][(low >> 8) & 0xFF] ^ kCrc[5][(low >> 16) & 0xFF] ^ kCrc[4][low >> 24] ^
          kCrc[3][high & 0xFF] ^ kCrc[2][(high >> 8) & 0xFF] ^ kCrc[1][(high >> 16) & 0xFF] ^ kCrc[0][high >> 24];
  }
  for (; size > 0; --size, ++data) crc = (crc >> 8) ^ kCrc[0][(crc ^ *data) & 0xFF];
  return ~crc;
}

void put_schema(const Schema& schema, Buffer* out) {
  const size_t begin = out->begin_record(Opcode::kSchema);
  out->put(schema.id);
  out->put_string(schema.name);
  out->put_string(schema.encoding);
  out->put_string(schema.text);
  out->end_record(begin);
}

void put_channel(const Channel& channel, Buffer* out) {
  const size_t begin = out->begin_record(Opcode::kChannel);
  out->put(channel.id);
  out->put(channel.schema_id);
  out->put_string(channel.topic);
  out->put_string(channel.message_encoding);
  const size_t map_begin = out->size() + 4;
  out->put(uint32_t{0});
  for (const auto& [key, value] : channel.metadata) {
    out->put_string(key);
    out->put_string(value);
  }
  out->set(map_begin - 4, static_cast<uint32_t>(out->size() - map_begin));
  out->end_record(begin);
}

bool get_schema(Cursor cursor, Schema* schema) {
  schema->id = cursor.get<uint16_t>();
  schema->name = cursor.get_string();
  schema->encoding = cursor.get_string();
  schema->text = cursor.get_string();
  // Nothing may follow: a damaged length would swallow the records behind.
  return cursor.ok() && schema->id != 0 && cursor.remaining() == 0;
}

bool get_channel(Cursor cursor, Channel* channel) {
  channel->id = cursor.get<uint16_t>();
  channel->schema_id = cursor.get<uint16_t>();
  channel->topic = cursor.get_string();
  channel->message_encoding = cursor.get_string();
  const size_t map_size = cursor.get<uint32_t>();
  if (!cursor.ok() || map_size != cursor.remaining()) return false;
  const size_t map_end = cursor.position() + map_size;
  while (cursor.ok() && cursor.position() < map_end) {
    std::string key = cursor.get_string();
    channel->metadata[key] = cursor.get_string();
  }
  return cursor.ok() && cursor.position() == map_end;
}

}  // namespace hrp::mcap

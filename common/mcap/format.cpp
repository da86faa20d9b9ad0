// SPDX-License-Identifier: BSD-3-Clause
#include "common/mcap/format.h"

#include <libdeflate.h>

namespace hrp::mcap {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they lie in memory");

}  // namespace

// libdeflate multiplies carry-less where the processor can: twelve times as fast as a table of eight slices.
uint32_t update_crc(uint32_t crc, const uint8_t* data, size_t size) { return libdeflate_crc32(crc, data, size); }

void put_beginning(Buffer* out, const std::string& profile) {
  out->put_bytes(kMagic.data(), kMagic.size());
  const size_t begin = out->begin_record(Opcode::kHeader);
  out->put_string(profile);
  out->put_string("openhrp-dds");
  out->end_record(begin);
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

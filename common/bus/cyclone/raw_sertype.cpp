// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/cyclone/raw_sertype.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/q_radmin.h>

namespace hrp {
namespace {

constexpr size_t kHeaderSize = 4;  // representation identifier and options

// A serdata with its bytes behind it, in one block of memory.
struct RawSample {
  ddsi_serdata c;  // must be first: Cyclone knows this part only
  uint32_t size;   // multiple of 4
  alignas(8) uint8_t bytes[8];
};

RawSample* as_raw(ddsi_serdata* sample) { return reinterpret_cast<RawSample*>(sample); }
const RawSample* as_raw(const ddsi_serdata* sample) { return reinterpret_cast<const RawSample*>(sample); }

RawSample* allocate(const ddsi_sertype* type, ddsi_serdata_kind kind, size_t size) {
  const size_t padded = (size + 3) & ~size_t{3};
  void* memory = std::malloc(sizeof(RawSample) + padded);
  if (!memory) throw std::bad_alloc();
  RawSample* sample = static_cast<RawSample*>(memory);
  std::memset(static_cast<void*>(&sample->c), 0, sizeof(sample->c));
  ddsi_serdata_init(&sample->c, type, kind);
  sample->c.hash = type->serdata_basehash;  // keyless: one instance
  sample->size = static_cast<uint32_t>(padded);
  if (padded > size) std::memset(sample->bytes + size, 0, padded - size);
  return sample;
}

// The options of the header count padding with some writers; without them equal messages are equal bytes.
ddsi_serdata* finish(RawSample* sample) {
  if (sample->size >= kHeaderSize) sample->bytes[2] = sample->bytes[3] = 0;
  return &sample->c;
}

bool serdata_eqkey(const ddsi_serdata*, const ddsi_serdata*) { return true; }

uint32_t serdata_size(const ddsi_serdata* sample) { return as_raw(sample)->size; }

ddsi_serdata* serdata_from_ser(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                               size_t size) {
  RawSample* sample = allocate(type, kind, size);
  uint32_t done = 0;
  for (; fragment; fragment = fragment->nextfrag) {
    if (fragment->maxp1 <= done) continue;  // fragments may overlap
    const unsigned char* payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    const size_t end = fragment->maxp1 < size ? fragment->maxp1 : size;
    if (end > done) std::memcpy(sample->bytes + done, payload + (done - fragment->min), end - done);
    done = fragment->maxp1;
  }
  return finish(sample);
}

ddsi_serdata* serdata_from_iov(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                               const ddsrt_iovec_t* parts, size_t size) {
  RawSample* sample = allocate(type, kind, size);
  size_t done = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && done < size; ++i) {
    const size_t part = parts[i].iov_len < size - done ? parts[i].iov_len : size - done;
    std::memcpy(sample->bytes + done, parts[i].iov_base, part);
    done += part;
  }
  return finish(sample);
}

ddsi_serdata* serdata_from_keyhash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return &allocate(type, SDK_KEY, 0)->c;
}

// Only Cyclone's typed functions (dds_write, dds_dispose) come here, with nothing to translate.
ddsi_serdata* serdata_from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void*) {
  return kind == SDK_DATA ? nullptr : &allocate(type, kind, 0)->c;
}

void serdata_to_ser(const ddsi_serdata* sample, size_t offset, size_t size, void* out) {
  std::memcpy(out, as_raw(sample)->bytes + offset, size);
}

ddsi_serdata* serdata_to_ser_ref(const ddsi_serdata* sample, size_t offset, size_t size, ddsrt_iovec_t* part) {
  part->iov_base = const_cast<uint8_t*>(as_raw(sample)->bytes) + offset;
  part->iov_len = size;
  return ddsi_serdata_ref(sample);
}

void serdata_to_ser_unref(ddsi_serdata* sample, const ddsrt_iovec_t*) { ddsi_serdata_unref(sample); }

bool serdata_to_sample(const ddsi_serdata*, void*, void**, void*) { return false; }

ddsi_serdata* serdata_to_untyped(const ddsi_serdata* sample) {
  RawSample* untyped = allocate(sample->type, SDK_KEY, 0);
  untyped->c.type = nullptr;
  return &untyped->c;
}

bool serdata_untyped_to_sample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return true; }

void serdata_free(ddsi_serdata* sample) { std::free(as_raw(sample)); }

size_t serdata_print(const ddsi_sertype*, const ddsi_serdata* sample, char* text, size_t size) {
  return static_cast<size_t>(std::snprintf(text, size, "(%u bytes)", as_raw(sample)->size));
}

void serdata_keyhash(const ddsi_serdata*, ddsi_keyhash* hash, bool) { std::memset(hash, 0, sizeof(*hash)); }

ddsi_serdata_ops make_serdata_ops() {
  ddsi_serdata_ops ops;
  std::memset(&ops, 0, sizeof(ops));  // shared-memory functions stay empty
  ops.eqkey = serdata_eqkey;
  ops.get_size = serdata_size;
  ops.from_ser = serdata_from_ser;
  ops.from_ser_iov = serdata_from_iov;
  ops.from_keyhash = serdata_from_keyhash;
  ops.from_sample = serdata_from_sample;
  ops.to_ser = serdata_to_ser;
  ops.to_ser_ref = serdata_to_ser_ref;
  ops.to_ser_unref = serdata_to_ser_unref;
  ops.to_sample = serdata_to_sample;
  ops.to_untyped = serdata_to_untyped;
  ops.untyped_to_sample = serdata_untyped_to_sample;
  ops.free = serdata_free;
  ops.print = serdata_print;
  ops.get_keyhash = serdata_keyhash;
  return ops;
}

void sertype_free(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  std::free(type);
}

void sertype_zero_samples(const ddsi_sertype*, void*, size_t) {}
void sertype_realloc_samples(void**, const ddsi_sertype*, void*, size_t, size_t) {}
void sertype_free_samples(const ddsi_sertype*, void**, size_t, dds_free_op_t) {}
bool sertype_equal(const ddsi_sertype*, const ddsi_sertype*) { return true; }
uint32_t sertype_hash(const ddsi_sertype*) { return 0; }

ddsi_sertype_ops make_sertype_ops() {
  ddsi_sertype_ops ops;
  std::memset(&ops, 0, sizeof(ops));  // no type information is announced: Fast DDS and ROS 2 announce none either
  ops.version = ddsi_sertype_v0;
  ops.free = sertype_free;
  ops.zero_samples = sertype_zero_samples;
  ops.realloc_samples = sertype_realloc_samples;
  ops.free_samples = sertype_free_samples;
  ops.equal = sertype_equal;
  ops.hash = sertype_hash;
  return ops;
}

}  // namespace

ddsi_sertype* make_raw_sertype(const char* type_name) {
  static const ddsi_serdata_ops serdata_ops = make_serdata_ops();
  static const ddsi_sertype_ops sertype_ops = make_sertype_ops();
  auto* type = static_cast<ddsi_sertype*>(std::calloc(1, sizeof(ddsi_sertype)));
  if (!type) throw std::bad_alloc();
  ddsi_sertype_init_flags(type, type_name, &sertype_ops, &serdata_ops, DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

ddsi_serdata* make_raw_sample(const ddsi_sertype* type, Bytes sample) {
  RawSample* raw = allocate(type, SDK_DATA, sample.size);
  std::memcpy(raw->bytes, sample.data, sample.size);
  return &raw->c;
}

Bytes get_raw_bytes(const ddsi_serdata* sample) { return {as_raw(sample)->bytes, as_raw(sample)->size}; }

}  // namespace hrp

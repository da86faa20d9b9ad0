// SPDX-License-Identifier: BSD-3-Clause
// A Cyclone DDS type that carries encoded samples as they are: no translation to C structs, no check of the content,
// one copy on either side. Cyclone's own sertypes would re-encode, and there is no public way to their raw bytes.
#pragma once

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include "common/bus/bus.h"

namespace hrp {

// The caller owns the reference; dds_create_topic_sertype takes it over.
ddsi_sertype* make_raw_sertype(const char* type_name);

// A sample to write. The caller owns the reference; dds_writecdr takes it over.
ddsi_serdata* make_raw_sample(const ddsi_sertype* type, Bytes sample);

// The bytes of a sample that a reader of a raw type took; they live as long as the sample.
Bytes get_raw_bytes(const ddsi_serdata* sample);

}  // namespace hrp

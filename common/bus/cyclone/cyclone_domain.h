// SPDX-License-Identifier: BSD-3-Clause
// A Cyclone DDS domain with our network settings. Cyclone knows each domain once in a process, so it is shared.
#pragma once

#include <memory>

#include <dds/dds.h>

#include "common/bus/make_bus.h"

namespace hrp {

class CycloneDomain {
 public:
  // Buses of one process on one domain share its settings: the first one's options count.
  static std::shared_ptr<CycloneDomain> find_or_make(const BusOptions& options);
  ~CycloneDomain();

 private:
  explicit CycloneDomain(const BusOptions& options);
  dds_entity_t entity_ = 0;
};

}  // namespace hrp

// SPDX-License-Identifier: BSD-3-Clause
// Our settings of Fast DDS: network, reliability, memory.
#pragma once

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "common/bus/bus.h"
#include "common/bus/make_bus.h"

namespace hrp {

// Throws InputError when the options' file holds no profile for us.
eprosima::fastdds::dds::DomainParticipantQos make_participant_qos(const BusOptions& options);
eprosima::fastdds::dds::DataWriterQos make_fast_writer_qos(const TopicSpec& topic);
eprosima::fastdds::dds::DataReaderQos make_fast_reader_qos(const TopicSpec& topic, Delivery delivery);

}  // namespace hrp

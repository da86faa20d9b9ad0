// SPDX-License-Identifier: BSD-3-Clause
// The one interface to the outside: topics that carry encoded samples (CDR, little endian, with the 4-byte header).
// Implementations: memory/, cyclone/, fast/. Nothing else in the tree includes a vendor's header.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace hrp {

// The middleware refused something: no free participant index, an address that is not there, a broken security file.
class BusError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class Retention {
  kStream,  // readers get what is written while they are there
  kLatest   // late readers get the last sample of each writer, too
};

struct TopicSpec {
  std::string name;       // "hrp/robot_state"
  std::string type_name;  // "hrp::msg::RobotState"
  Retention retention = Retention::kStream;
  int depth = 1024;  // samples a writer keeps for slow readers
  // No step waits for them: a writer may gather samples until Writer::flush(), and send several as one packet.
  bool gathered = false;
};

enum class Delivery {
  kReliable,   // part of the loop: every sample, in order
  kBestEffort  // inspecting: may miss samples, can never hold up a writer
};

// One sample. Sizes are multiples of 4, as RTPS carries them; encode() sees to that.
struct Bytes {
  const uint8_t* data = nullptr;
  size_t size = 0;
};

class Writer {
 public:
  virtual ~Writer() = default;
  // Sends one encoded sample; never waits for a reader.
  virtual void write(Bytes sample) = 0;
  // Sends what was gathered; whoever writes to a gathered topic calls it often enough for people who look on.
  virtual void flush() {}
  // Somebody reads this topic now (as far as discovery knows).
  virtual bool has_readers() const = 0;
};

// Ends its subscription when destroyed.
class Reader {
 public:
  virtual ~Reader() = default;
};

using SampleCallback = std::function<void(Bytes)>;

// A service as rmw maps those of ROS 2 on DDS: requests on rq/<name>Request, replies on rr/<name>Reply.
struct ServiceSpec {
  std::string name;       // "run/pause"
  std::string type_name;  // "std_srvs::srv::dds_::Trigger": its ends carry <type>_Request_ and <type>_Response_
};

TopicSpec find_request_topic(const ServiceSpec& service);
TopicSpec find_reply_topic(const ServiceSpec& service);

// Ends its service when destroyed.
class Service {
 public:
  virtual ~Service() = default;
};

// The encoded request in, the encoded reply out; no bytes: no reply. They live until the next call.
using ServiceCallback = std::function<Bytes(Bytes)>;

// A topic that some writer on the bus offers, ours or foreign.
struct TopicSeen {
  std::string name;
  std::string type_name;
  int writers = 0;
  int readers = 0;
};

// All callbacks of one bus run one at a time, under mutex(). Code outside callbacks that shares their data locks it
// too. Readers and writers are destroyed before their bus. Make and destroy them without holding mutex(): Fast DDS
// keeps locks of its own while a callback waits for it.
class Bus {
 public:
  virtual ~Bus() = default;
  virtual std::unique_ptr<Writer> make_writer(const TopicSpec& topic) = 0;
  // `callback` runs on a thread of the bus (memory bus: in dispatch()). It may write, it may not make or destroy
  // readers and writers.
  virtual std::unique_ptr<Reader> make_reader(const TopicSpec& topic, Delivery delivery, SampleCallback callback) = 0;
  // How a reply finds its request differs by vendor, and so do the clients that are heard (docs/tutorials/ros2.md).
  // This one is that of rmw_cyclonedds: 16 bytes in front of request and reply, which the client chooses.
  virtual std::unique_ptr<Service> make_service(const ServiceSpec& service, ServiceCallback callback);
  virtual std::vector<TopicSeen> find_topics() = 0;
  // "cyclone", "fast" or "memory".
  virtual std::string vendor() const = 0;
  // Lets callbacks run for up to `timeout`. DDS buses deliver on their own threads and only sleep here.
  virtual void spin(std::chrono::milliseconds timeout) = 0;
  std::recursive_mutex& mutex() { return mutex_; }

 private:
  std::recursive_mutex mutex_;
};

}  // namespace hrp

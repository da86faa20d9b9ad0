// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/ros_definitions.h"

#include <openssl/evp.h>

#include <cctype>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "common/base/join_words.h"

namespace hrp {
namespace {

// Field for field the messages of ROS 2 Humble to Jazzy that hold motions of robots; bags of sqlite3 before Iron carry
// no definitions.
const std::map<std::string, const char*>& get_built_in() {
  static const std::map<std::string, const char*> types{
      {"builtin_interfaces/msg/Time", "int32 sec\nuint32 nanosec\n"},
      {"builtin_interfaces/msg/Duration", "int32 sec\nuint32 nanosec\n"},
      {"std_msgs/msg/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
      {"std_msgs/msg/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n"},
      {"std_msgs/msg/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset\n"},
      {"std_msgs/msg/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data\n"},
      {"std_msgs/msg/Float32MultiArray", "MultiArrayLayout layout\nfloat32[] data\n"},
      {"std_msgs/msg/Float64", "float64 data\n"},
      {"geometry_msgs/msg/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/msg/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/msg/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
      {"geometry_msgs/msg/Pose", "Point position\nQuaternion orientation\n"},
      {"geometry_msgs/msg/PoseStamped", "std_msgs/Header header\nPose pose\n"},
      {"geometry_msgs/msg/PoseWithCovariance", "Pose pose\nfloat64[36] covariance\n"},
      {"geometry_msgs/msg/Twist", "Vector3 linear\nVector3 angular\n"},
      {"geometry_msgs/msg/TwistWithCovariance", "Twist twist\nfloat64[36] covariance\n"},
      {"geometry_msgs/msg/Wrench", "Vector3 force\nVector3 torque\n"},
      {"geometry_msgs/msg/WrenchStamped", "std_msgs/Header header\nWrench wrench\n"},
      {"nav_msgs/msg/Odometry",
       "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
       "geometry_msgs/TwistWithCovariance twist\n"},
      {"sensor_msgs/msg/JointState",
       "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"},
      {"sensor_msgs/msg/Imu",
       "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
       "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
       "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"},
      {"sensor_msgs/msg/Image",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] "
       "data\n"},
      {"sensor_msgs/msg/RegionOfInterest",
       "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"},
      {"sensor_msgs/msg/CameraInfo",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] "
       "k\nfloat64[9] r\n"
       "float64[12] p\nuint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n"},
      {"sensor_msgs/msg/PointField", "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"},
      {"sensor_msgs/msg/PointCloud2",
       "std_msgs/Header header\nuint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\nuint32 "
       "point_step\n"
       "uint32 row_step\nuint8[] data\nbool is_dense\n"},
      {"trajectory_msgs/msg/JointTrajectoryPoint",
       "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
       "builtin_interfaces/Duration time_from_start\n"},
      {"trajectory_msgs/msg/JointTrajectory",
       "std_msgs/Header header\nstring[] joint_names\nJointTrajectoryPoint[] points\n"},
      {"std_msgs/msg/String", "string data\n"},
      {"rosgraph_msgs/msg/Clock", "builtin_interfaces/Time clock\n"},
      {"geometry_msgs/msg/Point32", "float32 x\nfloat32 y\nfloat32 z\n"},
      {"geometry_msgs/msg/PointStamped", "std_msgs/Header header\nPoint point\n"},
      {"geometry_msgs/msg/Polygon", "Point32[] points\n"},
      {"geometry_msgs/msg/PolygonStamped", "std_msgs/Header header\nPolygon polygon\n"},
      {"geometry_msgs/msg/Transform", "Vector3 translation\nQuaternion rotation\n"},
      {"geometry_msgs/msg/TransformStamped", "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"},
      {"tf2_msgs/msg/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
      // What a service sends. IDL has no empty struct, so that of an empty request is given a byte.
      {"std_srvs/srv/Trigger_Request", "uint8 structure_needs_at_least_one_member\n"},
      {"std_srvs/srv/Trigger_Response", "bool success\nstring message\n"},
      {"std_srvs/srv/SetBool_Request", "bool data\n"},
      {"std_srvs/srv/SetBool_Response", "bool success\nstring message\n"}};
  return types;
}

// As in type_description_interfaces/msg/FieldType.
int find_type_id(const std::string& base) {
  static const std::map<std::string, int> ids{
      {"int8", 2},   {"uint8", 3},    {"int16", 4},    {"uint16", 5}, {"int32", 6}, {"uint32", 7}, {"int64", 8},
      {"uint64", 9}, {"float32", 10}, {"float64", 11}, {"char", 13},  {"bool", 15}, {"byte", 16},  {"string", 17}};
  const auto found = ids.find(base);
  return found == ids.end() ? 1 : found->second;  // 1: another message
}

constexpr int kArrayOffset = 48, kSequenceOffset = 144;

RosField parse_field(const std::string& package, const std::string& type, const std::string& name) {
  RosField field{type, name, type.substr(0, type.find('[')), false, false, 0};
  const size_t bracket = type.find('[');
  if (bracket != std::string::npos) {
    const std::string size = type.substr(bracket + 1, type.find(']') - bracket - 1);
    field.is_sequence = size.empty();
    if (!size.empty()) field.array_size = std::stoul(size);
  }
  field.is_message = find_type_id(field.base) == 1;
  if (field.is_message) {
    field.base = field.base.find('/') == std::string::npos ? package + "/msg/" + field.base : find_ros_name(field.base);
  }
  return field;
}

// All messages that a type needs, itself not.
void collect_needs(const std::string& name, std::set<std::string>* found) {
  for (const RosField& field : parse_ros_definition(name)) {
    if (field.is_message && found->insert(field.base).second) collect_needs(field.base, found);
  }
}

std::string describe_field(const RosField& field) {
  const int offset = field.is_sequence ? kSequenceOffset : field.array_size > 0 ? kArrayOffset : 0;
  std::ostringstream json;
  json << "{\"name\": \"" << field.name
       << "\", \"type\": {\"type_id\": " << find_type_id(field.is_message ? "" : field.base) + offset
       << ", \"capacity\": " << field.array_size << ", \"string_capacity\": 0, \"nested_type_name\": \""
       << (field.is_message ? field.base : "") << "\"}}";
  return json.str();
}

std::string describe_type(const std::string& name) {
  return "{\"type_name\": \"" + name + "\", \"fields\": [" + join_words(parse_ros_definition(name), describe_field) +
         "]}";
}

}  // namespace

const char* find_ros_definition(const std::string& name) {
  const auto found = get_built_in().find(name);
  return found == get_built_in().end() ? nullptr : found->second;
}

std::vector<RosField> parse_ros_definition(const std::string& name) {
  const char* definition = find_ros_definition(name);
  if (definition == nullptr) throw std::runtime_error("no definition of the type " + name);
  std::vector<RosField> fields;
  std::istringstream words(definition);
  std::string type, field;
  while (words >> type >> field) fields.push_back(parse_field(name.substr(0, name.find('/')), type, field));
  return fields;
}

std::string make_ros_schema(const std::string& name) {
  std::set<std::string> needs;
  collect_needs(name, &needs);
  std::string text = find_ros_definition(name);
  for (const std::string& need : needs) {
    text += std::string(80, '=') + "\nMSG: " + need.substr(0, need.find('/')) + need.substr(need.rfind('/')) + "\n";
    text += find_ros_definition(need);
  }
  return text;
}

// SHA-256 of the description in JSON as Python's json.dumps writes it, without default values.
std::string calc_ros_type_hash(const std::string& name) {
  std::set<std::string> needs;  // in the order of their names, as the description wants them
  collect_needs(name, &needs);
  const std::string text = "{\"type_description\": " + describe_type(name) + ", \"referenced_type_descriptions\": [" +
                           join_words(needs, describe_type) + "]}";
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  if (EVP_Digest(text.data(), text.size(), digest, &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("no SHA-256");
  std::string hash = "RIHS01_";
  for (unsigned i = 0; i < size; ++i) {
    constexpr char kDigits[] = "0123456789abcdef";
    hash += kDigits[digest[i] >> 4];
    hash += kDigits[digest[i] & 15];
  }
  return hash;
}

std::string make_ros_user_data(const std::string& dds_type_name) {
  if (dds_type_name.find("::dds_::") == std::string::npos) return "";
  const std::string name = find_ros_name(dds_type_name);
  return find_ros_definition(name) == nullptr ? "" : "typehash=" + calc_ros_type_hash(name) + ";";
}

std::string find_ros_name(const std::string& name) {
  std::string out;
  for (size_t i = 0; i < name.size(); ++i) {
    if (name.compare(i, 2, "::") == 0) {
      out += '/';
      ++i;
    } else if (!std::isspace(static_cast<unsigned char>(name[i])))
      out += name[i];
  }
  const size_t dds = out.find("/dds_/");
  if (dds != std::string::npos) {
    out.erase(dds, 5);
    if (!out.empty() && out.back() == '_') out.pop_back();
  }
  const size_t slash = out.find('/');
  if (slash != std::string::npos && out.find('/', slash + 1) == std::string::npos) out.insert(slash, "/msg");
  return out;
}

}  // namespace hrp

# find_package(openhrp_dds): openhrp_dds::controller (a controller of one's own: controller/client.h), ::idl (the messages
# and their codec), ::multibody (dynamics of trees) and ::log (logs of runs as tables).
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Eigen3 3.4)
find_dependency(fastcdr)
find_dependency(fastrtps)
find_dependency(CycloneDDS)
find_dependency(CLI11)
find_dependency(OpenSSL COMPONENTS Crypto)
find_dependency(yaml-cpp)
include(${CMAKE_CURRENT_LIST_DIR}/openhrp_ddsTargets.cmake)

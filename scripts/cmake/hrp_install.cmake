# What `cmake --install` puts where. Programs are installed by hrp_program(). `hrp-simulate NAME` finds the scenarios that are
# installed here, and hrp-viewer its page, relative to their own place: the folder can be moved.
set(share ${CMAKE_INSTALL_DATADIR}/openhrp_dds)
install(DIRECTORY models/ DESTINATION ${share}/models)
install(DIRECTORY idl/ DESTINATION ${share}/idl FILES_MATCHING PATTERN "*.idl" PATTERN "*.md" PATTERN "example_c/*")
install(DIRECTORY controller/template/ DESTINATION ${share}/controller_template)
install(DIRECTORY scripts/sweep/ DESTINATION ${share}/sweep FILES_MATCHING PATTERN "*.py")
install(PROGRAMS scripts/sweep/hrp-sweep DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY share/foxglove DESTINATION ${share})
file(COPY share/foxglove DESTINATION ${CMAKE_BINARY_DIR}/share)
install(DIRECTORY ${CMAKE_BINARY_DIR}/share/viewer DESTINATION ${share} OPTIONAL)  # scripts/build_page.sh makes it

# For programs of one's own: find_package(openhrp_dds), then openhrp_dds::controller, ::idl, ::multibody or ::log.
install(DIRECTORY common DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/openhrp_dds FILES_MATCHING PATTERN "*.h")
install(FILES controller/client.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/openhrp_dds/controller)
install(DIRECTORY ${CMAKE_BINARY_DIR}/idl/cpp/hrp_idl DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/openhrp_dds/generated
        FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp" PATTERN "*.ipp")
set(public_targets controller:hrp_controller_client idl:hrp_message_codec multibody:hrp_multibody log:hrp_log_table)
# What those link; CMake refuses to export them when one is missing here.
set(HRP_EXPORTED hrp_base hrp_ros_definitions hrp_frames hrp_spatial hrp_effects hrp_robot hrp_messages hrp_reflection hrp_convert hrp_bus hrp_secure_folder hrp_bus_memory hrp_bus_cyclone
    hrp_bus_fast hrp_runs hrp_make_bus hrp_mcap hrp_run_token hrp_node hrp_join hrp_server_main)
foreach(pair IN LISTS public_targets)
  string(REPLACE ":" ";" pair ${pair})
  list(GET pair 0 name)
  list(GET pair 1 target)
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  add_library(openhrp_dds::${name} ALIAS ${target})  # the same name within this tree
  list(APPEND HRP_EXPORTED ${target})
endforeach()
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/openhrp_dds)
install(TARGETS ${HRP_EXPORTED} EXPORT openhrp_dds_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/openhrp_dds)
install(EXPORT openhrp_dds_targets NAMESPACE openhrp_dds:: FILE openhrp_ddsTargets.cmake DESTINATION ${package_dir})
include(CMakePackageConfigHelpers)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/openhrp_ddsConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES scripts/cmake/openhrp_ddsConfig.cmake ${CMAKE_BINARY_DIR}/openhrp_ddsConfigVersion.cmake
        DESTINATION ${package_dir})

# cpack -G DEB: one package. Libraries that the programs load become its dependencies; what is needed to compile a controller
# against it is recommended (apt installs it by default).
set(CPACK_PACKAGE_NAME openhrp-dds)
set(CPACK_PACKAGE_VENDOR openhrp-dds)
set(CPACK_PACKAGE_CONTACT "the openhrp-dds developers <openhrp-dds@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Dynamics simulation of humanoid robots as servers over DDS")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
string(JOIN ", " CPACK_DEBIAN_PACKAGE_RECOMMENDS cmake g++ make libeigen3-dev libcli11-dev libyaml-cpp-dev libfastcdr-dev
       libfastrtps-dev cyclonedds-dev libssl-dev libzstd-dev liblz4-dev libdeflate-dev python3-numpy python3-yaml)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS python3-distributed)
include(CPack)

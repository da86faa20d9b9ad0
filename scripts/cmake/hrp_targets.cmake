# One line a target. All include paths start at the top of the tree ("common/bus/bus.h").

# Headers that most sources need and that take longer to read than the sources are read once: a third of a clean build.
# Sources still include what they use: -DHRP_PRECOMPILE=OFF builds without.
option(HRP_PRECOMPILE "Eigen and GoogleTest as precompiled headers" ON)

# hrp_precompiled(name [OPTIONS -O1] HEADERS <a> ... LINK x ...): for hrp_precompile() of targets below. A precompiled
# header brings the optimisation that it was made with (measured: GCC 12 takes it from there, whatever a source asks for).
function(hrp_precompiled name)
  cmake_parse_arguments(ARG "" "" "OPTIONS;HEADERS;LINK" ${ARGN})
  if(NOT HRP_PRECOMPILE)
    return()
  endif()
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

function(hrp_precompile target name)
  if(HRP_PRECOMPILE AND TARGET ${name})
    target_precompile_headers(${target} REUSE_FROM ${name})
  endif()
endfunction()

# hrp_quick(target headers): little optimisation, for code that runs once (command lines) or checks results (tests). It
# takes a quarter off the time to compile. Never for what computes states: see hrp_library.
set(HRP_QUICK -O1)
function(hrp_quick target headers)
  target_compile_options(${target} PRIVATE ${HRP_QUICK})
  hrp_precompile(${target} ${headers})
endfunction()

# For code that steps no simulation (diagnosis, viewer): takes a quarter off the time to compile. Results are the same to the
# bit: no option here changes values.
set(HRP_MEDIUM -O2)
function(hrp_medium target)
  target_compile_options(${target} PRIVATE ${HRP_MEDIUM})
  hrp_precompile(${target} hrp_eigen_headers)
endfunction()

# hrp_plain(FILE ...): sources of this folder that neither compute nor use Eigen or CLI11. Without the precompiled header,
# whose own objects cost a second in each file, and with little optimisation they take half of the time to compile.
function(hrp_plain)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_PRECOMPILE_HEADERS ON COMPILE_OPTIONS "${HRP_QUICK}")
endfunction()

# Where #include "common/..." is found: the top of the tree, or of the installed headers.
function(hrp_include_top target scope)
  target_include_directories(${target} ${scope} $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/openhrp_dds>)
  target_compile_features(${target} ${scope} cxx_std_17)
endfunction()

# What the Python module loads is position independent. The programs link the same objects, so both give the same bits.
set(HRP_SHARED_OBJECTS hrp_base hrp_ros_definitions hrp_frames hrp_effects hrp_robot hrp_robot_geometry hrp_messages hrp_message_codec hrp_convert hrp_bus hrp_bus_memory
    hrp_bus_cyclone hrp_bus_fast hrp_runs hrp_make_bus hrp_mcap hrp_log_table hrp_run_token hrp_node hrp_join hrp_server_main
    hrp_dynamics_loop hrp_dynamics_core hrp_dynamics_node hrp_collision hrp_model_parser hrp_controller_client
    hrp_scenario_controller hrp_motion hrp_walking hrp_trial hrp_multibody hrp_regressor)
# Functions are inlined and called as in a program all the same: nobody replaces them at run time.
set(HRP_SHARED_OPTIONS -fPIC -fno-semantic-interposition)

# hrp_library(name [QUICK] SOURCES FILE ... LINK x ... PRIVATE_LINK y ...). QUICK: see hrp_quick().
function(hrp_library name)
  cmake_parse_arguments(ARG "QUICK" "" "SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  hrp_include_top(${name} PUBLIC)
  target_link_libraries(${name} PUBLIC ${ARG_LINK} PRIVATE ${ARG_PRIVATE_LINK})
  if(name IN_LIST HRP_SHARED_OBJECTS)
    target_compile_options(${name} PRIVATE ${HRP_SHARED_OPTIONS})
    if(ARG_QUICK)
      target_compile_options(${name} PRIVATE ${HRP_QUICK})
    else()
      hrp_precompile(${name} hrp_shared_eigen_headers)
    endif()
  elseif(ARG_QUICK)
    hrp_quick(${name} hrp_command_line_headers)
  else()
    hrp_medium(${name})
  endif()
endfunction()

# hrp_headers(name LINK x ...): a library without sources.
function(hrp_headers name)
  cmake_parse_arguments(ARG "" "" "LINK" ${ARGN})
  add_library(${name} INTERFACE)
  hrp_include_top(${name} INTERFACE)
  target_link_libraries(${name} INTERFACE ${ARG_LINK})
endfunction()

# Every program that users run; scripts/build.sh builds this target when no tests are asked for.
add_custom_target(hrp_programs)
# Those that a run needs: the launcher, the servers, and what is run beside them.
add_custom_target(hrp_run_programs)
function(hrp_run_program)
  add_dependencies(hrp_run_programs ${ARGN})
endfunction()

# hrp_program(hrp-thing SOURCES main.cpp LINK x ...). One that links CLI11 has nothing but its command line in its sources:
# what computes is in libraries.
function(hrp_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
  if(CLI11::CLI11 IN_LIST ARG_LINK)
    hrp_quick(${name} hrp_command_line_headers)
  else()
    hrp_medium(${name})
  endif()
  add_dependencies(hrp_programs ${name})
  file(RELATIVE_PATH place ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  if(NOT place MATCHES "^tests" AND NOT name STREQUAL my-controller)
    install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
endfunction()

# Tests of this folder that have no COST begin evenly spread over a run: those of one folder wait for processes, those of
# another compute, and a core is idle where three that wait run at once.
function(hrp_spread_tests)
  get_property(tests DIRECTORY PROPERTY TESTS)
  list(LENGTH tests left)
  math(EXPR step "4000 / (${left} + 1)")  # below 40 [s], in hundredths: longer ones have a COST
  foreach(test IN LISTS tests)
    get_property(cost TEST ${test} PROPERTY COST)
    math(EXPR spread "${left} * ${step} / 100")
    if(NOT cost)
      set_tests_properties(${test} PROPERTIES COST ${spread})
    endif()
    math(EXPR left "${left} - 1")
  endforeach()
endfunction()

# hrp_test(NAME LABEL unit LINK x ...): builds NAME.cpp of this folder with GoogleTest and registers it. COST: seconds that it
# takes, of the longest ones: they start first, so that the last test does not run alone. NIGHTLY: suites with Nightly in their
# name are a test of their own, NAME_nightly, that only `ctest -C nightly` runs.
function(hrp_test name)
  cmake_parse_arguments(ARG "NIGHTLY" "LABEL;TIMEOUT;COST" "LINK;SOURCES" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600) # only ends a test that hangs; a busy machine may take several times as long
  endif()
  if(HRP_SANITIZE)
    set(ARG_TIMEOUT 3600) # the diagnosis takes thirty times as long under the thread sanitizer
  endif()
  add_executable(${name} ${name}.cpp ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} hrp_test_places GTest::gtest GTest::gmock GTest::gtest_main)
  hrp_quick(${name} hrp_test_headers)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(ARG_NIGHTLY)
    add_test(NAME ${name} COMMAND ${name} --gtest_filter=-*Nightly*)
    add_test(NAME ${name}_nightly CONFIGURATIONS nightly COMMAND ${name} --gtest_filter=*Nightly*)
    set_tests_properties(${name}_nightly PROPERTIES LABELS nightly TIMEOUT ${ARG_TIMEOUT})
  else()
    add_test(NAME ${name} COMMAND ${name})
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT})
  if(ARG_COST)
    set_tests_properties(${name} PROPERTIES COST ${ARG_COST})
  endif()
endfunction()

# SPDX-License-Identifier: Apache-2.0
# One library per room, or per floor of one: gyrotherm_room(NAME SOURCES a.cpp … USES other rooms … PRIVATE third parties …)
# makes gyrotherm::NAME, which is installed for others to build on (package.cmake), unless it is one of the programs' own:
# INTERNAL. The rooms in USES are public, third parties stay private to the room. A unity build compiles those of the
# SOURCES that are named in ALONE too by themselves: their own names are another file's as well. A NUMERICAL room does
# without Eigen's checks of every index in what is released.
# GCC 12 warns of array bounds and restrict inside its own std::string; the sanitizer preset watches for the real ones.
function(gyrotherm_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion $<$<BOOL:${GYROTHERM_WERROR}>:-Werror>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread>)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/gyrotherm>)
endfunction()

# What most files of the rooms begin with is compiled once for the room `first`, and the others use it too: those that are
# compiled alike, which a room is not whose third parties ask for more than to be included.
function(gyrotherm_precompile name first)
  if(name STREQUAL first OR "${ARGN}" MATCHES "Qt6|tomlplusplus")
    target_precompile_headers(gyrotherm_${name} PRIVATE <fmt/format.h> <algorithm> <chrono> <functional> <map> <memory> <optional> <string> <vector>)
  else()
    target_precompile_headers(gyrotherm_${name} REUSE_FROM gyrotherm_${first})
  endif()
endfunction()

function(gyrotherm_room name)
  cmake_parse_arguments(room "INTERNAL;NUMERICAL" "" "SOURCES;ALONE;USES;PUBLIC;PRIVATE" ${ARGN})
  add_library(gyrotherm_${name} STATIC ${room_SOURCES})
  add_library(gyrotherm::${name} ALIAS gyrotherm_${name})
  set_source_files_properties(${room_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  gyrotherm_options(gyrotherm_${name})
  if(room_NUMERICAL)
    gyrotherm_precompile(${name} ${name})  # with another's, of the same options, training took a third longer
    if(name STREQUAL "dense")
      target_precompile_headers(gyrotherm_${name} PRIVATE <Eigen/Core>)
    else()
      list(APPEND room_USES dense)
      target_precompile_headers(gyrotherm_${name} PRIVATE <analysis/dense/dense.hpp>)
    endif()
    target_compile_definitions(gyrotherm_${name} PRIVATE $<$<CONFIG:Release>:EIGEN_NO_DEBUG>)
  else()
    gyrotherm_precompile(${name} drivers ${room_PUBLIC} ${room_PRIVATE})
  endif()
  target_link_libraries(gyrotherm_${name} PRIVATE ${room_PRIVATE})
  target_link_libraries(gyrotherm_${name} PUBLIC fmt::fmt ${room_PUBLIC})
  foreach(other IN LISTS room_USES)
    target_link_libraries(gyrotherm_${name} PUBLIC gyrotherm::${other})
  endforeach()
  if(NOT room_INTERNAL)
    gyrotherm_package_room(${name} USES ${room_USES} THIRD_PARTIES fmt::fmt ${room_PUBLIC} ${room_PRIVATE})
  endif()
endfunction()

# A test that computes nothing itself compiles in half the time when it is not optimised; the rooms that it tests are.
function(gyrotherm_unoptimised target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O0>)
endfunction()

# Where files of one target define the same words, each its own, they cannot be compiled as one, as CMAKE_UNITY_BUILD
# has it; other targets can, in a third of the time.
function(gyrotherm_file_by_file target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
endfunction()

# What tests begin with is compiled once, too.
function(gyrotherm_precompile_test name first)
  if(name STREQUAL first)
    target_precompile_headers(${name}_test PRIVATE <gtest/gtest.h> ${ARGN})
  else()
    target_precompile_headers(${name}_test REUSE_FROM ${first}_test)
  endif()
endfunction()

# gyrotherm_test(NAME [COMPUTES [NUMERICAL]] USES rooms … SOURCES … [PRIVATE third parties …] [TOGETHER suites …]) makes
# NAME_test and registers each of its laws with CTest, those of a suite that is named together as one.
function(gyrotherm_test room)
  cmake_parse_arguments(test "COMPUTES;NUMERICAL" "" "USES;SOURCES;PRIVATE;TOGETHER" ${ARGN})
  add_executable(${room}_test ${test_SOURCES})
  gyrotherm_options(${room}_test)
  if(NOT test_COMPUTES)
    gyrotherm_unoptimised(${room}_test)
    gyrotherm_precompile_test(${room} core)
  else()
    # Compiles in three quarters of the time; GCC 12 takes Eigen's vectors for used after they are freed then.
    target_compile_options(${room}_test PRIVATE $<$<CONFIG:Release>:-O1> $<$<CONFIG:Release>:-Wno-use-after-free>)
    if(test_NUMERICAL)
      gyrotherm_precompile_test(${room} analysis <Eigen/Dense> <analysis/dense/dense.hpp>)
    else()
      gyrotherm_precompile_test(${room} ${room})
    endif()
  endif()
  list(TRANSFORM test_USES PREPEND gyrotherm::)
  target_link_libraries(${room}_test PRIVATE ${test_USES} ${test_PRIVATE} GTest::gtest_main)
  target_compile_definitions(${room}_test PRIVATE GYROTHERM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  gyrotherm_discover(${room}_test TOGETHER ${test_TOGETHER})
endfunction()

# gyrotherm_discover(PROGRAM [TOGETHER suites …] [WAITING suites …]) registers each test of a program by itself, but for
# those of the suites that are TOGETHER: what these make for all of their tests takes long, and is made once. A test keeps
# a processor busy, most of the time, unless its suite is WAITING for clocks and other programs; the preset runs as many
# of either side by side as two processors bear, which is 5 where a busy one counts 2, and begins with what waits.
function(gyrotherm_discover program)
  cmake_parse_arguments(suites "" "" "TOGETHER;WAITING" ${ARGN})
  list(TRANSFORM suites_TOGETHER APPEND ".*" OUTPUT_VARIABLE together)
  list(TRANSFORM suites_WAITING APPEND ".*" OUTPUT_VARIABLE waiting)
  list(JOIN waiting ":" only_waiting)
  list(APPEND together ${waiting})
  list(JOIN together ":" others)
  set(alike NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT ${GYROTHERM_TIMEOUT} PROCESSORS)
  gtest_discover_tests(${program} TEST_FILTER "-${others}" ${alike} 2)
  if(only_waiting)
    gtest_discover_tests(${program} TEST_FILTER "${only_waiting}" ${alike} 1 COST 30)
  endif()
  foreach(suite IN LISTS suites_TOGETHER)
    add_test(NAME ${suite} COMMAND ${program} --gtest_filter=${suite}.*)
    set_tests_properties(${suite} PROPERTIES TIMEOUT ${GYROTHERM_TIMEOUT} PROCESSORS 2)
  endforeach()
endfunction()

# A fuzz target: with GYROTHERM_FUZZ a libFuzzer program, which `fuzzers` makes, told of each branch that it takes in the
# rooms (CMakeLists.txt); otherwise a program that replays inputs and a short seeded random run, so that every test run
# exercises it.
function(gyrotherm_fuzz name source)
  add_executable(${name} ${source})
  gyrotherm_options(${name})
  target_link_libraries(${name} PRIVATE ${ARGN})
  if(GYROTHERM_FUZZ)
    target_compile_options(${name} PRIVATE -fsanitize=fuzzer)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer)
    add_dependencies(fuzzers ${name})
  else()
    if(NOT TARGET gyrotherm_fuzz_driver)
      add_library(gyrotherm_fuzz_driver OBJECT ${PROJECT_SOURCE_DIR}/tests/fuzz_driver.cpp)
      gyrotherm_options(gyrotherm_fuzz_driver)
    endif()
    target_link_libraries(${name} PRIVATE gyrotherm_fuzz_driver)
    add_test(NAME Fuzz.${name} COMMAND ${name} $<IF:$<BOOL:${GYROTHERM_NIGHTLY}>,1000000,20000>)
    set_tests_properties(Fuzz.${name} PROPERTIES PROCESSORS 2)
  endif()
endfunction()

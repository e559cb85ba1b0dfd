# SPDX-License-Identifier: Apache-2.0
# gyrotherm_module(NAME SOURCES a.cpp … USES other modules … PRIVATE third parties …) makes the static library
# gyrotherm::NAME of a module, or of a part of one. It is installed for others to build on (package.cmake) unless it is
# INTERNAL to the programs. The modules in USES are public, third parties stay private. In a unity build each of the SOURCES
# named in ALONE is compiled by itself, because another file uses the same local names. A module that COMPUTES has
# its own optimisation; a NUMERICAL one has, too, and leaves out Eigen's index checks in a release.
# GCC 12 warns of array bounds and restrict inside its own std::string; the sanitizer preset checks for the real ones.
function(gyrotherm_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion $<$<BOOL:${GYROTHERM_WERROR}>:-Werror>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread>)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/gyrotherm>)
endfunction()

# Compiles the headers that most sources include once, for the module `first`; modules with the same compile options reuse
# them. Qt and toml++ add options of their own.
function(gyrotherm_precompile name first)
  if(name STREQUAL first OR "${ARGN}" MATCHES "Qt6|tomlplusplus")
    target_precompile_headers(gyrotherm_${name} PRIVATE <fmt/format.h> <algorithm> <chrono> <functional> <map> <memory> <optional> <string> <vector>)
  else()
    target_precompile_headers(gyrotherm_${name} REUSE_FROM gyrotherm_${first})
  endif()
endfunction()

# Compiles the headers of a numerical module. With -O1 the modules share those of `tracking`, except the three with
# options of their own. With -O2 each has its own: training took a third longer with shared ones.
function(gyrotherm_precompile_numerical name)
  if(name STREQUAL "dense")
    gyrotherm_precompile(${name} ${name})
    target_precompile_headers(gyrotherm_${name} PRIVATE <Eigen/Core>)
  elseif(name MATCHES "^(tracking|data|methods|svm)$" OR NOT GYROTHERM_COMPUTING STREQUAL "-O1")
    gyrotherm_precompile(${name} ${name})
    target_precompile_headers(gyrotherm_${name} PRIVATE <analysis/dense/dense.hpp>)
  else()
    gyrotherm_precompile(${name} tracking)
  endif()
endfunction()

# Gives a module that computes its own optimisation, whatever the other modules have.
function(gyrotherm_computes target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:${GYROTHERM_COMPUTING}>)
endfunction()

function(gyrotherm_module name)
  cmake_parse_arguments(module "INTERNAL;NUMERICAL;COMPUTES" "" "SOURCES;ALONE;USES;PUBLIC;PRIVATE" ${ARGN})
  add_library(gyrotherm_${name} STATIC ${module_SOURCES})
  add_library(gyrotherm::${name} ALIAS gyrotherm_${name})
  set_source_files_properties(${module_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  gyrotherm_options(gyrotherm_${name})
  if(module_NUMERICAL)
    if(NOT name STREQUAL "dense")
      list(APPEND module_USES dense)
    endif()
    gyrotherm_precompile_numerical(${name})
    gyrotherm_computes(gyrotherm_${name})
    target_compile_definitions(gyrotherm_${name} PRIVATE $<$<CONFIG:Release>:EIGEN_NO_DEBUG>)
  elseif(module_COMPUTES)
    gyrotherm_precompile(${name} ${name})  # GCC 12 crashes on a header that was precompiled with another -O
    gyrotherm_computes(gyrotherm_${name})
  else()
    gyrotherm_precompile(${name} drivers ${module_PUBLIC} ${module_PRIVATE})
  endif()
  target_link_libraries(gyrotherm_${name} PRIVATE ${module_PRIVATE})
  target_link_libraries(gyrotherm_${name} PUBLIC fmt::fmt ${module_PUBLIC})
  foreach(other IN LISTS module_USES)
    target_link_libraries(gyrotherm_${name} PUBLIC gyrotherm::${other})
  endforeach()
  if(NOT module_INTERNAL)
    gyrotherm_package_module(${name} USES ${module_USES} THIRD_PARTIES fmt::fmt ${module_PUBLIC} ${module_PRIVATE})
  endif()
endfunction()

# Compiles a test without optimisation, in half the time. The modules that it tests stay optimised.
function(gyrotherm_unoptimised target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O0>)
endfunction()

# Compiles each source of a target by itself, because its files use the same local names. CMAKE_UNITY_BUILD compiles the
# files of other targets together, in a third of the time.
function(gyrotherm_file_by_file target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
endfunction()

# Compiles the headers that most tests include once.
function(gyrotherm_precompile_test name first)
  if(name STREQUAL first)
    target_precompile_headers(${name}_test PRIVATE <gtest/gtest.h> ${ARGN})
  else()
    target_precompile_headers(${name}_test REUSE_FROM ${first}_test)
  endif()
endfunction()

# gyrotherm_test(NAME [COMPUTES [NUMERICAL]] USES modules … SOURCES … [PRIVATE third parties …] [TOGETHER suites …]) makes
# NAME_test and registers each of its tests with CTest; each suite in TOGETHER is registered as one. A unity build
# compiles more files of a test together than of a module, because they instantiate the same templates.
function(gyrotherm_test name)
  cmake_parse_arguments(test "COMPUTES;NUMERICAL" "" "USES;SOURCES;PRIVATE;TOGETHER" ${ARGN})
  add_executable(${name}_test ${test_SOURCES})
  set_target_properties(${name}_test PROPERTIES UNITY_BUILD_BATCH_SIZE 64)
  gyrotherm_options(${name}_test)
  if(NOT test_COMPUTES)
    gyrotherm_unoptimised(${name}_test)
    gyrotherm_precompile_test(${name} core)
  else()
    # Compiles in three quarters of the time; GCC 12 then takes vectors of Eigen for freed or not initialised.
    target_compile_options(${name}_test PRIVATE $<$<CONFIG:Release>:-O1>
      $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-use-after-free>)
    if(test_NUMERICAL)
      gyrotherm_precompile_test(${name} analysis <Eigen/Dense> <analysis/dense/dense.hpp>)
    else()
      gyrotherm_precompile_test(${name} run)
    endif()
  endif()
  list(TRANSFORM test_USES PREPEND gyrotherm::)
  target_link_libraries(${name}_test PRIVATE ${test_USES} ${test_PRIVATE} GTest::gtest_main)
  target_compile_definitions(${name}_test PRIVATE GYROTHERM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  gyrotherm_discover(${name}_test TOGETHER ${test_TOGETHER})
endfunction()

# gyrotherm_discover(PROGRAM [TOGETHER suites …] [WAITING suites …]) registers each test of a program. A suite in TOGETHER
# runs as one test, because its fixture takes long to make. Suites that share such a fixture are joined by colons, and the
# test has the name of the first. A test counts as 2 PROCESSORS, or as 1 if its suite is WAITING for clocks and other
# programs most of the time. The test preset runs 12 of these units at once on two processors, waiting and long tests first.
function(gyrotherm_discover program)
  cmake_parse_arguments(suites "" "" "TOGETHER;WAITING" ${ARGN})
  list(TRANSFORM suites_TOGETHER REPLACE ":" ".*:")
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
    string(REGEX REPLACE "[.].*" "" name ${suite})
    add_test(NAME ${name} COMMAND ${program} --gtest_filter=${suite}.*)
    set_tests_properties(${name} PROPERTIES TIMEOUT ${GYROTHERM_TIMEOUT} PROCESSORS 2 COST 20)
  endforeach()
endfunction()

# gyrotherm_fuzz(NAME SOURCE … libraries …) adds the fuzz target fuzz_NAME of fuzz_NAME.cpp among the sources. With
# GYROTHERM_FUZZ it is a libFuzzer program, built by the target `fuzzers`; the modules are instrumented too
# (CMakeLists.txt). Otherwise it is a part of fuzz_test, which runs a short seeded random run of it under CTest.
function(gyrotherm_fuzz name)
  set(sources ${ARGN})
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  set(libraries ${ARGN})
  list(FILTER libraries EXCLUDE REGEX "\\.cpp$")
  if(GYROTHERM_FUZZ)
    add_executable(fuzz_${name} ${sources})
    gyrotherm_options(fuzz_${name})
    target_compile_definitions(fuzz_${name} PRIVATE GYROTHERM_LIBFUZZER GYROTHERM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    target_compile_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
    target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
    target_link_libraries(fuzz_${name} PRIVATE ${libraries})
    add_dependencies(fuzzers fuzz_${name})
  else()
    target_sources(fuzz_test PRIVATE ${sources})
    target_link_libraries(fuzz_test PRIVATE ${libraries})
    add_test(NAME Fuzz.${name} COMMAND fuzz_test ${name} $<IF:$<BOOL:${GYROTHERM_NIGHTLY}>,1000000,2000>)
    set_tests_properties(Fuzz.${name} PROPERTIES TIMEOUT ${GYROTHERM_TIMEOUT} PROCESSORS 2)
  endif()
endfunction()

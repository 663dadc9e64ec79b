# Build rules shared by every folder: flags, packages, and the two functions with which a folder declares itself.
# Sources and links are listed by hand in each folder, so an include of a library that is not linked does not link.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

find_program(CCACHE ccache)
if(CCACHE)
  # Precompiled headers need these two for ccache to hit (ccache manual, "Precompiled headers").
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-fpch-preprocess)
  endif()
endif()

add_library(axiscal_flags INTERFACE)
target_compile_options(axiscal_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wno-unused-parameter -Werror)
target_include_directories(axiscal_flags INTERFACE ${CMAKE_SOURCE_DIR})

set(AXISCAL_SANITIZE "" CACHE STRING "Sanitizers, e.g. address,undefined or thread")
if(AXISCAL_SANITIZE)
  add_compile_options(-fsanitize=${AXISCAL_SANITIZE} -fno-omit-frame-pointer -O1 -g)
  add_link_options(-fsanitize=${AXISCAL_SANITIZE})
  # GCC's uninitialised-use analysis reports false positives inside instrumented Eigen code.
  target_compile_options(axiscal_flags INTERFACE -Wno-maybe-uninitialized)
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED)
find_package(Ceres REQUIRED)
find_package(absl REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
include(GoogleTest)

# axiscal_library(name SOURCES a.cc ... [DEPS lib ...] [PCH header ...]): static library axiscal_<name>.
function(axiscal_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS;PCH" ${ARGN})
  if(ARG_SOURCES)
    add_library(axiscal_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(axiscal_${name} PUBLIC axiscal_flags ${ARG_DEPS})
    if(ARG_PCH)
      target_precompile_headers(axiscal_${name} PRIVATE ${ARG_PCH})
    endif()
  else()
    add_library(axiscal_${name} INTERFACE)
    target_link_libraries(axiscal_${name} INTERFACE axiscal_flags ${ARG_DEPS})
  endif()
endfunction()

# axiscal_test(name SOURCES a_test.cc ... [DEPS lib ...] [PCH header ...]): one test program per folder; ctest names are <name>/<Suite.Case>.
# AXISCAL_SOURCE_DIR is the checkout, for test data. ../shared/ may be absent: tests that use it in place skip.
function(axiscal_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPS;PCH" ${ARGN})
  string(REPLACE "/" "_" target ${name})
  add_executable(${target}_test ${ARG_SOURCES})
  target_link_libraries(${target}_test PRIVATE axiscal_flags ${ARG_DEPS} GTest::gmock GTest::gtest GTest::gtest_main)
  target_compile_definitions(${target}_test PRIVATE AXISCAL_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  target_precompile_headers(${target}_test PRIVATE <gtest/gtest.h> <gmock/gmock.h> ${ARG_PCH})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  gtest_discover_tests(${target}_test TEST_PREFIX ${name}/ DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()

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
# For sources whose inner loops are what the user waits for (axiscal_compile_with), and those that run for every block of an NC program: their
# choice of instructions is tuned for servers since 2017, they run on all.
set(AXISCAL_HOT "$<$<CONFIG:Release>:-O3;-fno-math-errno>")
set(AXISCAL_FAST "${AXISCAL_HOT}")
if(CMAKE_SYSTEM_PROCESSOR STREQUAL x86_64)
  string(REPLACE "-O3" "-O3;-mtune=skylake" AXISCAL_FAST "${AXISCAL_FAST}")
endif()
# axiscal_compile_with(options a.cc ...): no precompiled header fits, as it is made with other options.
function(axiscal_compile_with options)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "${options}" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

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
target_compile_options(axiscal_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wno-unused-parameter)
# Warnings are errors of the compiler that the product is built with; clang, which builds the fuzz targets only, knows others.
if(NOT AXISCAL_FUZZ)
  target_compile_options(axiscal_flags INTERFACE -Werror)
endif()
target_include_directories(axiscal_flags INTERFACE ${CMAKE_SOURCE_DIR})

set(AXISCAL_SANITIZE "" CACHE STRING "Sanitizers, e.g. address,undefined or thread")
if(AXISCAL_SANITIZE)
  # What is found ends the program. Null pointers, accesses that are not aligned and those beyond an object are left to AddressSanitizer:
  # checks of every access by UndefinedBehaviorSanitizer, too, take nearly half of the compiler's time.
  add_compile_options(-fsanitize=${AXISCAL_SANITIZE} -fno-sanitize=null,alignment,object-size -fno-sanitize-recover=all -fno-omit-frame-pointer
                      -O1 -g1)
  add_link_options(-fsanitize=${AXISCAL_SANITIZE})
  # GCC's uninitialised-use analysis reports false positives inside instrumented Eigen code.
  target_compile_options(axiscal_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED)
find_package(Ceres REQUIRED)
find_package(Boost REQUIRED)
find_package(absl REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(GTest)
find_package(Protobuf REQUIRED)
find_package(gRPC CONFIG REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(benchmark)
find_package(OpenSSL REQUIRED)
find_package(CURL REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(prometheus-cpp CONFIG REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(ISAL REQUIRED IMPORTED_TARGET libisal)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(LIBPQ REQUIRED IMPORTED_TARGET libpq)
pkg_check_modules(PANGOCAIRO REQUIRED IMPORTED_TARGET pangocairo)
# Its headers alone are used (core/base/toml.cc).
pkg_check_modules(TOMLPLUSPLUS REQUIRED tomlplusplus)
include(GoogleTest)
# All tests with -pthread, as gRPC asks for it: with and without it no precompiled header is one.
if(GTest_FOUND)
  file(CONFIGURE OUTPUT test_headers.cc CONTENT "")
  add_library(axiscal_test_headers OBJECT ${CMAKE_BINARY_DIR}/test_headers.cc)
  target_link_libraries(axiscal_test_headers PRIVATE axiscal_flags GTest::gmock GTest::gtest)
  target_compile_options(axiscal_test_headers PRIVATE -pthread)
  target_precompile_headers(axiscal_test_headers PRIVATE <gtest/gtest.h> <gmock/gmock.h>)
endif()
# The demo needs no tests, and install-deps without --tests installs nothing for them.
if(GTest_FOUND AND benchmark_FOUND)
  set(AXISCAL_TESTS ON)
else()
  set(AXISCAL_TESTS OFF)
  message(STATUS "Tests and benchmarks are left out: GoogleTest or benchmark is missing (deploy/install-deps --tests)")
endif()

# Half of the compiler's time went into the same headers (Eigen, Abseil, Protobuf) and the same instances of Eigen's templates, source after
# source. So several sources of a library are compiled in one go: six, or UNITY n where a library says so. n is chosen so that one go takes
# half a minute at most, which is what a change of one line costs. Names of a library's sources must not clash therefore, those in anonymous
# namespaces included. Sources with options of their own stay alone. With AXISCAL_UNITY=OFF every source is compiled alone, which shows what
# it forgot to include.
option(AXISCAL_UNITY "Compile several sources of a library in one go" ON)

# axiscal_library(name SOURCES a.cc ... [DEPS lib ...] [PCH header ...] [PCH_OF name] [UNITY n]): static library axiscal_<name>. PCH_OF: with the
# precompiled header of that library, which it links.
function(axiscal_library name)
  cmake_parse_arguments(ARG "" "UNITY;PCH_OF" "SOURCES;DEPS;PCH" ${ARGN})
  if(ARG_SOURCES)
    add_library(axiscal_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(axiscal_${name} PUBLIC axiscal_flags ${ARG_DEPS})
    if(NOT ARG_UNITY)
      set(ARG_UNITY 6)
    endif()
    if(AXISCAL_UNITY)
      set_target_properties(axiscal_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ARG_UNITY})
    endif()
    if(ARG_PCH)
      target_precompile_headers(axiscal_${name} PRIVATE ${ARG_PCH})
    elseif(ARG_PCH_OF)
      target_precompile_headers(axiscal_${name} REUSE_FROM axiscal_${ARG_PCH_OF})
    endif()
  else()
    add_library(axiscal_${name} INTERFACE)
    target_link_libraries(axiscal_${name} INTERFACE axiscal_flags ${ARG_DEPS})
  endif()
endfunction()

add_custom_target(threads)

# axiscal_test(name SOURCES a_test.cc ... [ALONE a_test.cc ...] [DEPS lib ...] [PCH header ...] [LABEL label]): one test program per folder;
# ctest names are <name>/<Suite.Case>. ALONE: sources whose helpers have the names of another's, compiled one by one; all others in one go,
# UNITY (4) at a time. Label: slow, left out where a sanitizer makes every test ten times slower (the targets fast-core, fast-server ... build
# what is left of a top-level folder); threads, run under ThreadSanitizer too (the target of that name builds them).
function(axiscal_test name)
  if(NOT AXISCAL_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "TIMEOUT;LABEL;UNITY" "SOURCES;ALONE;DEPS;PCH" ${ARGN})
  string(REPLACE "/" "_" target ${name})
  add_executable(${target}_test ${ARG_SOURCES} ${ARG_ALONE})
  if(AXISCAL_UNITY)
    if(NOT ARG_UNITY)
      set(ARG_UNITY 4)
    endif()
    set_target_properties(${target}_test PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ARG_UNITY})
    set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
  target_link_libraries(${target}_test PRIVATE axiscal_flags ${ARG_DEPS} axiscal_source_path GTest::gmock GTest::gtest GTest::gtest_main)
  target_compile_options(${target}_test PRIVATE -pthread)
  if(ARG_PCH)
    target_precompile_headers(${target}_test PRIVATE <gtest/gtest.h> <gmock/gmock.h> ${ARG_PCH})
  else()
    target_precompile_headers(${target}_test REUSE_FROM axiscal_test_headers)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  gtest_discover_tests(${target}_test TEST_PREFIX ${name}/ DISCOVERY_MODE PRE_TEST NO_PRETTY_VALUES
                       PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABEL}")
  if(ARG_LABEL STREQUAL threads)
    add_dependencies(threads ${target}_test)
  endif()
  if(NOT ARG_LABEL STREQUAL slow)
    file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
    string(REGEX MATCH "^[a-z]+" room ${folder})
    if(NOT TARGET fast-${room})
      add_custom_target(fast-${room})
    endif()
    add_dependencies(fast-${room} ${target}_test)
  endif()
endfunction()

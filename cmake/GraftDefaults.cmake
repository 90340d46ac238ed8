# SPDX-License-Identifier: BSD-3-Clause
# What every target of the project shares: language level, warnings, sanitizers,
# compiler cache and where results go.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
set(GRAFT_PLUGIN_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib/graft/plugins")

include(GNUInstallDirs)
set(GRAFT_PLUGIN_INSTALL_DIR "${CMAKE_INSTALL_LIBDIR}/graft/plugins")

option(GRAFT_WERROR "Treat warnings as errors" OFF)
set(GRAFT_SANITIZE "" CACHE STRING "Sanitizers, e.g. address,undefined or thread")
option(GRAFT_FUZZ "Instrument everything for libFuzzer and build tests/fuzz (clang)" OFF)
if(GRAFT_FUZZ)
  set(GRAFT_SANITIZE "fuzzer-no-link,address,undefined")
endif()

find_program(GRAFT_CCACHE ccache)
if(GRAFT_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${GRAFT_CCACHE}")
  set(CMAKE_C_COMPILER_LAUNCHER "${GRAFT_CCACHE}")
endif()

# Options of our own code; kept off imported and installed targets.
add_library(graft_options INTERFACE)
target_compile_options(graft_options INTERFACE
  -Wall -Wextra -Wpedantic
  # Results must not depend on which products the compiler fuses.
  -ffp-contract=off)
if(GRAFT_WERROR)
  target_compile_options(graft_options INTERFACE -Werror)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 reports false positives inside Eigen's fixed-size kernels.
  target_compile_options(graft_options INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-Wno-maybe-uninitialized>
    $<$<COMPILE_LANGUAGE:CXX>:-Wno-array-bounds>)
endif()
if(GRAFT_SANITIZE)
  # Instrumented templates take half the time and two thirds of the memory to
  # compile at -O1 and with line tables only.
  add_compile_options(-O1 -g1)
  add_compile_options(-fsanitize=${GRAFT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${GRAFT_SANITIZE})
else()
  add_compile_options($<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=2> -fstack-protector-strong)
  add_link_options(-Wl,-z,relro,-z,now)
endif()

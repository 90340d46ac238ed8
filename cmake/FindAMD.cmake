# SPDX-License-Identifier: BSD-3-Clause
# SuiteSparse's AMD (BSD-3-Clause): approximate minimum degree ordering.
# Defines AMD_FOUND and the target AMD::AMD.
find_path(AMD_INCLUDE_DIR amd.h PATH_SUFFIXES suitesparse)
find_library(AMD_LIBRARY amd)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(AMD REQUIRED_VARS AMD_LIBRARY AMD_INCLUDE_DIR)
if(AMD_FOUND AND NOT TARGET AMD::AMD)
  add_library(AMD::AMD UNKNOWN IMPORTED)
  set_target_properties(AMD::AMD PROPERTIES IMPORTED_LOCATION "${AMD_LIBRARY}")
  target_include_directories(AMD::AMD SYSTEM INTERFACE "${AMD_INCLUDE_DIR}")
endif()
mark_as_advanced(AMD_INCLUDE_DIR AMD_LIBRARY)

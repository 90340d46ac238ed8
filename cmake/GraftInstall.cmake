# SPDX-License-Identifier: BSD-3-Clause
# What is installed: library, headers, build tool and CMake package. Programs and
# plugins install themselves. The tree may be moved after installation.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/graft")

install(TARGETS graft_core graft_sdk EXPORT graftTargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}")
install(TARGETS graft_plugin_metadata EXPORT graftTargets
  RUNTIME DESTINATION "${CMAKE_INSTALL_LIBEXECDIR}/graft")
install(EXPORT graftTargets NAMESPACE graft:: DESTINATION "${package_dir}")

install(DIRECTORY "${PROJECT_SOURCE_DIR}/core" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/graft"
  FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/graftConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/graftConfig.cmake"
  INSTALL_DESTINATION "${package_dir}"
  PATH_VARS GRAFT_PLUGIN_INSTALL_DIR)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/graftConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES
  "${PROJECT_BINARY_DIR}/graftConfig.cmake"
  "${PROJECT_BINARY_DIR}/graftConfigVersion.cmake"
  "${PROJECT_SOURCE_DIR}/cmake/GraftPlugin.cmake"
  "${PROJECT_SOURCE_DIR}/cmake/graft_plugin.map"
  DESTINATION "${package_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")

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

# The public headers: those that core/README.md names as entries, and what they include.
# Everything else may change at any time and is not installed; a test compares.
set(public_headers
  core/base/error.hpp
  core/base/text.hpp
  core/geometry/dual.hpp
  core/geometry/euler.hpp
  core/geometry/point.hpp
  core/geometry/se2.hpp
  core/geometry/se3.hpp
  core/geometry/so3.hpp
  core/graph/factor_graph.hpp
  core/graph/graph.hpp
  core/graph/information_policy.hpp
  core/graph/values.hpp
  core/io/g2o_writer.hpp
  core/io/graph_loader.hpp
  core/io/trajectory.hpp
  core/plugin/engine.hpp
  core/plugin/plugin_file.hpp
  core/plugin/plugin_manager.hpp
  core/solve/covariance.hpp
  core/solve/evaluation.hpp
  core/solve/optimizer.hpp
  core/solve/options.hpp
  core/solve/summary.hpp
  core/types/abi.h
  core/types/batch.hpp
  core/types/dynamic_edge.hpp
  core/types/edge.hpp
  core/types/one_to_many_edge.hpp
  core/types/plugin.hpp
  core/types/registry.hpp
  core/types/relaxation.hpp
  core/types/resource.hpp
  core/types/stamp.hpp
  core/types/vertex.hpp)
foreach(header IN LISTS public_headers)
  get_filename_component(folder "${header}" DIRECTORY)
  install(FILES "${PROJECT_SOURCE_DIR}/${header}"
          DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/graft/${folder}")
endforeach()

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

# SPDX-License-Identifier: BSD-3-Clause
#
#   graft_add_plugin(name SOURCES file...
#                    [LIBRARIES target...] [REQUIRES plugin...]
#                    [LICENSE id] [VERSION x.y.z] [DESCRIPTION text]
#                    [OUTPUT_DIRECTORY dir] [NO_INSTALL])
#
# Builds libgraft_<name>.so, target graft_plugin_<name>. The source that has
# GRAFT_PLUGIN(name, registry) defines what it provides. After linking, the
# list of what it registers is stored in the file, so that graft knows it
# without loading it. Only the stamp and the entry function are exported.
#
#   graft_add_conformance_test(name [GRAPH file] [PLUGINS name...] [ARGUMENTS arg...])
#
# Adds the test conformance.<name>: `graft check-plugin` on the plugin. GRAPH is a
# graph file whose resources, measurements and estimates are inputs, too; PLUGINS
# are further plugins of this build that it requires.
#
# Both work inside graft's own tree and outside after find_package(graft).

set(GRAFT_PLUGIN_CMAKE_DIR "${CMAKE_CURRENT_LIST_DIR}")

function(graft_add_plugin name)
  cmake_parse_arguments(arg "NO_INSTALL" "LICENSE;VERSION;DESCRIPTION;OUTPUT_DIRECTORY"
                        "SOURCES;LIBRARIES;REQUIRES" ${ARGN})
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "graft_add_plugin(${name}): unknown arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT arg_SOURCES)
    message(FATAL_ERROR "graft_add_plugin(${name}): SOURCES is missing")
  endif()
  if(NOT name MATCHES "^[a-z][a-z0-9_]*$")
    message(FATAL_ERROR "graft_add_plugin(${name}): a name is lower case letters, digits and _")
  endif()
  if(NOT arg_LICENSE)
    set(arg_LICENSE "BSD-3-Clause")
  endif()
  if(NOT arg_VERSION)
    set(arg_VERSION "${PROJECT_VERSION}")
  endif()
  if(NOT arg_VERSION)
    set(arg_VERSION "0")
  endif()
  if(NOT arg_OUTPUT_DIRECTORY)
    set(arg_OUTPUT_DIRECTORY "${GRAFT_PLUGIN_OUTPUT_DIRECTORY}")
  endif()
  if(NOT arg_OUTPUT_DIRECTORY)
    set(arg_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
  endif()
  string(REPLACE ";" " " required "${arg_REQUIRES}")

  set(target graft_plugin_${name})
  add_library(${target} MODULE ${arg_SOURCES})
  target_compile_features(${target} PRIVATE cxx_std_17)
  target_compile_definitions(${target} PRIVATE
    "GRAFT_PLUGIN_VERSION=\"${arg_VERSION}\""
    "GRAFT_PLUGIN_LICENSE=\"${arg_LICENSE}\""
    "GRAFT_PLUGIN_REQUIRES=\"${required}\"")
  target_link_libraries(${target} PRIVATE graft::sdk ${arg_LIBRARIES})
  if(TARGET graft_options)
    target_link_libraries(${target} PRIVATE graft_options)
  endif()
  set(exports "${GRAFT_PLUGIN_CMAKE_DIR}/graft_plugin.map")
  target_link_options(${target} PRIVATE "-Wl,--version-script=${exports}")
  if(NOT GRAFT_SANITIZE)
    # Sanitized libraries leave the runtime's symbols to the program.
    target_link_options(${target} PRIVATE "-Wl,--no-undefined")
  endif()
  set_target_properties(${target} PROPERTIES
    PREFIX "lib"
    OUTPUT_NAME "graft_${name}"
    SUFFIX ".so"
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    POSITION_INDEPENDENT_CODE ON
    LINK_DEPENDS "${exports}"
    LIBRARY_OUTPUT_DIRECTORY "${arg_OUTPUT_DIRECTORY}")

  set(metadata "${CMAKE_CURRENT_BINARY_DIR}/graft_${name}.meta")
  add_custom_command(TARGET ${target} POST_BUILD
    COMMAND $<TARGET_FILE:graft::plugin_metadata> $<TARGET_FILE:${target}> > "${metadata}"
    COMMAND "${CMAKE_OBJCOPY}" --add-section ".graft.meta=${metadata}"
            --set-section-flags ".graft.meta=noload,readonly" $<TARGET_FILE:${target}>
    COMMENT "Listing what plugin ${name} provides"
    VERBATIM)
  add_dependencies(${target} graft::plugin_metadata)

  if(GRAFT_PLUGIN_INSTALL_DIR AND NOT arg_NO_INSTALL)
    install(TARGETS ${target} LIBRARY DESTINATION "${GRAFT_PLUGIN_INSTALL_DIR}" COMPONENT ${name})
  endif()
endfunction()

function(graft_add_conformance_test name)
  cmake_parse_arguments(arg "" "GRAPH" "PLUGINS;ARGUMENTS" ${ARGN})
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR
      "graft_add_conformance_test(${name}): unknown arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT TARGET graft_plugin_${name})
    message(FATAL_ERROR "graft_add_conformance_test(${name}): there is no plugin ${name}")
  endif()
  set(arguments "")
  if(arg_GRAPH)
    list(APPEND arguments --graph "${arg_GRAPH}")
  endif()
  foreach(plugin IN LISTS arg_PLUGINS)
    list(APPEND arguments --plugin $<TARGET_FILE:graft_plugin_${plugin}>)
  endforeach()
  add_test(NAME conformance.${name}
    COMMAND $<TARGET_FILE:graft::program> check-plugin $<TARGET_FILE:graft_plugin_${name}>
            ${arguments} ${arg_ARGUMENTS})
  set_tests_properties(conformance.${name} PROPERTIES TIMEOUT 600)
endfunction()

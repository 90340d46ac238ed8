# SPDX-License-Identifier: BSD-3-Clause
# tests/run.sh builds and runs the tests also in a folder that was configured without them
# (as apps/demo.sh does), and says so where none are found: a copy of it is run with
# programs that only write down how they were called.
# Usage: cmake -DSOURCE=... -DWORK=... -P check_runner.cmake
file(REMOVE_RECURSE ${WORK})
file(COPY ${SOURCE}/tests/run.sh DESTINATION ${WORK}/tests)
file(WRITE ${WORK}/.ci/packages.sh "exit 0\n")
foreach(program cmake ctest)
  file(WRITE ${WORK}/bin/${program} "#!/bin/sh\necho ${program} \"$@\" >>'${WORK}/calls'\n")
  file(CHMOD ${WORK}/bin/${program} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endforeach()
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env "PATH=${WORK}/bin:$ENV{PATH}" --unset=BUILD_DIR --unset=TARGETS
          bash ${WORK}/tests/run.sh -R some
  RESULT_VARIABLE result)
file(STRINGS ${WORK}/calls calls)
foreach(wanted "^cmake .*-DGRAFT_BUILD_TESTS=ON" "^cmake --build build --target all"
        "^ctest .*--no-tests=error.* -R some")
  set(found ${calls})
  list(FILTER found INCLUDE REGEX "${wanted}")
  if(NOT found)
    message(SEND_ERROR "tests/run.sh makes no call '${wanted}', but: ${calls}")
  endif()
endforeach()
if(NOT result EQUAL 0)
  message(SEND_ERROR "tests/run.sh ends with ${result}")
endif()

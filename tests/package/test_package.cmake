# Installs the build tree `build` below `folder`, and there configures, builds and runs the project outside/ against what was installed.
cmake_minimum_required(VERSION 3.25)
set(prefix "${folder}/prefix")
set(project "${folder}/outside")
# Nothing of an earlier round helps.
file(REMOVE_RECURSE "${prefix}" "${project}")

function(run)
    list(JOIN ARGN " " words)
    message(STATUS "${words}")
    execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install "${build}" --prefix "${prefix}")
file(GLOB entries RELATIVE "${prefix}/include" "${prefix}/include/*" "${prefix}/include/palpate/*")
if(NOT entries STREQUAL "palpate;palpate/devices;palpate/planner;palpate/sim")
    message(FATAL_ERROR "other headers are installed than those of three libraries: ${entries}")
endif()
run(${CMAKE_COMMAND} -S "${CMAKE_CURRENT_LIST_DIR}/outside" -B "${project}" -G "${generator}"
    -D "CMAKE_PREFIX_PATH=${prefix}" -D "CMAKE_CXX_COMPILER=${compiler}" -D "CMAKE_CXX_COMPILER_LAUNCHER=${launcher}" -D "CMAKE_CXX_FLAGS=${flags}")
run(${CMAKE_COMMAND} --build "${project}" --parallel 2)
run("${project}/own_oracle")
run("${project}/own_device")
run("${project}/whole_package")
